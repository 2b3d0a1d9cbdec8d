// Visits the cells of a solid around an axis or a point. Included by solid_query.cpp and solid_minima.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solid_cells.inl"

namespace enamel {

using namespace kernel;

namespace {

constexpr std::uint32_t kNoCell = ~0u;
constexpr std::uint32_t kSlice = kBrickCells * kBrickCells, kCellsInBrick = kSlice * kBrickCells;
constexpr double kFarAxis = 1e15;        // cells: squares are finite in float
constexpr double kClear = 0.5;           // farther away the offset from the surface gives its normal
constexpr double kRounded = 1.0 + 1e-6;  // larger than the error of a distance in float

// Remove the lane with the least estimate, and return it.
inline int takeNearest(const CellPlaces& places, unsigned& lanes) {
  int lane = __builtin_ctz(lanes);
  for (unsigned others = lanes & (lanes - 1); others != 0; others &= others - 1)
    if (places.distance[__builtin_ctz(others)] < places.distance[lane]) lane = __builtin_ctz(others);
  lanes &= ~(1u << lane);
  return lane;
}

struct Nearest {
  double distance;
  double parameter = 0.0;
  Vec3 point = Vec3::Zero(), gradient = Vec3::UnitZ();
  bool found = false;
  std::uint32_t cell = kNoCell;
};

}  // namespace

// The cells of a solid around an axis. Lengths are in cells, places are relative to the corner of the solid's box.
struct SolidQuery {
  using Brick = Solid::Brick;

  const Solid& solid;
  Vec3 a, span;
  double perLength, perSpan;  // one over the span's length squared, and one over the length; 0 for a point

  SolidQuery(const Solid& of, const Vec3& from, const Vec3& to)
      : solid(of), a((from - of.origin_) / of.cell_), span((to - from) / of.cell_) {
    const double squared = span.squaredNorm();
    perLength = squared > 0.0 ? 1.0 / squared : 0.0;
    perSpan = std::sqrt(perLength);
  }

  double parameterAt(const Vec3& p) const { return std::clamp((p - a).dot(span) * perLength, 0.0, 1.0); }
  Vec3 axisAt(double t) const { return a + t * span; }
  const Brick& brickOf(std::int32_t number) const { return solid.bricks_[static_cast<std::size_t>(number)]; }

  // Visit the bricks with surface that may have a place within `reach()` of the axis.
  template <typename Reach, typename Visit>
  void forEachBrick(const Reach& reach, const Visit& visit) const {
    const Vec3 low = a.cwiseMin(a + span), high = a.cwiseMax(a + span);
    std::array<int, 3> first, last;
    for (int i = 0; i < 3; ++i) {
      const double most = solid.count_[i] - 1;
      const double from = std::floor((low[i] - reach()) / kBrickCells),
                   to = std::floor((high[i] + reach()) / kBrickCells);
      if (!(from <= most && to >= 0.0)) return;
      first[i] = static_cast<int>(std::max(from, 0.0));
      last[i] = static_cast<int>(std::min(to, most));
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const std::int32_t number = solid.brickAt(x, y, z);
          if (number < 0 || solid.hasSurface_[static_cast<std::size_t>(number)] == 0) continue;
          const Vec3 centre = kBrickCells * Vec3(x + 0.5, y + 0.5, z + 0.5);
          const Vec3 q = perLength > 0.0 ? Vec3(centre - axisAt(parameterAt(centre))) : Vec3(centre - a);
          const double distance = perLength > 0.0 ? q.norm() - kBrickCells * kHalfCell
                                                  : (q.array().abs() - 0.5 * kBrickCells).max(0.0).matrix().norm();
          if (distance <= reach()) visit(number, distance);
        }
  }

  // Visit the cells of a brick with surface within `reach()` of the axis. Arguments: cell as in SeenCells, its first
  // sample, centre of the cell relative to the axis, place of the axis. In float, as they only select.
  template <typename Reach, typename Visit>
  void forEachCell(std::int32_t number, const Reach& reach, const Visit& visit) const {
    const Brick& brick = brickOf(number);
    const Vec3 corner = cornerOf(brick), first = corner + Vec3::Constant(0.5);
    // The part of the axis that may be in reach, and a box around it.
    const double around = reach() + kHalfCell, half = (kBrickCells * kHalfCell + around) * perSpan;
    const double middle = perLength > 0.0 ? parameterAt(corner + Vec3::Constant(0.5 * kBrickCells)) : 0.0;
    const Vec3 from = axisAt(std::max(middle - half, 0.0)) - first, to = axisAt(std::min(middle + half, 1.0)) - first;
    std::array<std::uint32_t, 3> within;
    float away[3][kBrickCells];
    for (int i = 0; i < 3; ++i) {
      within[i] = cellsBetween(std::min(from[i], to[i]) - around, std::max(from[i], to[i]) + around);
      for (int k = 0; k < kBrickCells; ++k) away[i][k] = static_cast<float>(a[i] - first[i] - k);
    }
    const Eigen::Vector3f along = span.cast<float>();
    const auto perSquared = static_cast<float>(perLength);
    std::uint64_t slice = 0;
    for (std::uint32_t rows = within[1]; rows != 0; rows &= rows - 1)
      slice |= std::uint64_t{within[0]} << (kBrickCells * __builtin_ctz(rows));
    for (; within[2] != 0; within[2] &= within[2] - 1) {
      const int z = __builtin_ctz(within[2]);
      const auto most = static_cast<float>((reach() + kHalfCell) * kRounded);
      for (std::uint64_t left = brick.surface[z] & slice; left != 0; left &= left - 1) {
        const int bit = __builtin_ctzll(left), x = bit % kBrickCells, y = bit / kBrickCells;
        Eigen::Vector3f q(away[0][x], away[1][y], away[2][z]);
        const float t = std::clamp(-q.dot(along) * perSquared, 0.0f, 1.0f);
        q += t * along;
        if (q.squaredNorm() > most * most) continue;
        visit(static_cast<std::uint32_t>((number * kBrickCells + z) * kBrickCells * kBrickCells + bit),
              brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x, q, t);
      }
    }
  }

