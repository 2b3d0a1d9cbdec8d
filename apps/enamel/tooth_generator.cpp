#include "tooth_generator.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "enamel/collision/implicit_surface.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "mesh_generator.hpp"

// All lengths in mm. Fields are about a distance, negative inside.
namespace enamel::app {
namespace {

constexpr double kNeck = -3.0;  // height where the enamel ends
constexpr double kTop = 2.7;    // height of the chewing surface without cusps and grooves

double square(double x) { return x * x; }

// Union and intersection of two fields with an edge that is rounded over `width`.
double joined(double a, double b, double width) {
  return std::min(a, b) - 0.25 * width * square(std::max(width - std::abs(a - b), 0.0) / width);
}
double common(double a, double b, double width) { return -joined(-a, -b, width); }

// An outline between an ellipse (power 2) and a rectangle.
double outline(double x, double y, double halfX, double halfY, double power) {
  const double r = std::pow(std::pow(std::abs(x) / halfX, power) + std::pow(std::abs(y) / halfY, power), 1.0 / power);
  return (r - 1.0) * std::min(halfX, halfY);
}

// Height of the chewing surface: cusps, a groove along the jaw, and grooves between neighbouring cusps.
double chewing(double x, double y) {
  double z = kTop;
  for (const auto& [at_x, at_y, height] : kMolarCusps) z += height * hill(x - at_x, y - at_y, 1.7);
  z -= 0.7 * std::exp(-square(y / 0.6)) * hill(x, 0.0, 4.0);
  for (const auto& [at, side] : {std::array{-0.1, 1.0}, std::array{-0.5, -1.0}, std::array{3.0, -1.0}})
    z -= 0.6 * std::exp(-square((x - at) / 0.5)) * smoothStep(0.5 + side * y);
  return z;
}

// Half widths along and across the jaw at heights from the roots to the cusps.
double body(const Vec3& p) {
  constexpr std::array<std::array<double, 3>, 5> kWidths = {
      {{-7.0, 4.2, 4.0}, {kNeck, 4.5, 4.5}, {-0.2, 5.5, 5.25}, {2.0, 5.2, 4.8}, {5.0, 4.5, 4.0}}};
  std::size_t i = 1;
  while (i + 1 < kWidths.size() && p.z() > kWidths[i][0]) ++i;
  const auto &low = kWidths[i - 1], &high = kWidths[i];
  const double t = smoothStep((p.z() - low[0]) / (high[0] - low[0]));
  const double side = outline(p.x(), p.y(), low[1] + t * (high[1] - low[1]), low[2] + t * (high[2] - low[2]), 2.6);
  return common(common(side, p.z() - chewing(p.x(), p.y()), 1.2), kNeck - 3.2 - p.z(), 0.8);
}

// The front root is wide, grooved and bent backwards; the rear root is rounder.
struct Root {
  double x, away, bend, halfX, halfY, apex;
  double centre(double s) const { return x + away * s + bend * s * s; }
  double depth(double z) const { return std::clamp((kNeck - z) / (kNeck - apex), 0.0, 1.0); }
};
constexpr std::array<Root, 2> kRoots = {{{-2.3, -1.7, 1.6, 2.1, 4.1, -17.4}, {2.3, 1.2, -0.4, 2.0, 3.5, -16.7}}};

double rootOf(const Root& root, const Vec3& p) {
  const double s = root.depth(p.z()), groove = 1.0 - 0.16 * std::exp(-square(p.y()));
  const double side = outline(p.x() - root.centre(s), p.y(), root.halfX * (1.0 - 0.66 * s) * groove,
                              root.halfY * (1.0 - 0.68 * s), 2.0);
  return common(common(side, root.apex - p.z(), 2.0), p.z() - kNeck, 1.0);
}

double tooth(const Vec3& p) { return joined(body(p), joined(rootOf(kRoots[0], p), rootOf(kRoots[1], p), 1.0), 1.2); }

// The neck is higher in front and behind, between the teeth.
double neck(const Vec3& p) { return kNeck + 0.8 * square(p.x() / 4.5); }

// Enamel ends at the neck and is thickest on the cusps. Below the neck dentine covers the border of the enamel.
double enamelThickness(const Vec3& p) {
  const double above = p.z() - neck(p);
  return above < 0.0 ? std::max(above, -0.1) : 2.2 * smoothStep(above / 6.5);
}

// The nearest of some cones with round ends.
double cones(const Vec3& p, const std::vector<std::pair<Vec3, double>>& line) {
  double nearest = HUGE_VAL;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto& [a, ra] = line[i - 1];
    const auto& [b, rb] = line[i];
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * (b - a)).norm() - ra - t * (rb - ra));
  }
  return nearest;
}

