#include "enamel/collision/tool.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kUnit = 1e-4;                                            // m, of the numbers in a name
constexpr int kSmallestHead = 3, kLargestHead = 100, kLongestHead = 200;  // kUnit
constexpr double kShank = 0.8e-3, kShankLength = 4e-3;                    // radius of a friction grip shank, m
constexpr double kNeckShare = 0.6, kNeckLength = 3e-3;                    // of the head's radius

constexpr double kFlameTip = 0.25;  // of the head's radius
constexpr int kSteps = 6;           // capsules of a head that is not a cylinder

// A capsule along z from its lowest to its highest point.
struct Piece {
  double low, high, radius;
};

void add(Tool& tool, const Piece& piece) {
  tool.parts[static_cast<std::size_t>(tool.count++)] = {Vec3(0.0, 0.0, piece.low + piece.radius),
                                                        Vec3(0.0, 0.0, piece.high - piece.radius), piece.radius};
}

Tool along(const std::vector<Piece>& pieces) {
  Tool tool;
  tool.count = 0;
  for (const Piece& piece : pieces) add(tool, piece);
  return tool;
}

// Add neck and shank to a head. The neck begins inside the head, whose upper end is a ball of a radius. The round end
// of the shank may reach into the neck.
Tool onShank(Tool head, double top, double upper, double radius) {
  const double neck = std::min({kNeckShare * radius, upper, kShank}), shank = top + kNeckLength;
  head.head = head.count;
  add(head, {top - upper - neck, shank + kShank, neck});
  add(head, {shank, shank + kShankLength, kShank});
  return head;
}

// A cylinder with round ends.
Tool cylinder(double diameter, double length) {
  return onShank(along({{0.0, length, 0.5 * diameter}}), length, 0.5 * diameter, 0.5 * diameter);
}

// A cylinder with a flat end: a ring of five thin capsules fills most of what its round end lacks.
Tool flat(double diameter, double length) {
  constexpr int kSides = kSteps - 1;
  constexpr double kThick = 0.3;
  const double radius = 0.5 * diameter, thick = kThick * radius;
  Tool head = along({{0.0, length, radius}});
  const auto corner = [&](int i) {
    const double angle = 2.0 * M_PI * i / kSides;
    return Vec3((radius - thick) * std::cos(angle), (radius - thick) * std::sin(angle), thick);
  };
  for (int i = 0; i < kSides; ++i)
    head.parts[static_cast<std::size_t>(head.count++)] = {corner(i), corner((i + 1) % kSides), thick};
  return onShank(head, length, radius, radius);
}

// Balls with their centres on the axis, whose radius grows from the tip on: in proportion to the way, or along an arc
// that passes its widest place. Each capsule has the mean radius of its balls, and steps are equal.
Tool grown(double tip, double radius, double length, bool isArc) {
  const double step = (radius - tip) / kSteps, upper = isArc ? radius - step : radius, end = length - upper;
  const double widest = tip + (end - tip) / (isArc ? 1.0 + std::sqrt(1.0 / kSteps) : 1.0);
  const auto centre = [&](int steps) {  // of the ball that has grown by so many steps
    const double share = static_cast<double>(steps) / kSteps;
    return tip + (widest - tip) * (isArc ? 1.0 - std::sqrt(1.0 - share) : share);
  };
  std::vector<Piece> pieces;
  for (int i = 0; i < kSteps; ++i) {
    const double mean = tip + (i + 0.5) * step;
    pieces.push_back({centre(i) - mean, centre(i + 1) + mean, mean});
  }
  pieces.front().low = 0.0;
  pieces.back().high = length;
  return onShank(along(pieces), length, pieces.back().radius, radius);
}

// The numbers after "-" in a name that begins with a shape, three digits each; empty: it does not.
std::vector<int> sizesOf(std::string_view name, std::string_view shape) {
  std::vector<int> sizes;
  if (name.substr(0, shape.size()) != shape) return {};
  for (name.remove_prefix(shape.size()); !name.empty(); name.remove_prefix(4)) {
    const auto isDigit = [&](std::size_t at) { return name[at] >= '0' && name[at] <= '9'; };
    if (name.size() < 4 || name[0] != '-' || !isDigit(1) || !isDigit(2) || !isDigit(3)) return {};
    sizes.push_back(100 * (name[1] - '0') + 10 * (name[2] - '0') + name[3] - '0');
  }
  return sizes;
}

// Whether a name has so many numbers, with a diameter, a length and a diameter of the tip within their limits.
bool isBur(const std::vector<int>& sizes, std::size_t count) {
  return sizes.size() == count && sizes[0] >= kSmallestHead && sizes[0] <= kLargestHead &&
         (count < 2 || (sizes[1] >= sizes[0] && sizes[1] <= kLongestHead)) &&
         (count < 3 || (sizes[2] > 0 && sizes[2] < sizes[0]));
}

}  // namespace

Tool toolOf(const std::string& name) {
  if (name == "cpi-probe") return along({{0.0, 0.5e-3, 0.25e-3}, {0.1e-3, 12e-3, 0.2e-3}});
  if (name == "explorer") return along({{0.0, 1.5e-3, 0.1e-3}, {0.5e-3, 4e-3, 0.2e-3}, {2e-3, 10e-3, 0.35e-3}});
  if (name == "bur-245") return cylinder(0.8e-3, 3e-3);
  if (const auto d = sizesOf(name, "round"); isBur(d, 1)) return cylinder(kUnit * d[0], kUnit * d[0]);
  if (const auto d = sizesOf(name, "cylinder"); isBur(d, 2)) return cylinder(kUnit * d[0], kUnit * d[1]);
  if (const auto d = sizesOf(name, "flat"); isBur(d, 2)) return flat(kUnit * d[0], kUnit * d[1]);
  if (const auto d = sizesOf(name, "cone"); isBur(d, 3))
    return grown(0.5 * kUnit * d[2], 0.5 * kUnit * d[0], kUnit * d[1], false);
  if (const auto d = sizesOf(name, "flame"); isBur(d, 2))
    return grown(0.5 * kFlameTip * kUnit * d[0], 0.5 * kUnit * d[0], kUnit * d[1], true);
  throw Error(
      "\"" + name +
      "\" is not a tool: it must be \"round-D\", \"cylinder-D-L\", \"flat-D-L\", \"cone-D-L-T\", "
      "\"flame-D-L\", \"bur-245\", \"cpi-probe\" or \"explorer\", with a diameter D of 003 to 100, a length L of "
      "D to 200 and a diameter T of the tip below D, three digits each, in 0.1 mm");
}

}  // namespace enamel
