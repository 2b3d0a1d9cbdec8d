#include "solid_query.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enamel {

// Lengths in cells, places from the corner of the solid's box.
struct SolidQuery {
  using Brick = Solid::Brick;

  static constexpr double kHalfCell = 0.8660254037844386;  // half its diagonal
  static constexpr double kSettled = 1e-3;
  static constexpr double kFarthest = 1.0;  // above half its diagonal: a cell with surface has a place within that
  static constexpr double kClose = 2.0 * kBrickCells;
  static constexpr int kSteps = 2, kReturns = 3;  // on a patch
  static constexpr int kRounds = 8;               // of an axis and a patch
  static constexpr double kShortest = 0.1;        // share of a step
  static constexpr double kFew = 4.0;             // steps so short leave most of the way
  static constexpr double kNoGradient = 1e-6;     // squared
  static constexpr double kSameMinimum = 0.02;
  static constexpr int kMostSeen = 1000;  // no power of two: its arrays would share lines of the cache
  static constexpr float kSmooth = 0.1f;
  static constexpr double kClear = 0.5;                         // where the way to the surface gives its normal
  static constexpr double kAligned = 0.9396926207859084;        // cos 20 deg
  static constexpr double kSameDirection = 0.8660254037844386;  // cos 30 deg

  const Solid& solid;
  Vec3 a, span;
  double perLength, perSpan;  // one over the span's length squared, and over it; 0 for a point

  SolidQuery(const Solid& of, const Vec3& from, const Vec3& to)
      : solid(of), a((from - of.origin_) / of.cell_), span((to - from) / of.cell_) {
    const double squared = span.squaredNorm();
    perLength = squared > 0.0 ? 1.0 / squared : 0.0;
    perSpan = std::sqrt(perLength);
  }

  double parameterAt(const Vec3& p) const { return std::clamp((p - a).dot(span) * perLength, 0.0, 1.0); }
  Vec3 axisAt(double t) const { return a + t * span; }

  // The samples at the corners of a cell, x fastest, from the first of them.
  static constexpr int kBack = kBrickSamples, kUp = kBrickSamples * kBrickSamples;
  static constexpr int kCorners[8] = {0, 1, kBack, kBack + 1, kUp, kUp + 1, kUp + kBack, kUp + kBack + 1};

  // Trilinear interpolation in a cell and its gradient.
  struct Patch {
    double c[8];

    explicit Patch(const float* s) {
      for (int i = 0; i < 8; ++i) c[i] = static_cast<double>(s[kCorners[i]]);
    }

    double at(const Vec3& u, Vec3& gradient) const {
      const double x = u[0], y = u[1], z = u[2];
      const double x00 = c[0] + x * (c[1] - c[0]), x10 = c[2] + x * (c[3] - c[2]);
      const double x01 = c[4] + x * (c[5] - c[4]), x11 = c[6] + x * (c[7] - c[6]);
      const double y0 = x00 + y * (x10 - x00), y1 = x01 + y * (x11 - x01);
      const double dx0 = (c[1] - c[0]) + y * ((c[3] - c[2]) - (c[1] - c[0]));
      const double dx1 = (c[5] - c[4]) + y * ((c[7] - c[6]) - (c[5] - c[4]));
      gradient = Vec3(dx0 + z * (dx1 - dx0), (x10 - x00) + z * ((x11 - x01) - (x10 - x00)), y1 - y0);
      return y0 + z * (y1 - y0);
    }
  };

  static Vec3 inCell(const Vec3& u) { return u.cwiseMax(0.0).cwiseMin(1.0); }

  struct Touch {
    Vec3 point, gradient;  // point in the cell
  };

  // The tangent plane at the centre of a cell, seen from q, which is given from there. In float: to choose by.
  struct Plane {
    float distance;  // of q, not negative
    float flatness;  // no place of the patch is farther from the plane; normals turn by about four times as much
    float outside;   // from the centre to the plane's place nearest to q, the largest coordinate
    float gx, gy, gz, perNorm;  // gradient, one over its length

    // The corners of the cell, x fastest.
    Plane(float s0, float s1, float s2, float s3, float s4, float s5, float s6, float s7, float qx, float qy,
          float qz) {
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

    // Nothing of the patch is nearer, but for a smooth one by some hundredths of a cell: in a pit that fits the bur all
    // places are about as near. Where q may be elsewhere: nearer to the plane by `rise`, its place on it by `slide`.
    float least(float rise, float slide) const {
      const float ahead = std::max(distance - rise - (flatness < kSmooth ? 0.1f * flatness : flatness), 0.0f);
      const float aside = std::max(outside - slide - 0.5f - flatness, 0.0f);  // so far beside it the cell begins
      return std::sqrt(ahead * ahead + aside * aside);
    }
  };

