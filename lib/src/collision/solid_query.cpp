#include "solid_query.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solid_cells.inl"

namespace enamel {

using namespace kernel;

namespace {

constexpr double kFarthest = 1.0;  // above half a diagonal: a cell with surface has a place so near its centre
constexpr double kClose = 2.0 * kBrickCells;
constexpr int kRounds = 8;    // of an axis and a patch
constexpr double kFew = 4.0;  // a first step shorter than 1 / kFew of the range goes to its end instead
constexpr float kSameMinimum = 0.02f;
constexpr double kClear = 0.5;                   // farther away the offset from the surface gives its normal
constexpr double kAligned = 0.9396926207859084;  // cos 20 deg
// Of minima within 30 deg the nearest represents the others, unless they are of two walls.
constexpr float kSameDirection = 0.8660254f;
constexpr double kResolved = 0.25;  // times h^2 / R: the error of the interpolation

struct Nearest {
  double distance;
  double parameter = 0.0;
  Vec3 point = Vec3::Zero(), gradient = Vec3::UnitZ();
  bool found = false;
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
          const Vec3 q = centre - axisAt(parameterAt(centre));
          const double distance = perLength > 0.0 ? q.norm() - kBrickCells * kHalfCell
                                                  : (q.array().abs() - 0.5 * kBrickCells).max(0.0).matrix().norm();
          if (distance <= reach()) visit(number, brickOf(number), distance);
        }
  }

  // Visit the cells of a brick with surface within `reach()` of the axis. Arguments: samples, corner, centre of the
  // cell relative to the axis, place of the axis.
  template <typename Reach, typename Visit>
  void forEachCell(const Brick& brick, const Reach& reach, const Visit& visit) const {
    const Vec3 corner = cornerOf(brick), first = corner + Vec3::Constant(0.5), seen = a - first;
    // The part of the axis that may be in reach, and a box around it.
    const double around = reach() + kHalfCell, half = (kBrickCells * kHalfCell + around) * perSpan;
    const double middle = parameterAt(corner + Vec3::Constant(0.5 * kBrickCells));
    const Vec3 from = axisAt(std::max(middle - half, 0.0)) - first, to = axisAt(std::min(middle + half, 1.0)) - first;
    std::array<std::uint32_t, 3> within;
    for (int i = 0; i < 3; ++i)
      within[i] = cellsBetween(std::min(from[i], to[i]) - around, std::max(from[i], to[i]) + around);
    std::uint64_t slice = 0;
    for (std::uint32_t rows = within[1]; rows != 0; rows &= rows - 1)
      slice |= std::uint64_t{within[0]} << (kBrickCells * __builtin_ctz(rows));
    for (; within[2] != 0; within[2] &= within[2] - 1) {
      const int z = __builtin_ctz(within[2]);
      for (std::uint64_t left = brick.surface[z] & slice; left != 0; left &= left - 1) {
        const int bit = __builtin_ctzll(left), x = bit % kBrickCells, y = bit / kBrickCells;
        Vec3 q(seen.x() - x, seen.y() - y, seen.z() - z);
        double t = 0.0;
        if (perLength > 0.0) {
          t = std::clamp(-q.dot(span) * perLength, 0.0, 1.0);
          q += t * span;
        }
        const double most = reach() + kHalfCell;
        if (q.squaredNorm() > most * most) continue;
        visit(brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x,
              Vec3(corner.x() + x, corner.y() + y, corner.z() + z), q, t);
      }
    }
  }

  static Vec3 cornerOf(const Brick& brick) {
    return kBrickCells * Vec3(brick.place[0], brick.place[1], brick.place[2]);
  }

