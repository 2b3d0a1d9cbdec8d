#include "part_contacts.hpp"

#include <Eigen/Geometry>
#include <array>
#include <tuple>
#include <utility>

namespace enamel::kernel {
namespace {

constexpr double kSameDirection = 0.9659258262890683;  // cos 15 deg
constexpr double kClearlyNearer = 1e-9;                // m
constexpr double kSolidNear = 2e-4;                    // m, of a solid's gaps: at larger gaps one contact is enough
constexpr double kSolidError = 0.01;                   // cells, of the distance of a solid, with margin
constexpr double kClear = 1e-6;                        // of the size: larger offsets from the surface give the normal
constexpr double kSurely = 1e-12;                      // of the size: larger distances are not rounding errors
constexpr double kNearly = 1e-6;                       // of the reach: larger than rounding errors
constexpr double kLookAhead = 2.0;                     // times the reach of a part: search limit of its clearance
constexpr double kRounded = 1e-12;                     // of the reach

}  // namespace

template <typename Found>
void Collector::add(const Vec3& asked, const Found& found, double radius) {
  Vec3 centre = asked;
  double gap = found.distance - radius;
  if (actual != nullptr) {
    const Vec3 span = from->b - from->a;
    const double squared = span.squaredNorm(), t = squared > 0.0 ? (asked - from->a).dot(span) / squared : 0.0;
    centre = actual->a + t * (actual->b - actual->a);
    gap += found.normal.dot(centre - asked);
  }
  if (!(gap <= margin)) return;
  ContactSnapshot& all = *contacts;
  int place = all.count;
  while (place > 0 && gap < all.contacts[place - 1].gap) --place;
  if (all.count == kMaxContacts) ++all.omitted;
  if (place == kMaxContacts) return;
  all.count = std::min(all.count + 1, kMaxContacts);
  for (int i = all.count - 1; i > place; --i) all.contacts[i] = all.contacts[i - 1];
  Contact& contact = all.contacts[place];
  const Pose& pose = pair.obstacle->pose;
  contact.normal = pose.rotation * found.normal;
  contact.point = pose.rotation * centre + pose.position - (radius - pad) * contact.normal;
  contact.gap = gap;
  complete(pair, found, contact);
}

namespace {

// Contacts of one part with a mesh.
//
// If the surface is closed, or only the path of the tool determines the side, the side cannot change before the surface
// is met. An axis that starts outside and keeps away from every triangle lies outside. It still does after a move
// shorter than its clearance. Most parts are decided by this in most ticks. The same holds for an end that was outside,
// if no triangle is within the distance that it moved. Geometry out of reach is then irrelevant.
class PartOnMesh {
 public:
  PartOnMesh(const MeshModel& mesh, const Segment& axis, double radius, PartCache* cache, Collector& out)
      : mesh_(mesh),
        data_(Inside::of(mesh)),
        axis_(axis),
        radius_(radius),
        cache_(cache),
        out_(out),
        reach_(out.reachOf(radius)),
        isSphere_(axis.a == axis.b),
        staysOutside_(data_.closed || out.isOutside),
        b_(out.next) {}

  void addContacts() {
    recall();
    if (clear_ > reach_) return;
    const bool wasOutside = clear_ > 0.0 && !isSphere_;  // query the axis first: the ends may not be needed
    chooseA();
    if (!wasOutside) findEnds();
    findClearance(wasOutside);
    if (wasOutside && !isOutOfReach_) findEnds();
    remember();
    if (isOutOfReach_) return;
    addSphere(*a_);
    if (isSphere_) return;
    addSphere(*b_);
    addBetween();
  }

 private:
  double justBeyond() const { return reach_ * (1.0 + kRounded); }
  // Limit that is large enough to rank a place between the ends correctly.
  double beyond(double radius) const { return out_.reachOf(radius) * (1.0 + kRounded) + 2.0 * kClearlyNearer; }

  // Reuse the result of an earlier tick.
  void recall() {
    if (cache_ == nullptr || cache_->revision != data_.view.revision) return;
    const double moveOfA = (axis_.a - cache_->axis.a).norm(), moveOfB = (axis_.b - cache_->axis.b).norm();
    clear_ = cache_->clear - std::max(moveOfA, moveOfB);
    isNearA_ =
        isSphere_ ? cache_->clear > 0.0 && cache_->clear + moveOfA < reach_ : cache_->isAheadA && moveOfA < reach_;
    isNearB_ = cache_->isAheadB && moveOfB < reach_;
    hint_ = cache_->nearest;
  }

