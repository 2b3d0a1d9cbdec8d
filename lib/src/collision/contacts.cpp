#include "enamel/collision/contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "enamel/core/error.hpp"
#include "minima.hpp"
#include "solid_query.hpp"
#include "tool_parts.hpp"

namespace enamel {
namespace {

using namespace kernel;

constexpr double kSameDirection = 0.9659258262890683;  // cos 15 deg
constexpr double kSameContact = 0.7071067811865476;    // cos 45 deg
constexpr double kClearlyNearer = 1e-9;                // m
constexpr double kSolidNear = 2e-4;                    // m, of a solid's gaps: beyond, one place is enough
constexpr double kClear = 1e-6;     // of the size: where the offset from the surface gives the normal
constexpr double kSurely = 1e-12;   // of the size: a distance that is more than rounding
constexpr double kNearly = 1e-6;    // of the reach: more than what is rounded
constexpr double kLookAhead = 2.0;  // times a part's reach: how far its clearance is looked for
constexpr double kRounded = 1e-12;  // of the reach

// A place on an axis, an end mostly, and what is known of it. The next part often begins where the last one ended.
struct End {
  Vec3 point = Vec3::Zero();
  double limit = -1.0;   // as far as the nearest point was looked for
  SurfacePoint nearest;  // signed
  double reach = -1.0;   // as far as the minima of the distance were looked for
  Minima minima;

  bool isAhead() const { return nearest.distance > 0.0; }
};

// Contacts of one tick while they are collected; the deepest first.
struct Collector {
  ContactSnapshot* contacts;
  double margin;
  Pair pair;
  End* last;                                         // of the part before
  End* next;                                         // to become that
  double nextRadius;                                 // of the part that begins where this one ends, or 0
  bool isOutside = false;                            // the axis is known to be outside
  double pad = 0.0;                                  // of a sheet: half its thickness, added to all radii
  const Segment *from = nullptr, *actual = nullptr;  // the axis that is asked stands for another one

  double reachOf(double radius) const { return radius + std::max(margin, 0.0); }

  // `centre` and what is found there in the obstacle's frame.
  template <typename Found>
  void add(const Vec3& asked, const Found& found, double radius) {
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
};

// Contacts of one part with a mesh.
//
// Outside of a closed surface, or where only the way of the tool tells the side, it cannot change before the surface is
// met: an axis that starts outside and keeps away from every triangle lies outside, and it still does after a move
// shorter than its clearance. Most ticks of most parts end there. So does an end that was outside, if no triangle is as
// near as it came from: what is out of reach then need not be known.
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
    const bool wasOutside = clear_ > 0.0 && !isSphere_;  // the axis is then asked first: the ends may not be needed
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
  // What is hidden beyond that cannot make a place between the ends look less near.
  double beyond(double radius) const { return out_.reachOf(radius) * (1.0 + kRounded) + 2.0 * kClearlyNearer; }

  // What an earlier tick tells of this one.
  void recall() {
    if (cache_ == nullptr || cache_->revision != data_.view.revision) return;
    const double moveOfA = (axis_.a - cache_->axis.a).norm(), moveOfB = (axis_.b - cache_->axis.b).norm();
    clear_ = cache_->clear - std::max(moveOfA, moveOfB);
    isNearA_ =
        isSphere_ ? cache_->clear > 0.0 && cache_->clear + moveOfA < reach_ : cache_->isAheadA && moveOfA < reach_;
    isNearB_ = cache_->isAheadB && moveOfB < reach_;
    hint_ = cache_->nearest;
  }

  // The end of the last part, if this one begins there and enough is known of it.
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

  // Where the surface is likely to be in reach, the nearest point is one of the minima, which are asked for anyway.
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

  // Of the minima, from the nearest on, one for each direction counts.
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

