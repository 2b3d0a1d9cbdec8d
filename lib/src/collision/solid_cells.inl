// Selects the cells of a solid that may hold the result, by the tangent planes at their centres. In float, as it only
// selects, and many cells at once. Included by solid_axis.inl.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh_data.hpp"
#include "solid_patch.inl"

namespace enamel::kernel {
namespace {

constexpr double kHalfCell = 0.8660254037844386;  // half its diagonal

// Bits of the cells of a row with centres between two places.
inline std::uint32_t cellsBetween(double from, double to) {
  const auto least = static_cast<unsigned>(std::clamp(from, 0.0, static_cast<double>(kBrickCells)));
  const unsigned first = least + (static_cast<double>(least) < from ? 1u : 0u);
  const auto last = static_cast<unsigned>(std::clamp(to, 0.0, kBrickCells - 1.0));
  return to >= 0.0 && first <= last ? (2u << last) - (1u << first) : 0u;
}

// Cells and the place of the axis nearest to their centres.
struct SeenCells : CellRows {
  std::array<float, kMost> parameter;  // of the place
  float length;                        // of the axis

  explicit SeenCells(const Vec3& span) : length(static_cast<float>(span.norm())) {
    count = 0;
    const Vec3 unit = length > 0.0f ? Vec3(span.normalized()) : span;
    for (int i = 0; i < 3; ++i) axis[i] = static_cast<float>(unit[i]);
  }

  void add(std::uint32_t number, const float* s, const Eigen::Vector3f& toCentre, float t) {
    cell[count] = number;
    parameter[count] = t;
    back[count] = std::min(static_cast<float>(kHalfCell), t * length);
    ahead[count] = std::min(static_cast<float>(kHalfCell), (1.0f - t) * length);
    for (int i = 0; i < 3; ++i) point[i][count] = toCentre[i] + 0.5f;
    for (int i = 0; i < 8; ++i) samples[i][count] = s[kCorners[i]];
    ++count;
  }
};

// Cells sorted by their lower bounds, as shares of the reach, least first.
struct Order {
  static constexpr int kShares = 256;
  std::array<std::int16_t, CellRows::kMost> cells, share;
  std::array<int, kShares + 1> ends{};
  float scale;

  Order(const CellRows& seen, double reach) : scale(kShares / std::max(static_cast<float>(reach), 1e-6f)) {
    for (int i = 0; i < seen.count; ++i) {
      share[i] = static_cast<std::int16_t>(std::clamp(seen.least[i] * scale, 0.0f, kShares - 1.0f));
      ++ends[share[i] + 1];
    }
    for (int k = 0; k < kShares; ++k) ends[k + 1] += ends[k];
    for (int i = 0; i < seen.count; ++i) cells[ends[share[i]]++] = static_cast<std::int16_t>(i);
  }

  // Lower bound of the cells from the i-th on.
  double least(int i) const { return static_cast<double>(static_cast<float>(share[cells[i]]) / scale); }
};

}  // namespace
}  // namespace enamel::kernel
