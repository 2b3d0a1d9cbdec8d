// Invalid scenes are refused.
#include "enamel/collision/scene.hpp"

#include "enamel/collision/tool_sweep.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"

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

TEST_CASE("a tool that is nowhere has no contacts, whatever the query", "[unit]") {
  Scene scene = flatWall();
  scene.add({"ball", std::make_shared<const MeshModel>(test::ball(2)), Pose(), Vec6::Zero(), {}});
  const Tool tool = sphereTool(0.1);
  ToolTrack track = makeToolTrack(scene, tool);
  for (const Vec3& place : {Vec3(0, 0, 1e300), Vec3(-1.7e308, 0, 0), Vec3(0, 2e7, 0), Vec3(0, 0, -1e100)}) {
    ContactSnapshot contacts;
    contacts.count = 5;
    CHECK(findContacts(scene, tool, at(place), 0.1, nullptr, contacts) == Status::outOfRange);
    CHECK(contacts.count == 0);
    contacts.count = 5;
    CHECK(followContacts(scene, tool, at(place), 0.1, track, contacts) == Status::outOfRange);
    CHECK(contacts.count == 0);
    CHECK(nearestContact(scene, tool, at(place), nullptr).gap == kNoLimit);
    CHECK(sweepTool(scene, tool, at(place), at({0, 0, 1}), nullptr).status == Status::outOfRange);
    CHECK(sweepTool(scene, tool, at({0, 0, 1}), at(place), nullptr).status == Status::outOfRange);
    CHECK_FALSE(sweepTool(scene, tool, at({0, 0, 1}), at(place), nullptr).hit);
  }
  ContactSnapshot contacts;
  CHECK(findContacts(scene, tool, at({0, 0, kFarthestTool}), 0.1, nullptr, contacts) == Status::ok);
  CHECK(findContacts(scene, tool, at({0, 0, 1.05}), 1e300, nullptr, contacts) == Status::ok);
  CHECK(contacts.count >= 2);
  CHECK(nearestContact(scene, tool, at({0, 0, -kFarthestTool}), nullptr).gap == Approx(-kFarthestTool - 0.1));
}

}  // namespace enamel::test_scene