  // Where an end lies behind the surface, no place between is nearer to the outside than both.
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
      there.normal = (middle.point - between_.point) / between_.distance;
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
  const bool staysOutside_;                 // off the surface
  bool isNearA_ = false, isNearB_ = false;  // or hidden, and outside
  double clear_ = -1.0;                     // the axis keeps at least so far away from the mesh, outside
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

// Between the ends only what is nearer than both counts, as for a mesh.
void addPart(const Solid& solid, const Segment& axis, double radius, PartCache*, Collector& out) {
  const double reach = out.reachOf(radius);
  const auto addSphere = [&](const Vec3& p, bool isBehind) {
    SolidMinima minima;
    if (!isBehind) findMinima(solid, p, std::min(reach, radius + kSolidNear), minima);
    for (int i = 0; i < minima.count; ++i) out.add(p, minima.all[i], radius);
    if (minima.count > 0) return minima.all[0].distance;
    const SolidPoint nearest = signedDistance(solid, p, isBehind ? kNoLimit : reach);
    if (nearest.found) out.add(p, nearest, radius);
    return nearest.distance;
  };
  const bool isSphere = axis.a == axis.b, isBehindA = isInside(solid, axis.a);
  const bool isBehindB = isSphere ? isBehindA : isInside(solid, axis.b);
  SolidPoint between;
  if (!isSphere && !isBehindA && !isBehindB) {
    between = closestToSegment(solid, axis, reach);
    if (!between.found) return;
  }
  const double atA = addSphere(axis.a, isBehindA);
  if (isSphere) return;
  const double atB = addSphere(axis.b, isBehindB);
  if (between.found && between.parameter > 0.0 && between.parameter < 1.0 &&
      between.distance < std::min(atA, atB) - kClearlyNearer)
    addSphere(axis.a + between.parameter * (axis.b - axis.a), false);
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
  // Distances change by no more than the path: between the ends they are at least (a + b - length) / 2.
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
  // Only what is nearer than both ends counts, and distances change by no more than the path.
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

void addPart(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache, Collector& out) {
  onShape(obstacle, [&](const auto& shape) { addPart(shape, axis, radius, cache, out); });
}

void addNearest(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache, Collector& out) {
  onShape(obstacle, [&](const auto& shape) { addNearest(shape, axis, radius, cache, out); });
}

// Calls visit(obstacle, axis, radius, cache, collector) for every part and obstacle; without contacts where it cannot.
template <typename Visit>
Status forEachPart(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                   ContactSnapshot& contacts, const Visit& visit) {
  contacts.count = 0;
  if (!isFinite(pose) || !std::isfinite(margin)) return Status::notFinite;
  if (const Status status = checkTool(tool); status != Status::ok) return status;
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  End ends[2];
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (!isFinite(obstacles[i].pose)) {
      contacts.count = 0;
      return Status::notFinite;
    }
    ends[0].limit = -1.0;
    ends[0].nearest = SurfacePoint();
    Collector out{&contacts, margin, {&obstacles[i], static_cast<int>(i), 0}, &ends[0], &ends[1], 0.0};
    out.pad = 0.5 * obstacles[i].thickness;
    out.isOutside = out.pad > 0.0;
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      out.pair.part = k;
      out.nextRadius = k + 1 < tool.count && tool.parts[k + 1].a == part.b ? tool.parts[k + 1].radius + out.pad : 0.0;
      const Segment axis = axisOf(part, pose, obstacles[i]);
      PartCache* known = PartCache::of(cache, i, k);
      visit(obstacles[i], axis, part.radius + out.pad, known, out);
    }
  }
  return Status::ok;
}

// A contact of the last tick goes on where one of the same obstacle and part has about its normal, and no other one
// more so. `last` holds contacts in the frames of their obstacles.
void nameContacts(const Scene& scene, ContactSnapshot& last, std::uint32_t& lastKey, ContactSnapshot& contacts) {
  ContactSnapshot now = contacts;
  for (int k = 0; k < now.count; ++k) {
    Contact& contact = now.contacts[k];
    const Pose& pose = scene.obstacles()[static_cast<std::size_t>(contact.obstacle)].pose;
    contact.normal = pose.rotation.transpose() * contact.normal;
    contact.point = pose.rotation.transpose() * (contact.point - pose.position);
    Contact* best = nullptr;
    double least = kSameContact;
    for (int i = 0; i < last.count; ++i) {
      Contact& known = last.contacts[i];
      if (known.key == 0 || known.obstacle != contact.obstacle || known.part != contact.part ||
          (known.point - contact.point).norm() > kLargestMove)
        continue;
      const double alike = known.normal.dot(contact.normal);
      if (!(alike > least)) continue;
      least = alike;
      best = &known;
    }
    if (best == nullptr) {
      if (++lastKey == 0) lastKey = 1;
      contact.key = lastKey;
    } else {
      contact.key = std::exchange(best->key, 0u);
    }
    contacts.contacts[k].key = contact.key;
  }
  last = now;
}

}  // namespace

Status checkTool(const Tool& tool) noexcept {
  if (tool.count < 0 || tool.count > kMaxToolParts) return Status::outOfRange;
  for (int k = 0; k < tool.count; ++k) {
    const ToolPart& part = tool.parts[k];
    if (!part.a.allFinite() || !part.b.allFinite() || !std::isfinite(part.radius)) return Status::notFinite;
    if (!(std::max(part.a.cwiseAbs().maxCoeff(), part.b.cwiseAbs().maxCoeff()) <= kLargestTool && part.radius >= 0.0 &&
          part.radius <= kLargestTool))
      return Status::outOfRange;
  }
  return Status::ok;
}

ToolCache::ToolCache() = default;
ToolCache::ToolCache(const ToolCache& other) = default;
ToolCache::ToolCache(ToolCache&& other) noexcept = default;
ToolCache& ToolCache::operator=(const ToolCache& other) = default;
ToolCache& ToolCache::operator=(ToolCache&& other) noexcept = default;
ToolCache::~ToolCache() = default;

ToolCache makeToolCache(const Scene& scene, const Tool& tool) {
  if (const Status status = checkTool(tool); status != Status::ok)
    throw Error("the tool is " + std::string(status == Status::notFinite ? "not finite" : "out of range") +
                ": it must have 0 to " + std::to_string(kMaxToolParts) +
                " parts, their ends within 1 m of the TCP along every axis, their radius in 0 to 1 m");
  ToolCache cache;
  int parts = 0;
  for (const Obstacle& obstacle : scene.obstacles()) {
    const bool isMesh = std::holds_alternative<std::shared_ptr<const MeshModel>>(obstacle.shape);
    cache.first_.push_back(isMesh ? parts : -1);
    if (isMesh) parts += tool.count;
  }
  cache.parts_.resize(static_cast<std::size_t>(parts));
  return cache;
}

Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept {
  const auto visit = [](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                        Collector& out) { addPart(obstacle, axis, radius, known, out); };
  return forEachPart(scene, tool, pose, margin, cache, contacts, visit);
}

ToolTrack::ToolTrack() = default;
ToolTrack::ToolTrack(const ToolTrack& other) = default;
ToolTrack::ToolTrack(ToolTrack&& other) noexcept = default;
ToolTrack& ToolTrack::operator=(const ToolTrack& other) = default;
ToolTrack& ToolTrack::operator=(ToolTrack&& other) noexcept = default;
ToolTrack::~ToolTrack() = default;

ToolTrack makeToolTrack(const Scene& scene, const Tool& tool) {
  ToolTrack track;
  track.cache_ = makeToolCache(scene, tool);
  track.parts_.resize(scene.obstacles().size() * static_cast<std::size_t>(tool.count));
  return track;
}

namespace {

constexpr std::size_t kPartState = 8;     // its axis, its clearance, whether it is known
constexpr std::size_t kContactState = 9;  // point, normal, obstacle, part, key
constexpr double kLargestPlace = 1e3;     // m

std::uint64_t revisionOf(const Obstacle& obstacle) noexcept {
  if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) return (*solid)->growths();
  const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape);
  return mesh == nullptr ? 1 : Inside::of(**mesh).view.revision;
}

