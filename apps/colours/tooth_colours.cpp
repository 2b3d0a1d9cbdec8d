#include "colours/tooth_colours.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "colours/palette.hpp"

namespace enamel::viewer {
namespace {

double smooth(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// Move every vertex to the mean of its neighbours, `times` times. Vertices at one place move together.
std::vector<Vec3> smoothed(const TriangleMesh& mesh, const std::vector<int>& place, std::vector<Vec3> at, int times) {
  std::vector<Vec3> sums(at.size());
  std::vector<int> counts(at.size());
  for (; times > 0; --times) {
    std::fill(sums.begin(), sums.end(), Vec3::Zero());
    std::fill(counts.begin(), counts.end(), 0);
    for (const auto& t : mesh.triangles)
      for (int i = 0; i < 3; ++i) {
        const auto a = static_cast<std::size_t>(place[static_cast<std::size_t>(t[i])]),
                   b = static_cast<std::size_t>(place[static_cast<std::size_t>(t[(i + 1) % 3])]);
        sums[a] += at[b];
        sums[b] += at[a];
        ++counts[a];
        ++counts[b];
      }
    for (std::size_t i = 0; i < at.size(); ++i)
      if (counts[i] > 0) at[i] = 0.5 * at[i] + 0.5 / counts[i] * sums[i];
  }
  return at;
}

}  // namespace

std::vector<Vec3> toothColours(const TriangleMesh& mesh, double gumLine) {
  static const Vec3 ivory = rgbOf(kEnamel), neck = rgbOf(0xE3CE9C), cusp = rgbOf(0xFBF7EE), fissure = rgbOf(0x6E5538);
  constexpr int fine = 10, coarse = 120;  // numbers of smoothing steps
  const std::vector<int> place = weld(mesh);
  std::vector<Vec3> at(mesh.vertices.size(), Vec3::Zero()), normals(at.size(), Vec3::Zero());
  for (std::size_t i = 0; i < place.size(); ++i) at[static_cast<std::size_t>(place[i])] = mesh.vertices[i];
  double edges = 0.0, low = mesh.vertices.front().z(), high = low;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int i) { return static_cast<std::size_t>(place[static_cast<std::size_t>(t[i])]); };
    const Vec3 normal = (at[corner(1)] - at[corner(0)]).cross(at[corner(2)] - at[corner(0)]);
    for (int i = 0; i < 3; ++i) normals[corner(i)] += normal;
    edges += (at[corner(1)] - at[corner(0)]).norm();
  }
  for (const Vec3& v : mesh.vertices) low = std::min(low, v.z()), high = std::max(high, v.z());
  const double edge = edges / static_cast<double>(mesh.triangles.size());
  const std::vector<Vec3> near = smoothed(mesh, place, at, fine), far = smoothed(mesh, place, near, coarse);

  std::vector<Vec3> colours;
  colours.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto p = static_cast<std::size_t>(place[i]);
    const Vec3 normal = normals[p].normalized();
    const double groove = normal.dot(near[p] - at[p]) / edge, pit = normal.dot(far[p] - near[p]) / (6.0 * edge);
    const double z = mesh.vertices[i].z();
    const double bottom = std::isfinite(gumLine) ? gumLine : low;
    Vec3 tooth = neck + smooth(bottom, bottom + 0.45 * (high - bottom), z) * (ivory - neck);
    tooth += 0.7 * smooth(0.1, 0.8, -pit) * (cusp - tooth);
    tooth += (0.75 * smooth(0.05, 0.5, groove) + 0.45 * smooth(0.05, 0.8, pit)) * 0.8 * (fissure - tooth);
    // Gum is slightly higher where the mesh is hollow, as between two teeth.
    const double line = gumLine + 0.0004 * std::clamp(pit, -1.0, 1.0), width = 0.00025;
    const double gum = std::isfinite(gumLine) ? 1.0 - smooth(line - width, line + width, z) : 0.0;
    const Vec3 flesh = gumColour(std::max(0.0, line - z)) * (1.0 - 0.35 * smooth(0.1, 1.0, pit));
    colours.push_back((tooth + gum * (flesh - tooth)).cwiseMax(0.0).cwiseMin(1.0));
  }
  return colours;
}

Vec3 gumColour(double distance) {
  static const Vec3 gum = rgbOf(kGum), deep = rgbOf(0xA8574F);
  return gum + 0.75 * std::exp(-std::max(0.0, distance) / 0.0016) * (deep - gum);
}

}  // namespace enamel::viewer