  // From a place of the cell with this value towards the surface, and `length` of `way` beside it; at the border along
  // it. `along`: what of the way lies along the surface.
  static bool step(Vec3 way, double length, double value, Vec3 gradient, Vec3& u, Vec3& along) {
    Vec3 next;
    for (bool isOut = true; isOut;) {
      const double squared = gradient.squaredNorm();
      if (!(squared > kNoGradient)) return false;
      const double perSquared = 1.0 / squared;
      along = way - gradient * (gradient.dot(way) * perSquared);
      next = u - gradient * (value * perSquared) + length * along;
      isOut = false;
      for (int i = 0; i < 3; ++i) {
        if (gradient[i] == 0.0 || !(u[i] <= 0.0 ? next[i] < 0.0 : u[i] >= 1.0 && next[i] > 1.0)) continue;
        gradient[i] = way[i] = 0.0;
        isOut = true;
      }
    }
    u = inCell(next);
    return true;
  }

  // Goes to the place of the patch nearest to q. Of the way to q what lies along the surface, in steps as long as the
  // last one was right (Barzilai and Borwein 1988): where the surface curves by more than 1 over the distance, whole
  // ones diverge. False: it came to a corner off the surface.
  static bool approach(const Patch& patch, const Vec3& q, Touch& touch) {
    Vec3 &u = touch.point, &g = touch.gradient;
    Vec3 move = Vec3::Zero(), along = Vec3::Zero();
    for (int round = 0; round < kSteps; ++round) {
      const double f = patch.at(u, g);
      const Vec3 from = u, way = q - u;
      double length = 1.0;
      if (round > 0) {
        const double turned = move.dot(along - (way - g * (g.dot(way) / g.squaredNorm())));
        if (turned > 0.0) length = std::clamp(move.squaredNorm() / turned, kShortest, 1.0);
      }
      if (!step(way, length, f, g, u, along)) return false;
      move = u - from;
      if (move.cwiseAbs().maxCoeff() < kSettled) break;
    }
    for (int round = 0; round < kReturns; ++round) {
      const double f = patch.at(u, g);
      if (f * f <= kSettled * kSettled * g.squaredNorm()) return true;
      if (round + 1 == kReturns || !step(Vec3::Zero(), 0.0, f, g, u, along)) return false;
    }
    return false;
  }

  static bool nearestOn(const Patch& patch, const Vec3& q, Touch& touch) {
    touch.point = inCell(q);
    if (approach(patch, q, touch)) return true;
    // Again from where the surface meets an edge of the cell.
    double least = kNoLimit;
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        const int next = corner | 1 << axis;
        const double from = patch.c[corner], to = patch.c[next];
        if (next == corner || (from < 0.0) == (to < 0.0)) continue;
        Vec3 u(corner & 1, corner >> 1 & 1, corner >> 2);
        u[axis] = from / (from - to);
        const double squared = (q - u).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        touch.point = u;
      }
    const Vec3 onEdge = touch.point;
    if (least < kNoLimit && !approach(patch, q, touch)) {
      touch.point = onEdge;
      patch.at(onEdge, touch.gradient);
    }
    return least < kNoLimit;
  }