bool isWhole(double value, double most) noexcept { return value >= 0.0 && value <= most && value == std::floor(value); }

}  // namespace

std::size_t ToolTrack::stateSize() const noexcept {
  return kPartState * parts_.size() + kContactState * kMaxContacts + 2;
}

void ToolTrack::saveState(const Scene& scene, double* state) const noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  for (std::size_t i = 0; i < parts_.size(); ++i, state += kPartState) {
    const kernel::PartTrack& part = parts_[i];
    // A part of a mesh that was changed begins anew.
    const bool isKnown = part.isKnown && part.revision == revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
    std::copy_n(part.axis.a.data(), 3, state);
    std::copy_n(part.axis.b.data(), 3, state + 3);
    state[6] = part.clear;
    state[7] = isKnown ? 1.0 : 0.0;
  }
  for (const Contact& c : last_.contacts) {
    const bool isKnown = &c < last_.contacts.data() + last_.count;
    const Vec3 point = isKnown ? c.point : Vec3(Vec3::Zero()), normal = isKnown ? c.normal : Vec3(Vec3::Zero());
    std::copy_n(point.data(), 3, state);
    std::copy_n(normal.data(), 3, state + 3);
    state[6] = isKnown ? c.obstacle : 0;
    state[7] = isKnown ? c.part : 0;
    state[8] = isKnown ? c.key : 0;
    state += kContactState;
  }
  state[0] = last_.count;
  state[1] = lastKey_;
}

