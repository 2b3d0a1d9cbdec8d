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

// Bits of the cells of a row with centres between two places.
inline std::uint32_t cellsBetween(double from, double to) {
  from = std::max(std::ceil(from), 0.0);
  to = std::min(std::floor(to), kBrickCells - 1.0);
  return from <= to ? (2u << static_cast<unsigned>(to)) - (1u << static_cast<unsigned>(from)) : 0u;
}

// Cells and the place of the axis nearest to their centres, stored by component, so that several are computed at once.
struct SeenCells {
  int count = 0;
  std::array<const float*, kMostSeen> samples;
  std::array<Eigen::Vector3f, kMostSeen> low;
  std::array<double, kMostSeen> parameter;  // of the place
  float toCentre[3][kMostSeen], corners[8][kMostSeen];
  float distance[kMostSeen], flatness[kMostSeen], outside[kMostSeen];  // as in Plane
  float least[kMostSeen];                                              // lower bound of the distance of the patch

  void add(const float* s, const Vec3& corner, const Vec3& q, double t) {
    samples[count] = s;
    low[count] = corner.cast<float>();
    parameter[count] = t;
    for (int i = 0; i < 3; ++i) toCentre[i][count] = static_cast<float>(q[i]);
    for (int i = 0; i < 8; ++i) corners[i][count] = s[kCorners[i]];
    ++count;
  }

  // The axis may be nearest to a patch up to `step` ahead or back.
  void look(const Eigen::Vector3f& step) {
    const auto& [s0, s1, s2, s3, s4, s5, s6, s7] = corners;
    const auto& [qx, qy, qz] = toCentre;
    const float stepX = step.x(), stepY = step.y(), stepZ = step.z();
    for (int i = 0; i < count; ++i) {
      const Plane plane(s0[i], s1[i], s2[i], s3[i], s4[i], s5[i], s6[i], s7[i], qx[i], qy[i], qz[i]);
      const float rise = plane.perNorm * (plane.gx * stepX + plane.gy * stepY + plane.gz * stepZ);
      const float back = rise * plane.perNorm;
      const float slide = std::max(std::max(std::abs(stepX - back * plane.gx), std::abs(stepY - back * plane.gy)),
                                   std::abs(stepZ - back * plane.gz));
      distance[i] = plane.distance;
      flatness[i] = plane.flatness;
      outside[i] = plane.outside;
      least[i] = std::max(plane.least(std::abs(rise), slide),
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