  // Use the end of the last part if this one begins there and it is sufficiently known.
  void chooseA() {
    limitA_ = isNearA_ ? beyond(radius_) : isSphere_ && clear_ > 0.0 ? kLookAhead * reach_ : kNoLimit;
    const End& last = *out_.last;
    const bool isKnown = axis_.a == last.point && (last.nearest.triangle >= 0 || last.limit >= limitA_);
    a_ = isKnown ? out_.last : &own_;
  }

  void findEnds() {
    if (a_ == &own_) findEnd(axis_.a, isNearA_, limitA_, pointOf(cache_, 0), own_);
    if (isSphere_) return;
    findEnd(axis_.b, isNearB_, isNearB_ ? beyond(std::max(radius_, out_.nextRadius)) : kNoLimit, pointOf(cache_, 1),
            *b_);
    std::swap(out_.last, out_.next);
  }

  // If the surface is likely to be in reach, take the nearest point from the minima, which are needed anyway.
  void findEnd(const Vec3& p, bool isNear, double limit, Cache* cache, End& end) const {
    end.point = p;
    end.limit = limit;
    if (isNear) {
      end.nearest = signedSurfacePoint(data_, p, findMinima(data_, p, limit, end.minima), cache, out_.isOutside);
      end.reach = limit;
    } else {
      end.nearest = signedDistance(data_, p, cache, limit, out_.isOutside);
      end.reach = -1.0;
    }
  }

  void findClearance(bool wasOutside) {
    if (isSphere_) {
      clear_ = std::min(a_->nearest.distance, a_->limit);
    } else if (wasOutside || (a_->isAhead() && b_->isAhead())) {
      if (hint_ < 0 && !wasOutside) hint_ = (a_->nearest.distance < b_->nearest.distance ? a_ : b_)->nearest.triangle;
      between_ = closestToSegment(mesh_, axis_, justBeyond(), hint_, kLookAhead * reach_);
      clear_ = between_.distance;
    } else {
      clear_ = -1.0;
    }
    isOutside_ = staysOutside_ && clear_ > kSurely * data_.size;
    isOutOfReach_ = isOutside_ && clear_ > justBeyond();
  }

  void remember() const {
    if (cache_ == nullptr) return;
    cache_->revision = data_.view.revision;
    cache_->axis = axis_;
    cache_->clear = isOutside_ ? clear_ * (1.0 - 1e-9) : -1.0;
    cache_->isAheadA = staysOutside_ && (isOutOfReach_ || a_->isAhead());
    cache_->isAheadB = staysOutside_ && !isSphere_ && (isOutOfReach_ || b_->isAhead());
    cache_->nearest = between_.triangle;
  }

  // Of the minima, nearest first, one for each direction counts.
  void addSphere(End& end) const {
    const SurfacePoint& nearest = end.nearest;
    if (nearest.triangle < 0 || nearest.distance > radius_ + out_.margin) return;
    if (nearest.distance <= 1e-9 * reach_) {  // on or behind the surface: one way out
      out_.add(end.point, nearest, radius_);
      return;
    }
    if (end.reach < reach_) {
      end.reach = justBeyond();
      findMinima(data_, end.point, end.reach, end.minima);
    }
    const Minima& minima = end.minima;
    std::array<const Minimum*, kMaxContacts> taken;
    std::size_t count = 0;
    for (int i = 0; i < minima.count && count < taken.size(); ++i) {
      const Minimum& candidate = minima.all[i];
      if (candidate.distance > reach_) break;
      const bool isNew = std::none_of(taken.begin(), taken.begin() + count, [&](const Minimum* known) {
        return known->normal.dot(candidate.normal) > kSameDirection;
      });
      if (!isNew) continue;
      taken[count++] = &candidate;
      out_.add(end.point, candidate, radius_);
    }
    if (count == 0) out_.add(end.point, nearest, radius_);
  }

