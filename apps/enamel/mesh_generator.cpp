#include "mesh_generator.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>

namespace enamel::app {
namespace {

// An odd root function, steep at 0: it turns a circle into a rounded square.
double squared(double x, double power) { return std::copysign(std::pow(std::abs(x), power), x); }

}  // namespace

double hill(double x, double y, double width) { return std::exp(-(x * x + y * y) / (width * width)); }

double smoothStep(double x) {
  const double t = std::min(std::max(x, 0.0), 1.0);
  return t * t * (3.0 - 2.0 * t);
}

TriangleMesh makeMolar(int levels) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) mesh.vertices.push_back(sign * Vec3::Unit(axis));
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5})
        mesh.triangles.push_back((x + y + z) % 2 != 0 ? std::array<int, 3>{x, z, y} : std::array<int, 3>{x, y, z});
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [entry, isNew] = middles.emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
      if (isNew) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return entry->second;
    };
    std::vector<std::array<int, 3>> fine;
    for (const auto& t : mesh.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      fine.insert(fine.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = std::move(fine);
  }
  for (Vec3& v : mesh.vertices) {
    const double x = 5.5 * squared(v.x(), 0.8), y = 5.0 * squared(v.y(), 0.8);
    double z = (v.z() > 0.0 ? 3.5 : 4.5) * squared(v.z(), 0.7);
    const double top = smoothStep(2.0 * v.z());
    for (const auto& cusp : kMolarCusps) z += top * cusp[2] * hill(x - cusp[0], y - cusp[1], 1.6);
    z -= top * (0.7 * std::exp(-y * y / 0.3) * hill(x, 0.0, 4.0) + 0.5 * std::exp(-x * x / 0.25) * hill(0.0, y, 3.5));
    const double waist = 1.0 - 0.18 * smoothStep(-1.2 * v.z());  // narrower at the neck
    v = 1e-3 * Vec3(waist * x, waist * y, z);
  }
  return mesh;
}

TriangleMesh makeJaw(int along, int around) {
  TriangleMesh mesh;
  constexpr double kHalfWidth = 27.0, kDepth = 45.0, kTeeth = 14.0;  // mm, mm, count
  for (int i = 0; i < along; ++i) {
    const double s = 2.0 * i / (along - 1.0) - 1.0;  // -1 .. 1 along the arch
    const double x = kHalfWidth * std::sin(0.5 * M_PI * s), y = kDepth * (std::cos(0.5 * M_PI * s) - 0.5);
    const Vec3 tangent =
        Vec3(kHalfWidth * std::cos(0.5 * M_PI * s), -kDepth * std::sin(0.5 * M_PI * s), 0.0).normalized();
    const Vec3 out = Vec3(-tangent.y(), tangent.x(), 0.0);
    const double molar = smoothStep((std::abs(s) - 0.35) / 0.2);  // 0: front tooth, 1: molar
    const double phase = kTeeth * 0.5 * (s + 1.0), within = 2.0 * (phase - std::floor(phase)) - 1.0;
    const double crown = std::pow(std::max(1.0 - std::pow(std::abs(within), 6.0), 0.0), 0.5);
    const double end = std::sqrt(std::max(1.0 - std::pow(std::abs(s), 40.0), 0.0));  // round ends
    const double width = (0.25 + 0.75 * end) * (2.8 + 2.2 * molar) * (0.8 + 0.2 * crown);
    for (int j = 0; j < around; ++j) {
      const double angle = 2.0 * M_PI * j / around;
      const double across = squared(std::cos(angle), 0.7), up = std::sin(angle);
      double height = -9.0 * squared(-std::min(up, 0.0), 0.7);
      if (up > 0.0) {
        const double cusps =
            molar * (0.9 * std::cos(M_PI * within * 1.5) * across * across - 0.8 * (1.0 - across * across));
        height = squared(up, 0.6) * (1.5 + end * crown * (6.5 + cusps));
      }
      mesh.vertices.push_back(1e-3 * (Vec3(x, y, 0.0) + width * across * out + Vec3(0.0, 0.0, height)));
    }
  }
  const auto at = [&](int i, int j) { return i * around + j % around; };
  for (int i = 0; i + 1 < along; ++i)
    for (int j = 0; j < around; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  for (const int i : {0, along - 1}) {  // end caps
    Vec3 middle = Vec3::Zero();
    for (int j = 0; j < around; ++j) middle += mesh.vertices[at(i, j)] / around;
    mesh.vertices.push_back(middle);
    const int centre = static_cast<int>(mesh.vertices.size()) - 1;
    for (int j = 0; j < around; ++j)
      mesh.triangles.push_back(i == 0 ? std::array<int, 3>{centre, at(i, j + 1), at(i, j)}
                                      : std::array<int, 3>{centre, at(i, j), at(i, j + 1)});
  }
  return mesh;
}

}  // namespace enamel::app