// The chamber with a horn under each of the four larger cusps, two canals in the front root, one in the rear.
double pulp(const Vec3& p) {
  constexpr double kCeiling = -1.7, kFloor = -3.25;
  const double middle = 0.5 * (kCeiling + kFloor);
  double field = common(outline(p.x(), p.y(), 2.6, 2.0, 2.6), std::abs(p.z() - middle) - (kCeiling - middle), 0.8);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 cusp(kMolarCusps[i][0], kMolarCusps[i][1], 0.0);
    field = joined(
        field, cones(p, {{0.65 * cusp + Vec3(0.0, 0.0, -2.4), 0.7}, {0.75 * cusp + Vec3(0.0, 0.0, -0.6), 0.2}}), 0.5);
  }
  for (std::size_t i = 0; i < 2; ++i)
    for (const double side : i == 0 ? std::vector{-1.0, 1.0} : std::vector{0.0}) {
      std::vector<std::pair<Vec3, double>> canal;
      for (int k = 0; k <= 8; ++k) {
        const double s = k / 8.0, z = -2.9 + s * (kRoots[i].apex + 4.1);  // ends in the root
        canal.emplace_back(Vec3(kRoots[i].centre(kRoots[i].depth(z)), side * (1.5 - 1.0 * s), z),
                           (i == 0 ? 0.5 : 0.65) * (1.0 - 0.7 * s));
      }
      field = joined(field, cones(p, canal), 0.4);
    }
  return field;
}

// A ridge along the jaw. The gum ends on the enamel and rises between the teeth.
double margin(const Vec3& p) { return -2.2 + 2.0 * smoothStep((std::abs(p.x()) - 3.5) / 2.5); }
double ridge(const Vec3& p) {
  const double sides = std::abs(p.y()) - 5.6 - 1.0 * smoothStep((-2.0 - p.z()) / 8.0);
  return common(common(common(sides, p.z() - margin(p), 2.5), std::abs(p.x()) - 7.2, 1.5), -18.0 - p.z(), 1.0);
}

// The gum is 1.2 mm thick, and the edge of the bone is 1.7 mm below the neck.
double bone(const Vec3& p) { return common(ridge(p) + 1.2, p.z() - neck(p) + 1.7, 1.0); }

}  // namespace

const std::vector<std::string>& toothParts() {
  static const std::vector<std::string> parts = {"tooth-block", "tooth-bone", "tooth-enamel", "tooth-dentine",
                                                 "tooth-pulp"};
  return parts;
}

TriangleMesh makeToothPart(const std::string& part) {
  const auto mesh = [](double cell, const auto& field) {
    return surfaceOf([&](const Vec3& p) { return field(1e3 * p); }, 1e-3 * Vec3(-8.0, -8.0, -19.0),
                     1e-3 * Vec3(8.0, 8.0, 6.0), 1e-3 * cell);
  };
  if (part == "tooth-block") return mesh(0.3, [](const Vec3& p) { return joined(tooth(p), ridge(p), 0.4); });
  if (part == "tooth-bone") return mesh(0.5, bone);
  if (part == "tooth-pulp") return mesh(0.2, pulp);
  const MeshModel model(mesh(0.25, tooth));
  const auto outside = [&](const Vec3& p) { return 1e3 * signedDistance(model, 1e-3 * p).distance; };
  // Above the gum the border of the enamel is outside of the block, so that rounding leaves no gum there.
  if (part == "tooth-enamel")
    return mesh(0.3, [&](const Vec3& p) { return outside(p) - 0.3 * smoothStep((p.z() - margin(p)) / 0.8); });
  if (part == "tooth-dentine") return mesh(0.3, [&](const Vec3& p) { return outside(p) + enamelThickness(p); });
  throw Error("the tooth has no part \"" + part + "\"");
}

}  // namespace enamel::app