  // If an end lies behind the surface, no place between the ends is nearer to the outside than both.
  void addBetween() const {
    const double ends =
        std::min({justBeyond(), a_->nearest.distance - kClearlyNearer, b_->nearest.distance - kClearlyNearer});
    if (!(ends > 0.0)) return;
    if (between_.triangle < 0 || between_.distance > ends || !(between_.parameter > 0.0 && between_.parameter < 1.0))
      return;
    End middle;
    middle.point = axis_.a + between_.parameter * (axis_.b - axis_.a);
    SurfacePoint& there = middle.nearest;
    if (isOutside_ && between_.distance > kClear * data_.size) {
      there.triangle = between_.triangle;
      there.feature = between_.feature;
      there.featureIndex = between_.featureIndex;
      there.point = between_.point;
      there.distance = between_.distance;
      there.normal = (middle.point - between_.point).normalized();
    } else {
      const double found = (middle.point - between_.point).norm() + kNearly * reach_;
      there = signedDistance(data_, middle.point, pointOf(cache_, 2), std::min(found, justBeyond()), out_.isOutside);
    }
    if (there.distance < ends) addSphere(middle);
  }

  const MeshModel& mesh_;
  const MeshData& data_;
  const Segment& axis_;
  const double radius_;
  PartCache* const cache_;
  Collector& out_;
  const double reach_;
  const bool isSphere_;
  const bool staysOutside_;                 // the side changes only at the surface
  bool isNearA_ = false, isNearB_ = false;  // surface likely in reach; otherwise the end is outside
  double clear_ = -1.0;                     // lower bound of the distance of the axis from the mesh, outside
  int hint_ = -1;                           // triangle that is likely to be nearest to the axis
  double limitA_ = kNoLimit;
  SegmentPoint between_;
  bool isOutside_ = false, isOutOfReach_ = false;
  End* a_ = nullptr;
  End* b_;
  End own_;
};

void addPart(const MeshModel& mesh, const Segment& axis, double radius, PartCache* cache, Collector& out) {
  PartOnMesh(mesh, axis, radius, cache, out).addContacts();
}

// The minima at a place; the first ones are those within a shorter reach. Parts often share an end.
const SolidMinima& minimaAt(const Solid& solid, const Vec3& p, double reach, std::optional<SolidEnd>& end) {
  if (!end || end->point != p || reach > end->reach) {
    if (!end) end.emplace();
    findMinima(solid, p, reach, end->minima);
    end->point = p;
    end->reach = reach;
  }
  return end->minima;
}

// Lower bound of the distance of a point outside, by what is known from an earlier tick.
double clearanceOf(const Solid& solid, const Vec3& p, const SolidNear* known) {
  if (known == nullptr || known->restorations != solid.restorations()) return -1.0;
  return known->clear - (p - known->point).norm() - kSolidError * solid.cell();
}

// A place between the ends counts only if it is nearer than both, as for a mesh. The search along the axis spares those
// at ends that it shows to be too far away, or finds itself.
void addPart(const Solid& solid, const Segment& axis, double radius, PartCache*, Collector& out) {
  const double reach = out.reachOf(radius);
  SolidPoint between;
  const auto addSphere = [&](const Vec3& p, bool isBehind, double parameter) {
    const double near = std::min(reach, radius + kSolidNear);
    SolidNear* const known = parameter == 0.0 ? out.near : nullptr;
    const auto remember = [&](double distance) {
      if (known != nullptr)
        std::tie(known->point, known->clear, known->restorations) = std::tuple(p, distance, solid.restorations());
      return distance;
    };
    if (!isBehind && !(between.found && between.distance > radius + kSolidNear) &&
        !(clearanceOf(solid, p, known) > near)) {
      const SolidMinima& minima = minimaAt(solid, p, near, *out.solid);
      for (int i = 0; i < minima.count && minima.all[i].distance <= near; ++i) out.add(p, minima.all[i], radius);
      if (minima.count > 0 && minima.all[0].distance <= near) return remember(minima.all[0].distance);
    }
    const bool isKnown = between.found && between.parameter == parameter;
    const SolidPoint nearest =
        isKnown ? between
                : signedDistance(solid, p, isBehind ? kNoLimit : reach, known == nullptr ? nullptr : &known->cache);
    if (nearest.found) out.add(p, nearest, radius);
    remember(nearest.found ? nearest.distance : reach);
    return nearest.distance;
  };
  const bool isSphere = axis.a == axis.b, isBehindA = isInside(solid, axis.a);
  const bool isBehindB = isSphere ? isBehindA : isInside(solid, axis.b);
  if (!isSphere && !isBehindA && !isBehindB) {
    between = closestToSegment(solid, axis, reach);
    if (!between.found) return;
  }
  const double atA = addSphere(axis.a, isBehindA, 0.0);
  if (isSphere) return;
  const double atB = addSphere(axis.b, isBehindB, 1.0);
  if (between.found && between.parameter > 0.0 && between.parameter < 1.0 &&
      between.distance < std::min(atA, atB) - kClearlyNearer)
    addSphere(axis.a + between.parameter * (axis.b - axis.a), false, between.parameter);
}

template <typename Analytic>
double addSphere(const Analytic& shape, const Vec3& centre, double radius, Collector& out) {
  const ShapePoint nearest = signedDistance(shape, centre);
  out.add(centre, nearest, radius);
  return nearest.distance;
}

template <typename Analytic>
void addPart(const Analytic& shape, const Segment& axis, double radius, PartCache*, Collector& out) {
  const double atA = addSphere(shape, axis.a, radius, out);
  if (axis.a == axis.b) return;
  const double atB = addSphere(shape, axis.b, radius, out);
  // Distances change at most by the path length, so between the ends they are at least (a + b - length) / 2.
  if (atA + atB - (axis.b - axis.a).norm() > 2.0 * out.reachOf(radius)) return;
  const double t = nearestOnAxis(shape, axis);
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec3 middle = axis.a + t * (axis.b - axis.a);
  const ShapePoint between = signedDistance(shape, middle);
  if (between.distance < std::min(atA, atB) - kClearlyNearer) out.add(middle, between, radius);
}

SurfacePoint nearestOf(const MeshModel& mesh, const Vec3& p, Cache* cache, bool isOutside) {
  return signedDistance(Inside::of(mesh), p, cache, kNoLimit, isOutside);
}

template <typename Analytic>
ShapePoint nearestOf(const Analytic& shape, const Vec3& p, Cache*, bool) {
  return signedDistance(shape, p);
}

double nearestOnAxis(const MeshModel& mesh, const Segment& axis, double reach) {
  const SegmentPoint found = closestToSegment(mesh, axis, reach);
  return found.triangle < 0 ? -1.0 : found.parameter;
}

template <typename Analytic>
double nearestOnAxis(const Analytic& shape, const Segment& axis, double) {
  return kernel::nearestOnAxis(shape, axis);
}

// Adds the nearest place of a part, under the rules of addPart().
template <typename ShapeType>
void addNearest(const ShapeType& shape, const Segment& axis, double radius, PartCache* cache, Collector& out) {
  const auto atA = nearestOf(shape, axis.a, pointOf(cache, 0), out.isOutside);
  out.add(axis.a, atA, radius);
  if (axis.a == axis.b) return;
  const auto atB = nearestOf(shape, axis.b, pointOf(cache, 1), out.isOutside);
  out.add(axis.b, atB, radius);
  // Only a place nearer than both ends counts, and distances change at most by the path length.
  const double ends = std::min(atA.distance, atB.distance);
  if (std::abs(atA.distance - atB.distance) >= (axis.b - axis.a).norm()) return;
  const double t = nearestOnAxis(shape, axis, std::max(ends, 0.0));
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec3 middle = axis.a + t * (axis.b - axis.a);
  const auto between = nearestOf(shape, middle, pointOf(cache, 2), out.isOutside);
  if (between.distance < ends - kClearlyNearer) out.add(middle, between, radius);
}

void addNearest(const Solid& solid, const Segment& axis, double radius, PartCache*, Collector& out) {
  if (isInside(solid, axis.a) || isInside(solid, axis.b)) {
    out.add(axis.a, signedDistance(solid, axis.a), radius);
    if (axis.a != axis.b) out.add(axis.b, signedDistance(solid, axis.b), radius);
    return;
  }
  const ContactSnapshot& known = *out.contacts;
  const double limit = known.count > 0 ? radius + std::max(known.contacts[0].gap, 0.0) : kNoLimit;
  const SolidPoint found = closestToSegment(solid, axis, limit);
  if (!found.found) return;
  const Vec3 place = axis.a + found.parameter * (axis.b - axis.a);
  if (axis.a == axis.b || !isInside(solid, place))
    out.add(place, found, radius);
  else
    out.add(place, signedDistance(solid, place), radius);
}

}  // namespace

void addPart(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache, Collector& out) noexcept {
  onShape(obstacle, [&](const auto& shape) { addPart(shape, axis, radius, cache, out); });
}

void addNearest(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache,
                Collector& out) noexcept {
  onShape(obstacle, [&](const auto& shape) { addNearest(shape, axis, radius, cache, out); });
}

}  // namespace enamel::kernel