  // Add the cells of a brick within `reach` of the point.
  void see(std::int32_t number, double reach, SeenCells& cells) const {
    const Brick& brick = brickOf(number);
    loops().seeCells(brick.surface.data(), brick.samples.data(), inBrick(brick).data(),
                     static_cast<float>(std::min(reach, kFarAxis) * kRounded),
                     static_cast<std::uint32_t>(number) * kCellsInBrick, &cells);
  }

  // The point relative to the corner of a brick.
  Eigen::Vector3f inBrick(const Brick& brick) const {
    return (a - cornerOf(brick)).cwiseMax(-kFarAxis).cwiseMin(kFarAxis).cast<float>();
  }
  static Vec3 placeInBrick(std::uint32_t cell) {
    return Vec3(cell % kBrickCells, cell / kBrickCells % kBrickCells, cell / kSlice % kBrickCells);
  }

  // Whether a cell holds surface.
  bool isMarked(std::uint32_t cell) const {
    if (cell / kCellsInBrick >= static_cast<std::uint32_t>(solid.bricks())) return false;
    return (brickOf(static_cast<std::int32_t>(cell / kCellsInBrick)).surface[cell / kSlice % kBrickCells] >>
                (cell % kSlice) &
            1) != 0;
  }

  // First corner of a cell, and its sample.
  Vec3 lowOf(std::uint32_t cell) const {
    return cornerOf(brickOf(static_cast<std::int32_t>(cell / kCellsInBrick))) + placeInBrick(cell);
  }
  const float* samplesOf(std::uint32_t cell) const {
    const Brick& brick = brickOf(static_cast<std::int32_t>(cell / kCellsInBrick));
    return brick.samples.data() + cell / kSlice % kBrickCells * kUp + cell / kBrickCells % kBrickCells * kBack +
           cell % kBrickCells;
  }

  static Vec3 cornerOf(const Brick& brick) {
    return kBrickCells * Vec3(brick.place[0], brick.place[1], brick.place[2]);
  }

  static void bound(SeenCells& cells) {
    for (int i = cells.count; i % kWidth != 0; ++i) {  // lanes without a cell
      for (auto& row : cells.point) row[i] = 0.0f;
      for (auto& row : cells.samples) row[i] = 0.0f;
      cells.back[i] = cells.ahead[i] = 0.0f;
    }
    loops().boundCells(&cells);
  }

  // Pass on the cells that may have a place within `reach()` of the axis, with bounds, as many as fit at a time.
  template <typename Reach, typename Visit>
  void forEachSeen(const Reach& reach, const Visit& visit) const {
    SeenCells cells(span);
    const auto hand = [&] {
      bound(cells);
      visit(std::as_const(cells));
      cells.count = 0;
    };
    forEachBrick(reach, [&](std::int32_t number, double) {
      if (perLength == 0.0) {
        if (cells.count + static_cast<int>(kCellsInBrick) > CellRows::kMost) hand();
        return see(number, reach(), cells);
      }
      forEachCell(number, reach, [&](auto... cell) {
        if (cells.count == CellRows::kMost) hand();
        cells.add(cell...);
      });
    });
    hand();
  }

  // In m. `side`: -1 for a place inside.
  SolidPoint answer(const Nearest& found, double side) const {
    SolidPoint answer;
    answer.found = found.found;
    if (!found.found) return answer;
    answer.point = solid.origin_ + solid.cell_ * found.point;
    answer.distance = side * solid.cell_ * found.distance;
    answer.parameter = found.parameter;
    const Vec3 gradient = found.gradient.normalized(), way = side * (axisAt(found.parameter) - found.point);
    answer.normal = found.distance > kClear ? Vec3(way.normalized()) : gradient;
    answer.layer = solid.layerAt(answer.point - 0.5 * solid.cell_ * gradient);
    return answer;
  }

  // The interpolation at a place, in cells; outside of all bricks the end of the band.
  double valueAt(const Vec3& p) const {
    std::array<int, 3> at;
    for (int i = 0; i < 3; ++i) {
      if (!(p[i] >= 0.0 && p[i] < static_cast<double>(kBrickCells) * solid.count_[i])) return Solid::kBand;
      at[i] = static_cast<int>(p[i]);
    }
    const std::int32_t number = solid.brickAt(at[0] / kBrickCells, at[1] / kBrickCells, at[2] / kBrickCells);
    if (number < 0) return Solid::kBand;
    const Brick& brick = brickOf(number);
    const int x = at[0] % kBrickCells, y = at[1] % kBrickCells, z = at[2] % kBrickCells;
    const Patch patch(brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x);
    Vec3 gradient;
    return patch.at(p - Vec3(at[0], at[1], at[2]), gradient);
  }
  bool isInside() const { return valueAt(a) < 0.0; }
};

}  // namespace enamel
