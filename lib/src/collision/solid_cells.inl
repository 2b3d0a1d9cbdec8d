// Selects the cells of a solid that may hold the result, by the tangent planes at their centres. In float, as it only
// selects, and many cells at once. Included by solid_query.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "solid_patch.inl"

namespace enamel::kernel {
namespace {

constexpr double kHalfCell = 0.8660254037844386;  // half its diagonal
constexpr int kMostSeen = 1000;                   // not a power of two: its arrays would share cache lines
constexpr float kSmooth = 0.1f;

// The tangent plane at the centre of a cell, as seen from q, which is relative to the centre. Float suffices to select.
struct Plane {
  float distance;             // of q, not negative
  float flatness;             // largest distance of the patch from the plane; normals turn by about four times as much
  float outside;              // from the centre to the plane's point nearest to q, the largest coordinate
  float gx, gy, gz, perNorm;  // gradient, and one over its length

  // The corners of the cell, x fastest.
  Plane(float s0, float s1, float s2, float s3, float s4, float s5, float s6, float s7, float qx, float qy, float qz) {
    const float x00 = s1 - s0, x10 = s3 - s2, x01 = s5 - s4, x11 = s7 - s6;
    const float low = s0 + s1, back = s2 + s3, up = s4 + s5, far = s6 + s7;
    const float y0 = back - low, y1 = far - up;
    gx = 0.25f * (x00 + x10 + x01 + x11), gy = 0.25f * (y0 + y1), gz = 0.25f * (up + far - low - back);
    const float squared = gx * gx + gy * gy + gz * gz + 1e-12f;
    const float height = 0.125f * (low + back + up + far) + gx * qx + gy * qy + gz * qz;
    const float perSquared = 1.0f / squared, way = height * perSquared;
    outside = std::max(std::max(std::abs(qx - way * gx), std::abs(qy - way * gy)), std::abs(qz - way * gz));
    perNorm = std::sqrt(perSquared);
    distance = std::abs(height) * perNorm;
    const float xy = std::abs(x10 - x00) + std::abs(x11 - x01), xz = std::abs(x01 - x00) + std::abs(x11 - x10);
    flatness = 0.125f * (xy + xz + std::abs(y1 - y0) + std::abs((x11 - x01) - (x10 - x00))) * perNorm;
  }

  // Lower bound of the distance of the patch. A smooth patch may be nearer by some hundredths of a cell: in a pit that
  // fits the bur, all places are about equally near. q may move by `rise` to the plane, and its foot by `slide`.
  float least(float rise, float slide) const {
    const float ahead = std::max(distance - rise - (flatness < kSmooth ? 0.1f * flatness : flatness), 0.0f);
    const float aside = std::max(outside - slide - 0.5f - flatness, 0.0f);  // from the plane's point to the cell
    return std::sqrt(ahead * ahead + aside * aside);
  }
};

Plane planeOf(const float* s, const Vec3& q) {
  const auto& [s0, s1, s2, s3, s4, s5, s6, s7] = kCorners;
  const Eigen::Vector3f f = q.cast<float>();
  return {s[s0], s[s1], s[s2], s[s3], s[s4], s[s5], s[s6], s[s7], f.x(), f.y(), f.z()};
}

// Cells of a slice whose centres may be within `most`: those in the square around the circle.
std::uint64_t cellsAbout(const Vec3& seen, int z, double most) {
  const double squared = most * most - (seen.z() - z) * (seen.z() - z);
  if (!(squared >= 0.0)) return 0;
  const double radius = std::sqrt(squared);
  const auto range = [&](double at) {  // bits
    const double from = std::max(at - radius, 0.0), to = std::min(at + radius, kBrickCells - 1.0);
    if (!(from <= to)) return 0u;
    return (2u << static_cast<unsigned>(to)) - (1u << static_cast<unsigned>(from));  // from: rounded down
  };
  std::uint64_t cells = 0;
  const std::uint64_t row = range(seen.x());
  for (std::uint32_t rows = range(seen.y()); rows != 0; rows &= rows - 1)
    cells |= row << (kBrickCells * __builtin_ctz(rows));
  return cells;
}

// Cells relative to the point, stored by component, so that several are computed at once.
struct SeenCells {
  int count = 0;
  std::array<const float*, kMostSeen> samples;
  std::array<Eigen::Vector3f, kMostSeen> low;
  float toCentre[3][kMostSeen], corners[8][kMostSeen];
  float distance[kMostSeen], flatness[kMostSeen], outside[kMostSeen];  // as in Plane
  float least[kMostSeen];                                              // lower bound of the distance of the patch

  void add(const float* s, const Vec3& corner, const Vec3& q) {
    samples[count] = s;
    low[count] = corner.cast<float>();
    for (int i = 0; i < 3; ++i) toCentre[i][count] = static_cast<float>(q[i]);
    for (int i = 0; i < 8; ++i) corners[i][count] = s[kCorners[i]];
    ++count;
  }

  void look() {
    const auto& [s0, s1, s2, s3, s4, s5, s6, s7] = corners;
    const auto& [qx, qy, qz] = toCentre;
    for (int i = 0; i < count; ++i) {
      const Plane plane(s0[i], s1[i], s2[i], s3[i], s4[i], s5[i], s6[i], s7[i], qx[i], qy[i], qz[i]);
      distance[i] = plane.distance;
      flatness[i] = plane.flatness;
      outside[i] = plane.outside;
      least[i] = std::max(plane.least(0.0f, 0.0f),
                          std::sqrt(qx[i] * qx[i] + qy[i] * qy[i] + qz[i] * qz[i]) - static_cast<float>(kHalfCell));
    }
  }
};

// Cells sorted by their lower bounds, as shares of the reach, least first.
struct Order {
  static constexpr int kShares = 256;
  std::array<std::int16_t, kMostSeen> cells;
  std::array<int, kShares + 1> ends{};

  Order(const SeenCells& seen, double reach) {
    std::array<std::int16_t, kMostSeen> share;
    const float scale = kShares / std::max(static_cast<float>(reach), 1e-6f);
    for (int i = 0; i < seen.count; ++i) {
      share[i] = static_cast<std::int16_t>(std::clamp(seen.least[i] * scale, 0.0f, kShares - 1.0f));
      ++ends[share[i] + 1];
    }
    for (int k = 0; k < kShares; ++k) ends[k + 1] += ends[k];
    for (int i = 0; i < seen.count; ++i) cells[ends[share[i]]++] = static_cast<std::int16_t>(i);
  }
};

}  // namespace
}  // namespace enamel::kernel
