#include "solid_query.hpp"

#include "solid_axis.inl"

namespace enamel {

namespace {

constexpr double kFarthest = 1.0;  // above half a diagonal: a cell with surface has a place so near its centre
constexpr double kClose = 2.0 * kBrickCells;
constexpr int kRounds = 8;    // of an axis and a patch
constexpr double kFew = 4.0;  // a first step shorter than 1 / kFew of the range goes to its end instead

// The place of the surface that is nearest to the axis.
struct NearestSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  // `last`: a cell that is likely to hold the place, or kNoCell.
  Nearest nearest(double limit, std::uint32_t last) const {
    Nearest best{limit};
    if (isMarked(last) && perLength == 0.0) searchOne(last, best);
    if (isMarked(last) && perLength > 0.0) search(last, parameterAt(lowOf(last) + Vec3::Constant(0.5)), best);
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
    const Brick& brick = brickOf(static_cast<std::int32_t>(number / kCellsInBrick));
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
      if (isOn && distance < best.distance) best = {distance, t, low + touch.point, touch.gradient, true, cell};
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
  SolidCache none;
  return kernel::closestToSegment(solid, segment, limit, none);
}

SolidPoint kernel::closestToSegment(const Solid& solid, const Segment& segment, double limit,
                                    SolidCache& cache) noexcept {
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const NearestSearch query(solid, segment.a, segment.b);
  const Nearest found = query.nearest(limit / solid.cell(), cache.cell);
  if (found.found) cache.cell = found.cell;
  return query.answer(found, 1.0);
}

}  // namespace enamel
