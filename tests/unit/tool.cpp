// Tools by name: their dimensions follow from their numbers, and they are what a scene file and queries use.
#include "enamel/collision/tool.hpp"

#include <string>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"

namespace enamel::test_tool {

namespace {

std::string digits(int number) {
  const std::string text = std::to_string(number);
  return std::string(3 - text.size(), '0') + text;
}

double lowOf(const ToolPart& part) { return std::min(part.a.z(), part.b.z()) - part.radius; }
double highOf(const ToolPart& part) { return std::max(part.a.z(), part.b.z()) + part.radius; }

bool isSame(const Tool& a, const Tool& b) {
  if (a.count != b.count) return false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i)
    if (a.parts[i].a != b.parts[i].a || a.parts[i].b != b.parts[i].b || a.parts[i].radius != b.parts[i].radius)
      return false;
  return true;
}

}  // namespace

TEST_CASE("tools by name: the number of a bur is the diameter of its head", "[unit]") {
  for (int size = 3; size <= 100; ++size) {
    const Tool tool = toolOf("round-" + digits(size));
    CAPTURE(size);
    REQUIRE(checkTool(tool) == Status::ok);
    CHECK(tool.parts[0].radius == Approx(0.5e-4 * size));
    CHECK((tool.parts[0].a - tool.parts[0].b).norm() < 1e-15);  // a ball
    CHECK(std::abs(lowOf(tool.parts[0])) < 1e-15);              // its lowest point is the TCP
    // Neck and shank do not reach below the head, and no gap is between them.
    for (std::size_t i = 1; i < static_cast<std::size_t>(tool.count); ++i) {
      CHECK(lowOf(tool.parts[i]) > 0.0);
      CHECK(lowOf(tool.parts[i]) < highOf(tool.parts[i - 1]));
      CHECK(highOf(tool.parts[i]) > highOf(tool.parts[i - 1]));
    }
    CHECK(tool.parts[1].radius <= tool.parts[0].radius);
    CHECK(tool.parts[2].radius == 0.8e-3);
  }
  const Tool cylinder = toolOf("cylinder-012-080");
  CHECK(cylinder.parts[0].radius == Approx(0.6e-3));
  CHECK(std::abs(lowOf(cylinder.parts[0])) < 1e-15);
  CHECK(highOf(cylinder.parts[0]) == Approx(8e-3));
  CHECK(isSame(toolOf("cylinder-014-014"), toolOf("round-014")));
  CHECK(isSame(toolOf("cylinder-008-030"), toolOf("bur-245")));
  const Tool probe = toolOf("cpi-probe");
  CHECK(probe.parts[0].radius == 0.25e-3);
  CHECK(std::abs(lowOf(probe.parts[0])) < 1e-15);
  CHECK(highOf(probe.parts[1]) > 11.5e-3);  // its last mark
  for (const char* name : {"cpi-probe", "explorer", "bur-245", "flat-010-030", "cone-009-056-005", "flame-012-080"})
    CHECK(checkTool(toolOf(name)) == Status::ok);
}

TEST_CASE("tools by name: heads of several capsules deviate from their shapes by what the page states", "[unit]") {
  // Distance of a point at a radius and height from the head, in the plane of an angle, m; negative inside.
  const auto distance = [](const Tool& tool, double angle, double radius, double z) {
    const Vec3 p(radius * std::cos(angle), radius * std::sin(angle), z);
    double least = 1.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(tool.head); ++i) {
      const ToolPart& part = tool.parts[i];
      const Vec3 way = part.b - part.a;
      const double share = std::clamp((p - part.a).dot(way) / std::max(way.squaredNorm(), 1e-30), 0.0, 1.0);
      least = std::min(least, (p - part.a - share * way).norm() - part.radius);
    }
    return least;
  };
  constexpr int kSamples = 400;
  for (const int size : {6, 10, 24}) {
    const double radius = 0.5e-4 * size, length = 3.0 * 2.0 * radius;
    const std::string sizes = "-" + digits(size) + "-" + digits(3 * size);
    CAPTURE(size);
    const Tool flat = toolOf("flat" + sizes);
    double furthest = 0.0, inside = 0.0;
    for (int k = 0; k <= kSamples; ++k)
      for (int turn = 0; turn < 72; ++turn) {
        const double angle = 2.0 * M_PI * turn / 72.0, share = static_cast<double>(k) / kSamples;
        for (const double d : {distance(flat, angle, share * radius, 0.0),  // the flat end, then the side
                               distance(flat, angle, radius, share * (length - radius))}) {
          furthest = std::max(furthest, d);
          inside = std::min(inside, d);
        }
      }
    CHECK(furthest < 0.23 * radius);
    CHECK(furthest > 0.22 * radius);  // the number of the page is not too large
    CHECK(inside > -1e-12);          // nothing is outside the shape

    // Balls on the axis. The distance of a ball's surface is at most half a step of the radius; between two balls of a
    // capsule the surface is nearer.
    for (const bool isArc : {false, true}) {
      const double tip = isArc ? 0.25 * radius : 0.5e-4 * (size / 2), step = (radius - tip) / 6.0;
      const Tool tool = toolOf((isArc ? "flame" : "cone") + sizes + (isArc ? "" : "-" + digits(size / 2)));
      const double end = length - (isArc ? radius - step : radius);
      const double widest = isArc ? tip + (end - tip) / (1.0 + std::sqrt(1.0 / 6.0)) : end;
      REQUIRE(tool.head == 6);
      CHECK(std::abs(lowOf(tool.parts[0])) < 1e-15);
      CHECK(highOf(tool.parts[5]) == Approx(length));
      double most = 0.0;
      for (int k = 0; k <= kSamples; ++k) {
        const double centre = tip + (end - tip) * k / kSamples, way = (widest - centre) / (widest - tip);
        const double ball = radius - (radius - tip) * (isArc ? way * way : way);
        double nearest = 1.0;  // to the radius of a capsule that has this centre on its axis
        for (std::size_t i = 0; i < 6; ++i) {
          const ToolPart& part = tool.parts[i];
          const double beside = std::max({0.0, part.a.z() - centre, centre - part.b.z()});
          nearest = std::min(nearest, beside + std::abs(part.radius - ball));
        }
        most = std::max(most, nearest);
      }
      CHECK(most <= 1.001 * step);
      CHECK(most >= 0.499 * step);
      CHECK(std::abs(distance(tool, 0.0, radius, widest)) < 0.51 * step);
    }
  }
}

