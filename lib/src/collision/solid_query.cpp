#include "solid_query.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solid_cells.inl"

namespace enamel {

using namespace kernel;

namespace {

constexpr std::uint32_t kNoCell = ~0u;
constexpr double kFarthest = 1.0;  // above half a diagonal: a cell with surface has a place so near its centre
constexpr double kClose = 2.0 * kBrickCells;
constexpr int kRounds = 8;      // of an axis and a patch
constexpr double kFew = 4.0;    // a first step shorter than 1 / kFew of the range goes to its end instead
constexpr double kClear = 0.5;  // farther away the offset from the surface gives its normal
constexpr double kAligned = 0.9396926207859084;  // cos 20 deg
// Of minima within 30 deg the nearest represents the others, unless they are of two walls.
constexpr double kRounded = 1.0 + 1e-6;  // larger than the error of a distance in float
constexpr std::uint32_t kSlice = kBrickCells * kBrickCells, kBrickVolumeCells = kSlice * kBrickCells;
constexpr double kFarAxis = 1e15;   // cells: squares are finite in float
constexpr double kResolved = 0.25;  // times h^2 / R: the error of the interpolation

// Remove the lane with the least estimate, and return it.
int takeNearest(const CellPlaces& places, unsigned& lanes) {
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
                     static_cast<std::uint32_t>(number) * kBrickVolumeCells, &cells);
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
    if (cell / kBrickVolumeCells >= static_cast<std::uint32_t>(solid.bricks())) return false;
    return (brickOf(static_cast<std::int32_t>(cell / kBrickVolumeCells)).surface[cell / kSlice % kBrickCells] >>
                (cell % kSlice) &
            1) != 0;
  }

