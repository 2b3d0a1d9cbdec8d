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
constexpr double kSameMinimum = 0.02;
constexpr double kClear = 0.5;                         // farther away the offset from the surface gives its normal
constexpr double kAligned = 0.9396926207859084;        // cos 20 deg
constexpr double kSameDirection = 0.8660254037844386;  // cos 30 deg

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
    const Vec3 corner = cornerOf(brick), seen = a - corner - Vec3::Constant(0.5);
    for (int z = 0; z < kBrickCells; ++z) {
      std::uint64_t left = brick.surface[z];
      if (left != 0 && perLength == 0.0) left &= cellsAbout(seen, z, reach() + kHalfCell);
      for (; left != 0; left &= left - 1) {
        const int bit = __builtin_ctzll(left), x = bit % kBrickCells, y = bit / kBrickCells;
        double qx = seen.x() - x, qy = seen.y() - y, qz = seen.z() - z, t = 0.0;
        if (perLength > 0.0) {
          t = std::clamp(-(qx * span.x() + qy * span.y() + qz * span.z()) * perLength, 0.0, 1.0);
          qx += t * span.x();
          qy += t * span.y();
          qz += t * span.z();
        }
        const double most = reach() + kHalfCell;
        if (qx * qx + qy * qy + qz * qz > most * most) continue;
        visit(brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x,
              Vec3(corner.x() + x, corner.y() + y, corner.z() + z), Vec3(qx, qy, qz), t);
      }
    }
  }

  static Vec3 cornerOf(const Brick& brick) {
    return kBrickCells * Vec3(brick.place[0], brick.place[1], brick.place[2]);
  }

  // Pass on the cells that may have a place within reach of the point, as many as fit at a time.
  template <typename Visit>
  void forEachSeen(double reach, const Visit& visit) const {
    SeenCells cells;
    const auto hand = [&] {
      cells.look();
      visit(std::as_const(cells));
      cells.count = 0;
    };
    const auto within = [&] { return reach; };
    forEachBrick(within, [&](std::int32_t, const Brick& brick, double) {
      forEachCell(brick, within, [&](const float* samples, const Vec3& low, const Vec3& q, double) {
        if (cells.count == kMostSeen) hand();
        cells.add(samples, low, q);
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

  bool isInside() const {
    std::array<int, 3> at;
    for (int i = 0; i < 3; ++i) {
      if (!(a[i] >= 0.0 && a[i] < static_cast<double>(kBrickCells) * solid.count_[i])) return false;
      at[i] = static_cast<int>(a[i]);
    }
    const std::int32_t number = solid.brickAt(at[0] / kBrickCells, at[1] / kBrickCells, at[2] / kBrickCells);
    if (number < 0) return false;
    const Brick& brick = brickOf(number);
    const int x = at[0] % kBrickCells, y = at[1] % kBrickCells, z = at[2] % kBrickCells;
    const Patch patch(brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x);
    Vec3 gradient;
    return patch.at(a - Vec3(at[0], at[1], at[2]), gradient) < 0.0;
  }
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
    if (perLength == 0.0)
      forEachSeen(best.distance, [&](const SeenCells& cells) { search(cells, best); });
    else
      searchAll(best);
    if (best.found || best.distance == limit) return best;
    Nearest any{limit};  // for the case that all of those cells have none
    searchAll(any);
    return any;
  }

  void searchAll(Nearest& best) const {
    forEachBrick([&] { return best.distance; }, [&](std::int32_t, const Brick& brick, double) { search(brick, best); });
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

  void search(const Brick& brick, Nearest& best) const {
    const Eigen::Vector3f step = (kHalfCell * perSpan * span).cast<float>();
    const auto reach = [&] { return best.distance; };
    forEachCell(brick, reach, [&](const float* samples, const Vec3& low, const Vec3& q, double t) {
      const Plane plane = planeOf(samples, q);
      // The axis may be nearest elsewhere, at most half a diagonal ahead or back.
      const float rise = plane.perNorm * (plane.gx * step.x() + plane.gy * step.y() + plane.gz * step.z());
      const float alongX = step.x() - rise * plane.gx * plane.perNorm,
                  alongY = step.y() - rise * plane.gy * plane.perNorm,
                  alongZ = step.z() - rise * plane.gz * plane.perNorm;
      const float slide = std::max({std::abs(alongX), std::abs(alongY), std::abs(alongZ)});
      if (static_cast<double>(plane.least(std::abs(rise), slide)) < best.distance) search(low, samples, t, best);
    });
  }

  void search(const SeenCells& cells, Nearest& best) const {
    const Order order(cells, best.distance);
    for (int i = 0; i < cells.count; ++i) {
      const int cell = order.cells[i];
      if (static_cast<double>(cells.least[cell]) < best.distance)
        search(cells.low[cell].cast<double>(), cells.samples[cell], 0.0, best);
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

// The minima of the distance from a point; of each direction the nearest.
struct Collected {
  std::array<Nearest, kMaxSolidMinima> all;
  int count = 0;

  // Whether there is one in about the direction of `way` that is not farther than `distance`.
  bool has(const Vec3& p, const Vec3& way, double length, double distance) const {
    for (int i = 0; i < count; ++i)
      if (all[i].distance <= distance && way.dot(p - all[i].point) > kSameDirection * all[i].distance * length)
        return true;
    return false;
  }

  void add(const Vec3& p, const Nearest& candidate) {
    const Vec3 way = p - candidate.point;
    if (has(p, way, candidate.distance, candidate.distance)) return;
    int kept = 0;
    for (int i = 0; i < count; ++i)
      if (!(way.dot(p - all[i].point) > kSameDirection * all[i].distance * candidate.distance)) all[kept++] = all[i];
    count = kept;
    int place = count;
    while (place > 0 && candidate.distance < all[place - 1].distance) --place;
    if (place == kMaxSolidMinima) return;
    count = std::min(count + 1, kMaxSolidMinima);
    std::copy_backward(all.begin() + place, all.begin() + count - 1, all.begin() + count);
    all[place] = candidate;
  }
};

struct MinimaSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  void minima(double reach, SolidMinima& minima) const {
    Nearest best{reach};
    Collected found;
    forEachSeen(reach, [&](const SeenCells& cells) { collect(cells, reach, best, found); });
    if (best.found) found.add(a, best);  // also counts if the surface has no normal there that points to p
    for (int i = 0; i < found.count; ++i) minima.all[i] = answer(found.all[i], 1.0);
    minima.count = found.count;
  }

 private:
  // The likely nearest first, so that others in the same direction need no closer look.
  void collect(const SeenCells& cells, double reach, Nearest& best, Collected& found) const {
    const Order order(cells, reach);
    for (int i = 0; i < cells.count; ++i) {
      const int cell = order.cells[i];
      const double least = static_cast<double>(cells.least[cell]), distance = static_cast<double>(cells.distance[cell]);
      if (least > reach) continue;
      const Vec3 low = cells.low[cell].cast<double>(), q = a - low;
      const auto isOne = [&] {
        const Vec3 toCentre = q - Vec3::Constant(0.5);
        return cells.outside[cell] <= 0.75f + 2.0f * cells.flatness[cell] * cells.distance[cell] &&
               (found.count < kMaxSolidMinima || least < found.all[found.count - 1].distance) &&
               !found.has(a, toCentre, toCentre.norm(), distance + kSameMinimum);
      };
      if (least >= best.distance && !isOne()) continue;
      Touch touch;
      if (!nearestOn(Patch(cells.samples[cell]), q, touch)) continue;
      const Vec3 way = q - touch.point;
      const Nearest candidate{way.norm(), 0.0, low + touch.point, touch.gradient, true};
      if (candidate.distance < best.distance) best = candidate;
      if (candidate.distance <= reach &&
          way.dot(touch.gradient) > kAligned * candidate.distance * touch.gradient.norm())
        found.add(a, candidate);
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