  // Pass on the cells that may have a place within `reach()` of the axis, as many as fit at a time.
  template <typename Reach, typename Visit>
  void forEachSeen(const Reach& reach, const Visit& visit) const {
    SeenCells cells;
    const Eigen::Vector3f step = (kHalfCell * perSpan * span).cast<float>();
    const auto hand = [&] {
      cells.look(step);
      visit(std::as_const(cells));
      cells.count = 0;
    };
    forEachBrick(reach, [&](std::int32_t, const Brick& brick, double) {
      forEachCell(brick, reach, [&](const float* samples, const Vec3& low, const Vec3& q, double t) {
        if (cells.count == kMostSeen) hand();
        cells.add(samples, low, q, t);
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

  Nearest nearest(double limit) const {
    const Nearest close = nearestWithin(std::min(limit, kClose));
    return close.found || limit <= kClose ? close : nearestWithin(limit);
  }

 private:
  Nearest nearestWithin(double limit) const {
    Nearest best{limit};
    std::int32_t seed = -1;
    double least = limit;
    forEachBrick([&] { return least; },
                 [&](std::int32_t number, const Brick&, double distance) {
                   least = distance;
                   seed = number;
                 });
    if (seed < 0) return best;
    searchMiddle(brickOf(seed), best);
    searchAll(best);
    if (best.found || best.distance == limit) return best;
    Nearest any{limit};  // for the case that all of those cells have none
    searchAll(any);
    return any;
  }

  void searchAll(Nearest& best) const {
    forEachSeen([&] { return best.distance; },
                [&](const SeenCells& cells) {
                  const Order order(cells, best.distance);
                  for (int i = 0; i < cells.count; ++i) {
                    const int cell = order.cells[i];
                    if (static_cast<double>(cells.least[cell]) < best.distance)
                      search(cells.low[cell].cast<double>(), cells.samples[cell], cells.parameter[cell], best);
                  }
                });
  }

  // At the nearest place of the axis, the way from the patch's nearest place is perpendicular to it. This is a root of
  // t minus the parameter nearest to the patch's nearest place. The function increases where the patch is flat. The
  // first step goes to that parameter, or to the end of the range if it hardly moves. Then regula falsi (Illinois).
  void search(const Vec3& low, const float* samples, double t, Nearest& best) const {
    const Patch patch(samples);
    Touch touch;
    double before = std::max(t - kHalfCell * perSpan, 0.0), beyond = std::min(t + kHalfCell * perSpan, 1.0);
    double atBefore = 0.0, atBeyond = 0.0;  // 0: not known
    for (int round = 0, last = 0; round < kRounds; ++round) {
      const bool isOn = nearestOn(patch, axisAt(t) - low, touch);
      const Vec3 way = axisAt(t) - low - touch.point;
      const double distance = way.norm();
      if (isOn && distance < best.distance) best = {distance, t, low + touch.point, touch.gradient, true};
      if (perLength == 0.0) return;
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
  void searchMiddle(const Brick& brick, Nearest& best) const {
    double least = kNoLimit, parameter = 0.0;
    Vec3 corner = Vec3::Zero();
    const float* chosen = nullptr;
    const auto reach = [&] { return std::min(least, best.distance); };
    forEachCell(brick, reach, [&](const float* samples, const Vec3& low, const Vec3& q, double t) {
      const double distance = q.norm();
      if (distance >= least) return;
      least = distance;
      corner = low;
      parameter = t;
      chosen = samples;
    });
    if (chosen == nullptr) return;
    search(corner, chosen, parameter, best);
    best.distance = std::min(best.distance, least + kFarthest);  // also if it found no place
  }
};

// The minima of the distance from a point, nearest first.
struct Collected {
  std::array<Nearest, kMaxSolidMinima> all;
  int count = 0;
  // For all of them at once: distance and direction of the point. In float, as it only selects.
  float distance[kMaxSolidMinima], x[kMaxSolidMinima], y[kMaxSolidMinima], z[kMaxSolidMinima];

  Collected() { std::fill(std::begin(distance), std::end(distance), static_cast<float>(kNoLimit)); }

  Eigen::Vector3f direction(int i) const { return {x[i], y[i], z[i]}; }

  // Whether there is one within an angle of the vector that is not farther than `most`.
  bool has(const Eigen::Vector3f& way, float most, float cosine) const {
    const float wayX = way.x(), wayY = way.y(), wayZ = way.z(), least = cosine * way.norm();
    int found = 0;
    for (int i = 0; i < kMaxSolidMinima; ++i)
      found |=
          static_cast<int>(distance[i] <= most) & static_cast<int>(x[i] * wayX + y[i] * wayY + z[i] * wayZ > least);
    return found != 0;
  }

  // Keep the others for which `keeps` is true, and insert this one.
  template <typename Keeps>
  void add(const Vec3& p, const Nearest& candidate, const Keeps& keeps) {
    int kept = 0, place = 0;
    for (int i = 0; i < count; ++i)
      if (keeps(i)) {
        all[kept++] = all[i];
        if (all[i].distance <= candidate.distance) place = kept;
      }
    if (place < kMaxSolidMinima) {
      kept = std::min(kept, kMaxSolidMinima - 1);
      std::copy_backward(all.begin() + place, all.begin() + kept, all.begin() + kept + 1);
      all[place] = candidate;
      ++kept;
    }
    count = kept;
    for (int i = 0; i < kMaxSolidMinima; ++i) {
      const bool isOne = i < count;
      const Eigen::Vector3f to = isOne ? Eigen::Vector3f((p - all[i].point).cast<float>().stableNormalized())
                                       : Eigen::Vector3f(Eigen::Vector3f::Zero());
      distance[i] = static_cast<float>(isOne ? all[i].distance : kNoLimit);
      x[i] = to.x();
      y[i] = to.y();
      z[i] = to.z();
    }
  }
};

struct MinimaSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  void minima(double reach, SolidMinima& minima) const {
    Nearest best{reach};
    Collected found;
    forEachSeen([&] { return reach; }, [&](const SeenCells& cells) { collect(cells, reach, best, found); });
    if (best.found) add(best, found);  // also counts if the surface has no normal there that points to p
    for (int i = 0; i < found.count; ++i) minima.all[i] = answer(found.all[i], 1.0);
    minima.count = found.count;
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

  // Whether a place in this direction is represented by a minimum that is not farther than `most`.
  bool isKnown(const Collected& found, const Eigen::Vector3f& way, float distance, float most) const {
    if (!found.has(way, most, kSameDirection)) return false;
    // At small angles the edge of areWalls() is not resolved: there `beyond` is distance (1 - cosine) / 4.
    const float resolved = 1.0f - 4.0f * static_cast<float>(kResolved) / std::max(distance * distance, 1.0f);
    if (found.has(way, most, std::max(resolved, kSameDirection))) return true;
    const Eigen::Vector3f unit = way.stableNormalized();
    for (int i = 0; i < found.count; ++i)
      if (found.distance[i] <= most && found.direction(i).dot(unit) > kSameDirection &&
          !areWalls(found.direction(i), found.distance[i], unit, distance))
        return true;
    return false;
  }

  void add(const Nearest& candidate, Collected& found) const {
    const Eigen::Vector3f way = (a - candidate.point).cast<float>();
    const auto distance = static_cast<float>(candidate.distance);
    if (isKnown(found, way, distance, distance)) return;
    const Eigen::Vector3f unit = way.stableNormalized();
    found.add(a, candidate, [&](int i) {
      return found.direction(i).dot(unit) <= kSameDirection || found.distance[i] <= distance ||
             areWalls(found.direction(i), found.distance[i], unit, distance);
    });
  }

  // The likely nearest first, so that others in the same direction need no closer look.
  void collect(const SeenCells& cells, double reach, Nearest& best, Collected& found) const {
    const Order order(cells, reach);
    for (int i = 0; i < cells.count; ++i) {
      const int cell = order.cells[i];
      const double least = static_cast<double>(cells.least[cell]);
      if (least > reach) continue;
      const Vec3 low = cells.low[cell].cast<double>(), q = a - low;
      const auto isOne = [&] {
        const auto& [x, y, z] = cells.toCentre;
        return cells.outside[cell] <= 0.75f + 2.0f * cells.flatness[cell] * cells.distance[cell] &&
               (found.count < kMaxSolidMinima || least < found.all[found.count - 1].distance) &&
               !isKnown(found, {x[cell], y[cell], z[cell]}, cells.distance[cell], cells.distance[cell] + kSameMinimum);
      };
      if (least >= best.distance && !isOne()) continue;
      Touch touch;
      if (!nearestOn(Patch(cells.samples[cell]), q, touch)) continue;
      const Vec3 way = q - touch.point;
      const Nearest candidate{way.norm(), 0.0, low + touch.point, touch.gradient, true};
      if (candidate.distance < best.distance) best = candidate;
      if (candidate.distance <= reach &&
          way.dot(touch.gradient) > kAligned * candidate.distance * touch.gradient.norm())
        add(candidate, found);
    }
  }
};

}  // namespace

bool isInside(const Solid& solid, const Vec3& p) noexcept { return SolidQuery(solid, p, p).isInside(); }

SolidPoint signedDistance(const Solid& solid, const Vec3& p, double limit) noexcept {
  if (!p.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const NearestSearch query(solid, p, p);
  return query.answer(query.nearest(limit / solid.cell()), query.isInside() ? -1.0 : 1.0);
}

SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit) noexcept {
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const NearestSearch query(solid, segment.a, segment.b);
  return query.answer(query.nearest(limit / solid.cell()), 1.0);
}

void kernel::findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept {
  minima.count = 0;
  if (p.allFinite() && reach >= 0.0) MinimaSearch(solid, p, p).minima(reach / solid.cell(), minima);
}

}  // namespace enamel
