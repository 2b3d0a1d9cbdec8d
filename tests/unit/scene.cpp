// What a scene refuses.
#include "enamel/collision/scene.hpp"

#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"

namespace enamel::test_scene {

using test::at;
using test::sphereTool;

TEST_CASE("bad scenes are refused, bad poses reported", "[unit]") {
  Scene scene;
  scene.add({"a", HalfSpace{}, Pose(), Vec6::Zero(), {}});
  CHECK_THROWS_WITH(scene.add({"a", Sphere{}, Pose(), Vec6::Zero(), {}}), test::ContainsSubstring("twice"));
  CHECK_THROWS_AS(scene.add({"", Sphere{}, Pose(), Vec6::Zero(), {}}), Error);
  CHECK_THROWS_AS(scene.add({"b", Sphere{-1.0}, Pose(), Vec6::Zero(), {}}), Error);
  CHECK_THROWS_AS(scene.add({"b", std::shared_ptr<const MeshModel>(), Pose(), Vec6::Zero(), {}}), Error);
  Pose mirrored;
  mirrored.rotation(0, 0) = -1.0;
  CHECK_THROWS_AS(scene.add({"b", Sphere{}, mirrored, Vec6::Zero(), {}}), Error);
  ContactSnapshot contacts;
  contacts.count = 5;
  CHECK(findContacts(scene, sphereTool(1.0), at({0, std::nan(""), 0}), 0.1, nullptr, contacts) == Status::notFinite);
  CHECK(contacts.count == 0);
}

}  // namespace enamel::test_scene