  // Visits the bricks with surface that may have a place within `reach()` of the axis.
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
          if (distance <= reach()) visit(number, solid.bricks_[static_cast<std::size_t>(number)], distance);
        }
  }

  // Visits the cells of a brick with surface within `reach()` of the axis: samples, corner, centre of the cell seen
  // from the axis, place of the axis.
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

  // Cells of a slice whose centres may be so near: those in the square about the circle.
  static std::uint64_t cellsAbout(const Vec3& seen, int z, double most) {
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

  static Vec3 cornerOf(const Brick& brick) {
    return kBrickCells * Vec3(brick.place[0], brick.place[1], brick.place[2]);
  }

  static Plane planeOf(const float* s, const Vec3& q) {
    const auto& [s0, s1, s2, s3, s4, s5, s6, s7] = kCorners;
    const Eigen::Vector3f f = q.cast<float>();
    return {s[s0], s[s1], s[s2], s[s3], s[s4], s[s5], s[s6], s[s7], f.x(), f.y(), f.z()};
  }

  struct Nearest {
    double distance;
    double parameter = 0.0;
    Vec3 point = Vec3::Zero(), gradient = Vec3::UnitZ();
    bool found = false;
  };

  // Where the axis is nearest, the way from the patch's nearest place is square to it: a root of t minus the axis'
  // place nearest to the patch's, which rises where the patch is flat. First to that place, or where that is no way at
  // all as far as it may be, then regula falsi (Illinois).
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
      const double gain = std::abs(ahead) / (perLength * std::max(distance, kSettled));  // cells, over all of the axis
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
      // The axis may be nearest elsewhere, half a diagonal ahead or back at most.
      const float rise = plane.perNorm * (plane.gx * step.x() + plane.gy * step.y() + plane.gz * step.z());
      const float alongX = step.x() - rise * plane.gx * plane.perNorm,
                  alongY = step.y() - rise * plane.gy * plane.perNorm,
                  alongZ = step.z() - rise * plane.gz * plane.perNorm;
      const float slide = std::max({std::abs(alongX), std::abs(alongY), std::abs(alongZ)});
      if (static_cast<double>(plane.least(std::abs(rise), slide)) < best.distance) search(low, samples, t, best);
    });
  }

  // Cells as seen from the point, number by number, so that several are looked at in one go.
  struct SeenCells {
    int count = 0;
    std::array<const float*, kMostSeen> samples;
    std::array<Eigen::Vector3f, kMostSeen> low;
    float toCentre[3][kMostSeen], corners[8][kMostSeen];
    float distance[kMostSeen], flatness[kMostSeen], outside[kMostSeen];  // as of Plane
    float least[kMostSeen];                                              // nothing of the patch is nearer

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

  // Numbers of the cells by the shares of the reach that nothing of them is nearer than, the least first.
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

  void search(const SeenCells& cells, Nearest& best) const {
    const Order order(cells, best.distance);
    for (int i = 0; i < cells.count; ++i) {
      const int cell = order.cells[i];
      if (static_cast<double>(cells.least[cell]) < best.distance)
        search(cells.low[cell].cast<double>(), cells.samples[cell], 0.0, best);
    }
  }

  // Hands on the cells that may have a place within reach of the point, as many as fit at a time.
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

  // The cell whose centre is nearest: what is found there makes the rest short.
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
    best.distance = std::min(best.distance, least + kFarthest);  // whether it found its place or not
  }

  Nearest nearest(double limit) const {
    const Nearest close = nearestWithin(std::min(limit, kClose));
    return close.found || limit <= kClose ? close : nearestWithin(limit);
  }

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
    searchMiddle(solid.bricks_[static_cast<std::size_t>(seed)], best);
    if (perLength == 0.0)
      forEachSeen(best.distance, [&](const SeenCells& cells) { search(cells, best); });
    else
      searchAll(best);
    if (best.found || best.distance == limit) return best;
    Nearest any{limit};  // where all of those cells have none
    searchAll(any);
    return any;
  }

  void searchAll(Nearest& best) const {
    forEachBrick([&] { return best.distance; }, [&](std::int32_t, const Brick& brick, double) { search(brick, best); });
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
    answer.normal = found.distance > kClear ? Vec3(way / found.distance) : gradient;
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
    const Brick& brick = solid.bricks_[static_cast<std::size_t>(number)];
    const int x = at[0] % kBrickCells, y = at[1] % kBrickCells, z = at[2] % kBrickCells;
    const Patch patch(brick.samples.data() + (z * kBrickSamples + y) * kBrickSamples + x);
    Vec3 gradient;
    return patch.at(a - Vec3(at[0], at[1], at[2]), gradient) < 0.0;
  }

  // The minima of the distance from a point that were found; of each direction the nearest.
  struct Collected {
    std::array<Nearest, kernel::kMaxSolidMinima> all;
    int count = 0;

    // One in about the direction of `way` that is not farther than `distance`.
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
      if (place == kernel::kMaxSolidMinima) return;
      count = std::min(count + 1, kernel::kMaxSolidMinima);
      std::copy_backward(all.begin() + place, all.begin() + count - 1, all.begin() + count);
      all[place] = candidate;
    }
  };

  // The likely nearest first, so that those in the same direction need no closer look.
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
               (found.count < kernel::kMaxSolidMinima || least < found.all[found.count - 1].distance) &&
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

  void minima(double reach, kernel::SolidMinima& minima) const {
    Nearest best{reach};
    Collected found;
    forEachSeen(reach, [&](const SeenCells& cells) { collect(cells, reach, best, found); });
    if (best.found) found.add(a, best);  // counts also where the surface has no normal that points to p
    for (int i = 0; i < found.count; ++i) minima.all[i] = answer(found.all[i], 1.0);
    minima.count = found.count;
  }
};

bool isInside(const Solid& solid, const Vec3& p) noexcept { return SolidQuery(solid, p, p).isInside(); }

SolidPoint signedDistance(const Solid& solid, const Vec3& p, double limit) noexcept {
  if (!p.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const SolidQuery query(solid, p, p);
  return query.answer(query.nearest(limit / solid.cell()), query.isInside() ? -1.0 : 1.0);
}

SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit) noexcept {
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) return SolidPoint();
  const SolidQuery query(solid, segment.a, segment.b);
  return query.answer(query.nearest(limit / solid.cell()), 1.0);
}

void kernel::findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept {
  minima.count = 0;
  if (p.allFinite() && reach >= 0.0) SolidQuery(solid, p, p).minima(reach / solid.cell(), minima);
}

}  // namespace enamel