  // First corner of a cell, and its sample.
  Vec3 lowOf(std::uint32_t cell) const {
    return cornerOf(brickOf(static_cast<std::int32_t>(cell / (kSlice * kBrickCells)))) + placeInBrick(cell);
  }
  const float* samplesOf(std::uint32_t cell) const {
    const Brick& brick = brickOf(static_cast<std::int32_t>(cell / (kSlice * kBrickCells)));
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
        if (cells.count + static_cast<int>(kBrickVolumeCells) > CellRows::kMost) hand();
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

namespace {

// The place of the surface that is nearest to the axis.
struct NearestSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  // `last`: a cell that is likely to hold the place, or kNoCell.
  Nearest nearest(double limit, std::uint32_t last) const {
    Nearest best{limit};
    if (isMarked(last)) searchOne(last, best);
    if (!(best.found && best.distance <= kClose)) {
      const std::int32_t seed = nearestBrick(limit);
      if (seed < 0) return best;
      if (perLength == 0.0)
        searchBrick(seed, best);
      else
        searchMiddle(seed, best);
    }
    if (perLength == 0.0)
      searchPoint(best);
    else
      searchAxis(best);
    return best;
  }

 private:
  std::int32_t nearestBrick(double limit) const {
    std::int32_t nearest = -1;
    for (const double reach : {0.5 * kClose, kClose, limit}) {
      double least = std::min(reach, limit);
      forEachBrick([&] { return least; },
                   [&](std::int32_t number, double distance) {
                     least = distance;
                     nearest = number;
                   });
      if (nearest >= 0 || reach >= limit) break;
    }
    return nearest;
  }

  void searchOne(std::uint32_t number, Nearest& best) const {
    SeenCells cells(span);
    const Brick& brick = brickOf(static_cast<std::int32_t>(number / kBrickVolumeCells));
    const Eigen::Vector3f q = inBrick(brick) - placeInBrick(number).cast<float>();
    for (int i = 0; i < 3; ++i) cells.point[i][0] = q[i];
    for (int i = 0; i < 8; ++i) cells.samples[i][0] = samplesOf(number)[kCorners[i]];
    cells.cell[0] = number;
    cells.count = 1;
    bound(cells);
    search(cells, 0, best);
  }

  // Search the cell of a brick with the least bound.
  void searchBrick(std::int32_t brick, Nearest& best) const {
    SeenCells cells(span);
    see(brick, kFarAxis, cells);
    bound(cells);
    search(cells, static_cast<int>(std::min_element(cells.least, cells.least + cells.count) - cells.least), best);
  }

  // A few batches at a time: what they find shortens the rest.
  void searchPoint(Nearest& best) const {
    constexpr int kBatch = 2 * kWidth;
    SeenCells cells(span);
    const auto searchAll = [&] {
      bound(cells);
      for (int i = 0; i < cells.count; ++i)
        if (boundOf(cells, i) <= best.distance) search(cells, i, best);
      cells.count = 0;
    };
    forEachBrick([&] { return best.distance; },
                 [&](std::int32_t number, double) {
                   see(number, best.distance, cells);
                   if (cells.count >= kBatch) searchAll();
                 });
    searchAll();
  }

  // Also of a curved surface.
  static double boundOf(const SeenCells& cells, int i) {
    return static_cast<double>(cells.least[i] - cells.flatness[i]);
  }

  // A cell counts with its distance or its bound, whichever is larger, so that the order of the search has no effect.
  // Of equal ones the smaller number wins.
  void search(const SeenCells& cells, int i, Nearest& best) const {
    const std::uint32_t cell = cells.cell[i];
    if (cell == best.cell) return;
    Touch touch;
    const Vec3 low = lowOf(cell);
    if (!nearestOn(Patch(samplesOf(cell)), a - low, touch)) return;
    const double distance = std::max((a - low - touch.point).norm(), boundOf(cells, i));
    if (distance < best.distance || (distance == best.distance && best.found && cell < best.cell))
      best = {distance, 0.0, low + touch.point, touch.gradient, true, cell};
  }

  void searchAxis(Nearest& best) const {
    forEachSeen([&] { return best.distance; },
                [&](const SeenCells& cells) {
                  const Order order(cells, best.distance);
                  CellPlaces places;
                  for (int first = 0; first < cells.count && order.least(first) < best.distance; first += kWidth) {
                    KnownMinima none;
                    none.best = static_cast<float>(best.distance);
                    const std::int16_t* const which = order.cells.data() + first;
                    loops().nearestOnCells(cells, which, std::min(cells.count - first, kWidth), none, &places);
                    for (unsigned lanes = places.nearest; lanes != 0;) {
                      const int lane = takeNearest(places, lanes), cell = which[lane];
                      if (static_cast<double>(places.least[lane]) < best.distance)
                        search(cells.cell[cell], static_cast<double>(cells.parameter[cell]), best);
                    }
                  }
                });
  }

  // At the nearest place of the axis, the way from the patch's nearest place is perpendicular to it. This is a root of
  // t minus the parameter nearest to the patch's nearest place. The function increases where the patch is flat. The
  // first step goes to that parameter, or to the end of the range if it hardly moves. Then regula falsi (Illinois).
  void search(std::uint32_t cell, double t, Nearest& best) const {
    const Patch patch(samplesOf(cell));
    const Vec3 low = lowOf(cell);
    Touch touch;
    double before = std::max(t - kHalfCell * perSpan, 0.0), beyond = std::min(t + kHalfCell * perSpan, 1.0);
    double atBefore = 0.0, atBeyond = 0.0;  // 0: not known
    for (int round = 0, last = 0; round < kRounds; ++round) {
      const bool isOn = nearestOn(patch, axisAt(t) - low, touch);
      const Vec3 way = axisAt(t) - low - touch.point;
      const double distance = way.norm();
      if (isOn && distance < best.distance) best = {distance, t, low + touch.point, touch.gradient, true};
      const double ahead = way.dot(span) * perLength;
      const int side = ahead < 0.0 ? -1 : 1;
      if (side == last) (side < 0 ? atBeyond : atBefore) *= 0.5;
      last = side;
      (side < 0 ? before : beyond) = t;
      (side < 0 ? atBefore : atBeyond) = ahead;
      const double end = side < 0 ? beyond : before, left = std::abs(end - t);
      const double gain = std::abs(ahead) / (perLength * std::max(distance, kSettled));  // cells, over the whole axis
      if (!(gain * left > kSettled && distance - gain * left < best.distance)) return;
      if (atBefore < 0.0 && atBeyond > 0.0)
        t = before + (beyond - before) * atBefore / (atBefore - atBeyond);
      else
        t = round > 0 || kFew * std::abs(ahead) < left ? end : t - ahead;
    }
  }

  // Search the cell with the nearest centre first; its result shortens the rest.
  void searchMiddle(std::int32_t brick, Nearest& best) const {
    double least = kNoLimit, parameter = 0.0;
    std::uint32_t chosen = kNoCell;
    forEachCell(
        brick, [&] { return least; },
        [&](std::uint32_t cell, const float*, const Eigen::Vector3f& q, float t) {
          const auto distance = static_cast<double>(q.norm());
          if (distance >= least) return;
          least = distance;
          parameter = static_cast<double>(t);
          chosen = cell;
        });
    if (chosen == kNoCell) return;
    search(chosen, parameter, best);
    best.distance = std::min(best.distance, least * kRounded + kFarthest);  // also if it found no place
  }
};

// A place that may be a minimum. Unless it is exact, only cell, distance and direction are known, as estimates.
struct Candidate {
  std::uint32_t cell;
  float distance;
  Eigen::Vector3f direction;  // to the point
  bool isExact = false;
  Nearest place = {};
};

// The minima of the distance from a point, nearest first.
struct Collected : KnownMinima {
  std::array<Candidate, kMost> all;

  // Keep the others for which `keeps` is true, and insert this one.
  template <typename Keeps>
  void add(const Candidate& candidate, const Keeps& keeps) {
    int kept = 0, place = 0;
    for (int i = 0; i < count; ++i)
      if (keeps(i)) {
        if (kept != i) all[kept] = all[i];
        ++kept;
        if (all[i].distance <= candidate.distance) place = kept;
      }
    if (place < kMost) {
      kept = std::min(kept, kMost - 1);
      std::copy_backward(all.begin() + place, all.begin() + kept, all.begin() + kept + 1);
      all[place] = candidate;
      ++kept;
    }
    count = kept;
    for (int i = 0; i < count; ++i) {
      distance[i] = all[i].distance;
      for (int k = 0; k < 3; ++k) direction[k][i] = all[i].direction[k];
    }
  }
};

struct MinimaSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  void minima(double reach, SolidMinima& minima) const {
    Nearest best{reach};
    Collected found;
    forEachSeen([&] { return reach; }, [&](const SeenCells& cells) { collect(cells, reach, best, found); });
    if (best.found) add(exact(0, best), found);  // also counts if the surface has no normal there that points to p
    minima.count = 0;
    for (int i = 0; i < found.count; ++i) {
      Nearest place = found.all[i].place;
      if (!found.all[i].isExact && !searchCell(found.all[i].cell, place)) continue;
      int at = minima.count++;  // estimates may have another order
      for (; at > 0 && place.distance * solid.cell() < minima.all[at - 1].distance; --at)
        minima.all[at] = minima.all[at - 1];
      minima.all[at] = answer(place, 1.0);
    }
  }

 private:
  // Whether two minima belong to two walls that meet in an edge. In a pit that fits the tool, the edge of their tangent
  // planes lies in the material. Directions are unit vectors to the point.
  bool areWalls(const Eigen::Vector3f& way, float distance, const Eigen::Vector3f& otherWay, float other) const {
    const float cosine = way.dot(otherWay), scale = 1.0f / std::max(1.0f - cosine * cosine, 1e-6f);
    const float share = (distance - cosine * other) * scale, otherShare = (other - cosine * distance) * scale;
    if (!(share > 0.0f && otherShare > 0.0f)) return false;  // the edge is not between them
    const Vec3 toEdge = -(share * way + otherShare * otherWay).cast<double>();
    const double far = std::max(distance, other), beyond = toEdge.norm() - far;
    return beyond > kResolved / far && valueAt(a + toEdge) > -0.5 * beyond;
  }

  // Whether a place in this direction (unit vector) is represented by a minimum that is not farther.
  bool isKnown(const Collected& found, const Eigen::Vector3f& unit, float distance) const {
    // At small angles the edge of areWalls() is not resolved: there `beyond` is distance (1 - cosine) / 4.
    const float resolved = 1.0f - 4.0f * static_cast<float>(kResolved) / std::max(distance * distance, 1.0f);
    const auto& [x, y, z] = found.direction;
    float cosine[Collected::kMost];
    for (int i = 0; i < Collected::kMost; ++i) cosine[i] = x[i] * unit.x() + y[i] * unit.y() + z[i] * unit.z();
    for (int i = 0; i < found.count && found.distance[i] <= distance; ++i)
      if (cosine[i] > kRepresentedCosine &&
          (cosine[i] > resolved || !areWalls(found.all[i].direction, found.distance[i], unit, distance)))
        return true;
    return false;
  }

  void add(const Candidate& one, Collected& found) const {
    if (isKnown(found, one.direction, one.distance)) return;
    found.add(one, [&](int i) {
      const Candidate& other = found.all[i];
      return other.direction.dot(one.direction) <= kRepresentedCosine || other.distance <= one.distance ||
             areWalls(other.direction, other.distance, one.direction, one.distance);
    });
  }

  Candidate exact(std::uint32_t cell, const Nearest& place) const {
    return {cell, static_cast<float>(place.distance), (a - place.point).cast<float>().stableNormalized(), true, place};
  }

  bool searchCell(std::uint32_t cell, Nearest& place) const {
    const Vec3 low = lowOf(cell), q = a - low;
    Touch touch;
    if (!nearestOn(Patch(samplesOf(cell)), q, touch)) return false;
    place = {(q - touch.point).norm(), 0.0, low + touch.point, touch.gradient, true};
    return true;
  }

  // The likely nearest first, so that others in the same direction need no closer look.
  void collect(const SeenCells& cells, double reach, Nearest& best, Collected& found) const {
    const Order order(cells, reach);
    CellPlaces places;
    for (int first = 0; first < cells.count; first += kWidth) {
      const double most = found.count < found.kMost
                              ? reach
                              : std::max(best.distance, static_cast<double>(found.distance[found.count - 1]));
      if (order.least(first) > most) return;
      found.best = static_cast<float>(best.distance);
      found.most = static_cast<float>(most);
      const std::int16_t* const which = order.cells.data() + first;
      loops().nearestOnCells(cells, which, std::min(cells.count - first, kWidth), found, &places);
      unsigned lanes = places.minima | places.nearest;
      while (lanes != 0) {
        const int lane = takeNearest(places, lanes);
        lookAt(cells.cell[which[lane]], places, lane, reach, best, found);
      }
    }
  }

  void lookAt(std::uint32_t cell, const CellPlaces& places, int lane, double reach, Nearest& best,
              Collected& found) const {
    const float distance = places.distance[lane], least = places.least[lane];
    if (static_cast<double>(least) < best.distance || distance - least > 2.0f * kCellError) {
      Nearest place{};
      if (!searchCell(cell, place)) return;
      if (place.distance < best.distance) best = place;
      if (place.distance <= reach &&
          (a - place.point).dot(place.gradient) > kAligned * place.distance * place.gradient.norm())
        add(exact(cell, place), found);
    } else if ((places.minima >> lane & 1) != 0) {
      const Eigen::Vector3f way(places.way[0][lane], places.way[1][lane], places.way[2][lane]);
      add({cell, distance, way / std::max(distance, 1e-6f)}, found);
    }
  }
};

}  // namespace

bool isInside(const Solid& solid, const Vec3& p) noexcept { return SolidQuery(solid, p, p).isInside(); }

SolidPoint signedDistance(const Solid& solid, const Vec3& p, double limit, SolidCache* cache) noexcept {
  if (!p.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const NearestSearch query(solid, p, p);
  const Nearest found = query.nearest(limit / solid.cell(), cache == nullptr ? kNoCell : cache->cell);
  if (cache != nullptr && found.found) cache->cell = found.cell;
  return query.answer(found, query.isInside() ? -1.0 : 1.0);
}

SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit) noexcept {
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const NearestSearch query(solid, segment.a, segment.b);
  return query.answer(query.nearest(limit / solid.cell(), kNoCell), 1.0);
}

void kernel::findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept {
  minima.count = 0;
  if (p.allFinite() && reach >= 0.0) MinimaSearch(solid, p, p).minima(reach / solid.cell(), minima);
}

}  // namespace enamel
