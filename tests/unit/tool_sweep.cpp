// First touches of moving tools.
#include "enamel/collision/tool_sweep.hpp"

#include "enamel/collision/solid.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"

namespace enamel::test_tool_sweep {
using test::at;
using test::sphereTool;

namespace {

std::shared_ptr<const MeshModel> model(const TriangleMesh& mesh) { return std::make_shared<const MeshModel>(mesh); }

}  // namespace

TEST_CASE("a swept tool tells what of it touches what", "[unit]") {
  test::Random random(508);
  Scene scene;
  scene.add({"wavy", model(test::transformed(test::ball(1, 0.1), 0.01, Vec3::Zero())), Pose(), Vec6::Zero(), {}});
  scene.add({"box", Box{{0.003, 0.002, 0.004}}, at({0.02, 0, 0}), Vec6::Zero(), {}});
  Tool tool = sphereTool(0.003);
  tool.parts[1] = {{0, 0, 0.002}, {0, 0.001, 0.012}, 0.0005};
  tool.count = 2;
  ToolCache cache = makeToolCache(scene, tool);
  int met[2][3] = {}, parts[2] = {};
  for (int i = 0; i < 4000; ++i) {
    const Pose from{0.03 * random.direction(), random.rotation(3.0)};
    const Pose to{from.position + 0.06 * random.direction(),
                  test::rotationAbout(random.direction(), 0.5) * from.rotation};
    const ToolSweep hit = sweepTool(scene, tool, from, to, nullptr), cached = sweepTool(scene, tool, from, to, &cache);
    REQUIRE(hit.hit == cached.hit);
    REQUIRE(hit.time == cached.time);
    if (!hit.hit) continue;
    REQUIRE(test::areEqual(hit.contact, cached.contact));
    REQUIRE(test::distanceFromFeature(scene, hit.contact, hit.contact.point) < 1e-15);  // rounding of 0.03 m
    ++met[hit.contact.obstacle][static_cast<int>(hit.contact.feature)];
    ++parts[hit.contact.part];
    if (hit.time == 0.0) continue;
    // The ends of the part move straight: its axis is one radius away from the point.
    const ToolPart& part = tool.parts[hit.contact.part];
    const auto there = [&](const Vec3& p) {
      const Vec3 first = from.rotation * p + from.position, last = to.rotation * p + to.position;
      return Vec3(first + hit.time * (last - first));
    };
    const Vec3 a = there(part.a), b = there(part.b);
    // The time is exact to 1e-12 of the path if the surface is hit at an angle, and to 1e-6 if it is grazed.
    REQUIRE(std::abs(test::referenceDistance(hit.contact.point, a, b, b) - part.radius) < 1e-6 * 0.06);
  }
  for (const auto& obstacle : met)
    for (const int feature : obstacle) CHECK(feature > 5);
  for (const int part : parts) CHECK(part > 20);
}

TEST_CASE("a swept tool stops at the first obstacle", "[unit]") {
  Scene scene;
  scene.add({"far wall", HalfSpace{}, at({0, 0, -0.01}), Vec6::Zero(), {7.0}});
  scene.add({"plate", model(test::boxMesh({0.05, 0.05, 1e-6})), Pose(), Vec6::Zero(), {8.0}});
  Tool tool = sphereTool(0.001);
  const ToolSweep hit = sweepTool(scene, tool, at({0, 0, 0.02}), at({0.001, 0, -0.02}), nullptr);
  REQUIRE(hit.hit);
  CHECK(hit.contact.material.stiffness == 8.0);
  CHECK(hit.time == Approx((0.02 - 0.001 - 1e-6) / 0.04).epsilon(1e-9));
  CHECK(hit.contact.normal.z() == Approx(1.0));
  CHECK_FALSE(sweepTool(scene, tool, at({0, 0, 0.02}), at({0.01, 0, 0.0011}), nullptr).hit);
  const ToolSweep wall = sweepTool(scene, tool, at({0.2, 0, 0.02}), at({0.2, 0, -0.02}), nullptr);
  REQUIRE(wall.hit);
  CHECK(wall.contact.material.stiffness == 7.0);
  CHECK(wall.time == Approx(0.029 / 0.04).epsilon(1e-12));
  // A shaft that rotates into the wall: its far end touches.
  tool.parts[0] = {{0, 0, 0}, {0.02, 0, 0}, 0.0};
  Pose turned = at({0.2, 0, 0.0});
  turned.rotation = test::rotationAbout(Vec3::UnitY(), 1.2);
  const ToolSweep turn = sweepTool(scene, tool, at({0.2, 0, 0.0}), turned, nullptr);
  REQUIRE(turn.hit);
  CHECK(std::abs(turn.contact.point.z() + 0.01) < 1e-9);
  CHECK(turn.time < 1.0);
}

TEST_CASE("close along a solid, a swept tool takes 64 looks at most and then counts as touching", "[unit]") {
  const Vec3 half(3e-3, 2e-3, 1.5e-3);
  const std::vector<SolidLayer> layers = {{"enamel", {}, 3.4e9, 0.0, nullptr}};
  Scene scene;
  scene.add({"block",
             std::make_shared<const Solid>(MeshModel(test::boxMesh(half)), layers, SolidOptions{1e-4}),
             Pose(),
             Vec6::Zero(),
             {}});
  const double radius = 0.2e-3, path = 2e-3;
  for (const double gap : {1e-6, 1e-5, 4e-5}) {
    INFO("gap " << gap);
    const Pose from = at({-1e-3, 1e-4, half.z() + radius + gap}), to = at(from.position + path * Vec3::UnitX());
    const ToolSweep sweep = sweepTool(scene, sphereTool(radius), from, to, nullptr);
    REQUIRE(sweep.status == Status::ok);
    // Each query clears as much of the path as there is room; the last one decides.
    REQUIRE(sweep.hit == (63.0 * gap < path));
    if (sweep.hit) CHECK(sweep.time == Approx(63.0 * gap / path).epsilon(1e-6));
  }
}

}  // namespace enamel::test_tool_sweep