TEST_CASE("tools by name: a tool touches a wall with its tip, and a second wall with its side", "[unit]") {
  Scene scene;
  scene.add(halfSpace("floor", Vec3::Zero(), Vec3::UnitZ()));
  scene.add(halfSpace("side", Vec3(3e-3, 0.0, 0.0), -Vec3::UnitX()));
  for (const char* name : {"round-010", "cylinder-012-080", "flat-012-080", "cone-012-080-006", "flame-012-080",
                           "bur-245", "cpi-probe", "explorer"}) {
    INFO(name);
    const Tool tool = toolOf(name);
    Pose pose;
    pose.position.z() = 0.5e-3;
    ContactSnapshot contacts;
    REQUIRE(findContacts(scene, tool, pose, 1e-3, nullptr, contacts) == Status::ok);
    REQUIRE(contacts.count >= 1);
    CHECK(contacts.contacts[0].part == 0);
    CHECK(contacts.contacts[0].gap == Approx(0.5e-3));
    double widest = 0.0;
    for (int i = 0; i < tool.count; ++i) widest = std::max(widest, tool.parts[static_cast<std::size_t>(i)].radius);
    pose.position.z() = 0.1;
    CHECK(nearestContact(scene, tool, pose, nullptr).gap == Approx(3e-3 - widest));
  }
}

TEST_CASE("tools by name: in a scene file, and names that are refused", "[unit]") {
  const auto scene = [](const std::string& tool) {
    return parseScene("name = \"a\"\nstart = [0.0, 0.0, 0.01]\ntool = " + tool +
                          "\n[bur]\n[[obstacle]]\nname = \"wall\"\nshape = \"half_space\"\npoint = [0.0, 0.0, 0.0]\n"
                          "normal = [0.0, 0.0, 1.0]\n",
                      "a.toml");
  };
  const SceneFile file = scene("\"round-014\"");
  CHECK(isSame(file.tool, toolOf("round-014")));
  REQUIRE(file.bur);
  CHECK(file.bur->part == 0);
  CHECK(file.tool.head == 1);
  CHECK(scene("\"cone-009-056-005\"").tool.head == 6);
  CHECK_THROWS_WITH(scene("\"round\""), test::ContainsSubstring("a.toml:3") && test::ContainsSubstring("tool") &&
                                            test::ContainsSubstring("\"round\" is not a tool"));
  for (const char* name : {"",
                           "round",
                           "round-",
                           "round-2",
                           "round-002",
                           "round-101",
                           "round-0100",
                           "round-01x",
                           "Round-010",
                           "round-010 ",
                           "cylinder-010",
                           "cylinder-010-009",
                           "cylinder-010-201",
                           "cylinder-010x030",
                           "cylinder-010-30",
                           "245",
                           "probe",
                           "flat-010",
                           "cone-010-030",
                           "cone-010-030-010",
                           "cone-010-030-000",
                           "flame-010-009",
                           "flame-010-030-005"}) {
    INFO(name);
    CHECK_THROWS_WITH(toolOf(name), test::ContainsSubstring(std::string("\"") + name + "\" is not a tool"));
  }
}

}  // namespace enamel::test_tool