void ToolTrack::loadState(const Scene& scene, const double* state) noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  bool isSound = true;
  for (std::size_t i = 0; i < stateSize(); ++i) isSound = isSound && std::isfinite(state[i]);
  for (kernel::PartTrack& part : parts_) {
    const std::size_t i = static_cast<std::size_t>(&part - parts_.data());
    const auto ends = Eigen::Map<const Vec6>(state);
    part.isKnown = isSound && state[7] == 1.0 && ends.cwiseAbs().maxCoeff() <= kLargestPlace;
    if (isSound) {
      part.axis = {ends.head<3>(), ends.tail<3>()};
      part.clear = part.isKnown ? state[6] : -1.0;
    }
    part.revision = revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
    state += kPartState;
  }
  const double* counts = state + kContactState * kMaxContacts;
  isSound = isSound && isWhole(counts[0], kMaxContacts) && isWhole(counts[1], UINT32_MAX);
  last_.count = isSound ? static_cast<int>(counts[0]) : 0;
  lastKey_ = isSound ? static_cast<std::uint32_t>(counts[1]) : 0;
  for (int k = 0; k < last_.count; ++k, state += kContactState) {
    Contact& c = last_.contacts[k];
    c.point = Eigen::Map<const Vec3>(state);
    c.normal = Eigen::Map<const Vec3>(state + 3);
    const bool isContact = isWhole(state[6], static_cast<double>(obstacles)) && isWhole(state[7], kMaxToolParts) &&
                           isWhole(state[8], UINT32_MAX);
    c.obstacle = isContact ? static_cast<int>(state[6]) : 0;
    c.part = isContact ? static_cast<int>(state[7]) : 0;
    c.key = isContact ? static_cast<std::uint32_t>(state[8]) : 0;  // 0: none goes on from it
  }
}

void ToolTrack::reset(const Scene& scene) noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    parts_[i].isKnown = false;
    parts_[i].revision = revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
  }
  last_.count = 0;
  lastKey_ = 0;
}

Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                      ContactSnapshot& contacts) noexcept {
  const auto visit = [&](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                         Collector& out) {
    const int pair = out.pair.number * tool.count + out.pair.part;
    const auto i = static_cast<std::size_t>(pair);
    if (i >= track.parts_.size()) {
      addPart(obstacle, axis, radius, known, out);
      return;
    }
    PartTrack& part = track.parts_[i];
    const PartTrack::State state = part.follow(obstacle, axis, known);
    out.isOutside = out.pad > 0.0 || state != PartTrack::State::unknown;
    const bool isHeld = state == PartTrack::State::held;
    out.from = isHeld ? &part.axis : nullptr;
    out.actual = isHeld ? &axis : nullptr;
    addPart(obstacle, isHeld ? part.axis : axis, radius, known, out);
  };
  const Status status = forEachPart(scene, tool, pose, margin, &track.cache_, contacts, visit);
  if (status == Status::ok) nameContacts(scene, track.last_, track.lastKey_, contacts);
  return status;
}

Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept {
  ContactSnapshot contacts;
  const auto visit = [](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                        Collector& out) { addNearest(obstacle, axis, radius, known, out); };
  if (forEachPart(scene, tool, pose, kNoLimit, cache, contacts, visit) != Status::ok || contacts.count == 0) {
    Contact none;
    none.gap = kNoLimit;
    return none;
  }
  return contacts.contacts[0];
}

}  // namespace enamel
