#include "enamel/collision/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "enamel/core/error.hpp"
#include "mesh_data.hpp"

namespace enamel {
namespace {

using namespace kernel;

#include "exact.inl"

constexpr double kSameDirection = 0.9659258262890683;  // cos 15 deg
constexpr int kMostFanSteps = 64;
constexpr int kAxisSteps = 64;           // halvings of the axis of a capsule: below 1e-18 of its length
constexpr double kClearlyNearer = 1e-9;  // m
constexpr double kClear = 1e-6;          // of the size: where the way to the surface gives the normal
constexpr double kSurely = 1e-12;        // of the size: a distance that is more than rounding
constexpr double kNearly = 1e-6;         // of the reach: more than what is rounded
constexpr double kLookAhead = 2.0;       // times a part's reach: how far its clearance is looked for

using MeshPointer = std::shared_ptr<const MeshModel>;

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

// A local minimum of the distance from a point.
struct Minimum {
  Vec3 point, normal;
  double distance;
  int triangle;
};

// The nearest minima, whatever the order in which they are found: by distance, then by triangle.
struct Minima {
  static constexpr int kMost = 64;
  std::array<Minimum, kMost> all;
  int count = 0;
};

void keepMinimum(const Minimum& minimum, Minima& minima) {
  int place = minima.count;
  while (place > 0 && minimum.distance < minima.all[place - 1].distance) --place;
  int first = place;
  for (; first > 0 && minimum.distance == minima.all[first - 1].distance; --first) {
    const Minimum& known = minima.all[first - 1];
    if (known.point != minimum.point) continue;  // else a corner or edge, seen from another triangle
    if (known.triangle <= minimum.triangle) return;
    std::copy(minima.all.begin() + first, minima.all.begin() + minima.count, minima.all.begin() + first - 1);
    --minima.count;
    --place;
  }
  while (place > first && minimum.triangle < minima.all[place - 1].triangle) --place;
  if (place == Minima::kMost) return;
  minima.count = std::min(minima.count + 1, Minima::kMost);
  for (int i = minima.count - 1; i > place; --i) minima.all[i] = minima.all[i - 1];
  minima.all[place] = minimum;
}

// A place on an axis, an end mostly, and what is known of it. The next part often begins where the last one ended.
struct End {
  Vec3 point = Vec3::Zero();
  double limit = -1.0;   // as far as the nearest point was looked for
  SurfacePoint nearest;  // signed
  double reach = -1.0;   // as far as the minima of the distance were looked for
  Minima minima;
};

// The minima about a point, and the nearest point of all.
struct MinimaSearch {
  const MeshData* data;
  Vec3 p;
  Answer found;
  Minima* minima;
};

bool hasNearer(const MinimaSearch& s, const Triangle& triangle, double squared) {
  Candidate c;
  closestOnTriangle(&triangle, s.p.data(), &c);
  return c.squared < squared * (1.0 - 1e-12);
}

// Which corner of a triangle lies at x; -1: none.
int cornerAt(const Triangle& triangle, const double* x) {
  for (int i = 0; i < 3; ++i)
    if (std::equal(x, x + 3, triangle.corner[i])) return i;
  return -1;
}

// A point on an edge or corner is a local minimum if no other triangle there comes nearer.
bool isMinimum(const MinimaSearch& s, const Triangle& triangle, const Candidate& c) {
  if (c.feature == kFace) return true;
  const auto& neighbour = s.data->neighbour;
  const auto triangleOf = [&s](std::int32_t number) -> const Triangle& {
    return s.data->triangles[s.data->slotOf[number]];
  };
  if (c.feature >= kEdge01) {
    const std::int32_t other = neighbour[triangle.index][c.feature - kEdge01];
    return other < 0 || !hasNearer(s, triangleOf(other), c.squared);
  }
  for (const int turn : {2, 0}) {  // round the corner one way, and the other way where a border stops the walk
    std::int32_t at = triangle.index;
    int corner = c.feature;
    for (int step = 0; step < kMostFanSteps && corner >= 0; ++step) {
      at = neighbour[at][(corner + turn) % 3];
      if (at == triangle.index) return true;
      if (at < 0) break;
      const Triangle& next = triangleOf(at);
      if (hasNearer(s, next, c.squared)) return false;
      corner = cornerAt(next, triangle.corner[c.feature]);
    }
  }
  return true;
}

double tryMinimum(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<MinimaSearch*>(context);
  const Triangle* triangles = s.data->triangles.data();
  const Triangle& triangle = triangles[slot];
  Candidate c;
  closestOnTriangle(&triangle, s.p.data(), &c);
  if (!(c.squared <= reach * reach)) return reach;
  Answer& found = s.found;
  if (found.slot < 0 || c.squared < found.nearest.squared ||
      (c.squared == found.nearest.squared && triangle.index < triangles[found.slot].index))
    found = {c, slot};
  if (!(c.squared > 0.0)) return reach;
  Minimum minimum;
  minimum.point = vec(c.point);
  minimum.distance = std::sqrt(c.squared);
  minimum.normal = (s.p - minimum.point) / minimum.distance;
  minimum.triangle = triangle.index;
  if (isMinimum(s, triangle, c)) keepMinimum(minimum, *s.minima);
  return reach;
}

// Answers the nearest point.
Answer findMinima(const MeshModel& mesh, double reach, End& end) {
  const Vec3& p = end.point;
  MinimaSearch s{&mesh.data(), p, {{0.0, {p[0], p[1], p[2]}, kFace, 0.0, 0.0}, -1}, &end.minima};
  end.reach = reach;
  end.minima.count = 0;
  loops().visitMinima(s.data->view, p.data(), reach, &tryMinimum, &s);
  return s.found;
}

// Contacts of one tick while they are collected; the deepest first.
struct Collector {
  ContactSnapshot* contacts;
  const Obstacle* obstacle;
  int number;
  double margin;
  End* last;          // of the part before
  End* next;          // to become that
  double nextRadius;  // of the part that begins where this one ends, or 0

  double reachOf(double radius) const { return radius + std::max(margin, 0.0); }

  // `centre` and `normal` in the obstacle's frame.
  void add(const Vec3& centre, const Vec3& normal, double distance, double radius) {
    const double gap = distance - radius;
    if (!(gap <= margin)) return;
    Contact contact;
    contact.normal = obstacle->pose.rotation * normal;
    contact.point = obstacle->pose.rotation * centre + obstacle->pose.position - radius * contact.normal;
    contact.gap = gap;
    contact.obstacleVelocity =
        obstacle->twist.head<3>() + Vec3(obstacle->twist.tail<3>()).cross(contact.point - obstacle->pose.position);
    contact.obstacle = number;
    contact.material = obstacle->material;
    ContactSnapshot& all = *contacts;
    int place = all.count;
    while (place > 0 && gap < all.contacts[place - 1].gap) --place;
    if (place == kMaxContacts) return;
    all.count = std::min(all.count + 1, kMaxContacts);
    for (int i = all.count - 1; i > place; --i) all.contacts[i] = all.contacts[i - 1];
    all.contacts[place] = contact;
  }
};

// Of the minima, from the nearest on, one for each direction counts.
void addSphere(const MeshModel& mesh, End& end, double radius, Collector& out) {
  const SurfacePoint& nearest = end.nearest;
  if (nearest.triangle < 0 || nearest.distance > radius + out.margin) return;
  const double reach = out.reachOf(radius);
  if (nearest.distance <= 1e-9 * reach) {  // on or behind the surface: one way out
    out.add(end.point, nearest.normal, nearest.distance, radius);
    return;
  }
  if (end.reach < reach) findMinima(mesh, reach * (1.0 + 1e-12), end);
  const Minima& minima = end.minima;
  std::array<const Minimum*, kMaxContacts> taken;
  std::size_t count = 0;
  for (int i = 0; i < minima.count && count < taken.size(); ++i) {
    const Minimum& candidate = minima.all[i];
    if (candidate.distance > reach) break;
    const bool isNew = std::none_of(taken.begin(), taken.begin() + count, [&](const Minimum* known) {
      return known->normal.dot(candidate.normal) > kSameDirection;
    });
    if (!isNew) continue;
    taken[count++] = &candidate;
    out.add(end.point, candidate.normal, candidate.distance, radius);
  }
  if (count == 0) out.add(end.point, nearest.normal, nearest.distance, radius);
}

template <typename Analytic>
double addSphere(const Analytic& shape, const Vec3& centre, double radius, Collector& out) {
  const ShapePoint nearest = signedDistance(shape, centre);
  out.add(centre, nearest.normal, nearest.distance, radius);
  return nearest.distance;
}

// Place on the axis nearest to the mesh; -1 where none is within reach.
double nearestOnAxis(const MeshModel& mesh, const Segment& axis, double reach) {
  const SegmentPoint found = closestToSegment(mesh, axis, reach);
  return found.triangle < 0 ? -1.0 : found.parameter;
}

double nearestOnAxis(const HalfSpace&, const Segment&, double) { return -1.0; }  // an end is nearest

// The signed distance of a convex shape is convex along the axis: halve by its slope, which the normal gives.
template <typename Analytic>
double nearestOnAxis(const Analytic& shape, const Segment& axis, double) {
  const Vec3 way = axis.b - axis.a;
  const auto rises = [&](double t) { return signedDistance(shape, axis.a + t * way).normal.dot(way) > 0.0; };
  if (rises(0.0)) return 0.0;
  if (!rises(1.0)) return 1.0;
  double low = 0.0, high = 1.0;
  for (int step = 0; step < kAxisSteps; ++step) {
    const double middle = 0.5 * (low + high);
    (rises(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

const MeshModel& shapeOf(const MeshPointer& mesh) { return *mesh; }
template <typename Analytic>
const Analytic& shapeOf(const Analytic& shape) {
  return shape;
}

template <typename Analytic>
void addPart(const Analytic& shape, const Segment& axis, double radius, PartCache*, Collector& out) {
  const double atA = addSphere(shape, axis.a, radius, out);
  if (axis.a == axis.b) return;
  const double atB = addSphere(shape, axis.b, radius, out);
  const double reach = out.reachOf(radius);
  // Distances change by no more than the way: between the ends they are at least (a + b - length) / 2.
  if (atA + atB - (axis.b - axis.a).norm() > 2.0 * reach) return;
  const double t = nearestOnAxis(shape, axis, reach);
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec3 middle = axis.a + t * (axis.b - axis.a);
  if (signedDistance(shape, middle).distance < std::min(atA, atB) - kClearlyNearer)
    addSphere(shape, middle, radius, out);
}

bool isAhead(const End& end) { return end.nearest.distance > 0.0; }

int nearerOf(const End& a, const End& b) {
  return a.nearest.distance < b.nearest.distance ? a.nearest.triangle : b.nearest.triangle;
}

// Where the surface is likely to be in reach: the nearest point is one of the minima, which are asked for anyway.
void findEndNearby(const MeshModel& mesh, const Vec3& p, double reach, End& end) {
  end.point = p;
  end.limit = reach;
  end.nearest = signedSurfacePoint(mesh.data(), p, findMinima(mesh, reach, end));
}

void findEnd(const MeshModel& mesh, const Vec3& p, double limit, ProximityCache* cache, End& end) {
  end.point = p;
  end.limit = limit;
  end.nearest = signedDistance(mesh, p, cache, limit);
  end.reach = -1.0;
}

// Outside of a closed surface the side cannot change before the surface is met: an axis that starts outside and keeps
// away from every triangle lies outside, and it still does after a way shorter than its clearance. Most ticks of most
// parts end there. So does an end that was outside, if no triangle is as near as it came from: what is out of reach
// then need not be known.
void addPart(const MeshModel& mesh, const Segment& axis, double radius, PartCache* cache, Collector& out) {
  const auto point = [cache](std::size_t i) { return cache == nullptr ? nullptr : &cache->points[i]; };
  const double reach = out.reachOf(radius), justBeyond = reach * (1.0 + 1e-12);
  // What is hidden beyond that cannot make a place between the ends look less near.
  const auto beyond = [&out](double r) { return out.reachOf(r) * (1.0 + 1e-12) + 2.0 * kClearlyNearer; };
  const bool isSphere = axis.a == axis.b, isClosed = mesh.data().closed;
  bool isNearA = false, isNearB = false;  // or hidden, and outside
  double clear = -1.0;
  int hint = -1;
  if (cache != nullptr && cache->revision == mesh.data().view.revision) {
    const double wayOfA = (axis.a - cache->axis.a).norm(), wayOfB = (axis.b - cache->axis.b).norm();
    clear = cache->clear - std::max(wayOfA, wayOfB);
    isNearA = isSphere ? cache->clear > 0.0 && cache->clear + wayOfA < reach : cache->isAheadA && wayOfA < reach;
    isNearB = cache->isAheadB && wayOfB < reach;
    hint = cache->nearest;
  }
  if (clear > reach) return;
  const bool wasOutside = clear > 0.0 && !isSphere;
  const double limitA = isNearA ? beyond(radius) : isSphere && clear > 0.0 ? kLookAhead * reach : kNoLimit;
  End own;
  End& a =
      axis.a == out.last->point && (out.last->nearest.triangle >= 0 || out.last->limit >= limitA) ? *out.last : own;
  End& b = *out.next;
  const auto findEnds = [&] {
    if (&a == &own) {
      if (isNearA) {
        findEndNearby(mesh, axis.a, limitA, a);
      } else {
        findEnd(mesh, axis.a, limitA, point(0), a);
      }
    }
    if (isSphere) return;
    if (isNearB) {
      findEndNearby(mesh, axis.b, beyond(std::max(radius, out.nextRadius)), b);
    } else {
      findEnd(mesh, axis.b, kNoLimit, point(1), b);
    }
    std::swap(out.last, out.next);
  };
  SegmentPoint between;
  if (!wasOutside) findEnds();
  if (isSphere) {
    clear = std::min(a.nearest.distance, a.limit);
  } else if (wasOutside || (isAhead(a) && isAhead(b))) {
    if (hint < 0 && !wasOutside) hint = nearerOf(a, b);
    between = closestToSegment(mesh, axis, justBeyond, hint, kLookAhead * reach);
    clear = between.distance;
  } else {
    clear = -1.0;
  }
  const bool isOutside = isClosed && clear > kSurely * mesh.data().size, isOutOfReach = isOutside && clear > justBeyond;
  if (wasOutside && !isOutOfReach) findEnds();
  if (cache != nullptr) {
    cache->revision = mesh.data().view.revision;
    cache->axis = axis;
    cache->clear = isOutside ? clear * (1.0 - 1e-9) : -1.0;
    cache->isAheadA = isClosed && (isOutOfReach || isAhead(a));
    cache->isAheadB = isClosed && !isSphere && (isOutOfReach || isAhead(b));
    cache->nearest = between.triangle;
  }
  if (isOutOfReach) return;
  addSphere(mesh, a, radius, out);
  if (isSphere) return;
  addSphere(mesh, b, radius, out);
  // Where an end lies behind the surface, no place between is nearer to the outside than both.
  const double ends = std::min({justBeyond, a.nearest.distance - kClearlyNearer, b.nearest.distance - kClearlyNearer});
  if (!(ends > 0.0)) return;
  if (between.triangle < 0 || between.distance > ends || !(between.parameter > 0.0 && between.parameter < 1.0)) return;
  End middle;
  middle.point = axis.a + between.parameter * (axis.b - axis.a);
  SurfacePoint& there = middle.nearest;
  if (isOutside && between.distance > kClear * mesh.data().size) {
    there.triangle = between.triangle;
    there.point = between.point;
    there.distance = between.distance;
    there.normal = (middle.point - between.point) / between.distance;
  } else {
    const double found = (middle.point - between.point).norm() + kNearly * reach;
    there = signedDistance(mesh, middle.point, point(2), std::min(found, justBeyond));
  }
  if (there.distance < ends) addSphere(mesh, middle, radius, out);
}

SurfacePoint nearestOf(const MeshModel& mesh, const Vec3& p, ProximityCache* cache) {
  return signedDistance(mesh, p, cache);
}

template <typename Analytic>
ShapePoint nearestOf(const Analytic& shape, const Vec3& p, ProximityCache*) {
  return signedDistance(shape, p);
}

// Adds the nearest place of a part, under the rules of addPart().
template <typename ShapeType>
void addNearest(const ShapeType& shape, const Segment& axis, double radius, PartCache* part, Collector& out) {
  const auto cache = [part](std::size_t i) { return part == nullptr ? nullptr : &part->points[i]; };
  const auto atA = nearestOf(shape, axis.a, cache(0));
  out.add(axis.a, atA.normal, atA.distance, radius);
  if (axis.a == axis.b) return;
  const auto atB = nearestOf(shape, axis.b, cache(1));
  out.add(axis.b, atB.normal, atB.distance, radius);
  // Only what is nearer than both ends counts, and distances change by no more than the way.
  const double ends = std::min(atA.distance, atB.distance);
  if (std::abs(atA.distance - atB.distance) >= (axis.b - axis.a).norm()) return;
  const double t = nearestOnAxis(shape, axis, std::max(ends, 0.0));
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec3 middle = axis.a + t * (axis.b - axis.a);
  const auto between = nearestOf(shape, middle, cache(2));
  if (between.distance < ends - kClearlyNearer) out.add(middle, between.normal, between.distance, radius);
}

Vec3 toObstacle(const Obstacle& obstacle, const Vec3& p_W) {
  return obstacle.pose.rotation.transpose() * (p_W - obstacle.pose.position);
}

Segment axisOf(const ToolPart& part, const Pose& pose, const Obstacle& obstacle) {
  return {toObstacle(obstacle, pose.rotation * part.a + pose.position),
          toObstacle(obstacle, pose.rotation * part.b + pose.position)};
}

bool isFinite(const Pose& pose) { return pose.position.allFinite() && pose.rotation.allFinite(); }

PartCache* cacheOf(ToolCache* cache, std::size_t obstacle, int part, int parts) {
  if (cache == nullptr) return nullptr;
  const std::size_t i = obstacle * static_cast<std::size_t>(parts) + static_cast<std::size_t>(part);
  return i < cache->parts.size() ? &cache->parts[i] : nullptr;
}

// Calls visit(shape, axis, radius, cache, collector) for every part and obstacle; false where an obstacle's pose is
// not finite.
template <typename Visit>
bool forEachPart(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                 ContactSnapshot& contacts, const Visit& visit) {
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  End ends[2];
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (!isFinite(obstacles[i].pose)) return false;
    ends[0].limit = -1.0;
    ends[0].nearest = SurfacePoint();
    Collector out{&contacts, &obstacles[i], static_cast<int>(i), margin, &ends[0], &ends[1], 0.0};
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      out.nextRadius = k + 1 < tool.count && tool.parts[k + 1].a == part.b ? tool.parts[k + 1].radius : 0.0;
      const Segment axis = axisOf(part, pose, obstacles[i]);
      PartCache* known = cacheOf(cache, i, k, tool.count);
      std::visit([&](const auto& shape) { visit(shapeOf(shape), axis, part.radius, known, out); }, obstacles[i].shape);
    }
  }
  return true;
}

// Analytic shapes: the signed distance of the sphere's centre is convex in time, so Newton's steps from the left never
// pass its first root. A capsule advances until one of its ends meets the plane that keeps it from the shape.
template <typename Analytic>
SweepHit sweepPart(const Analytic& shape, const Segment& from, const Segment& to, double radius, PartCache*) {
  SweepHit result;
  const Vec3 wayA = to.a - from.a, wayB = to.b - from.b;
  const bool isSphere = from.a == from.b && to.a == to.b;
  const double speed = std::max(wayA.norm(), wayB.norm());
  const double tolerance = 1e-15 * (1.0 + from.a.norm() + radius + speed);
  double time = 0.0;
  for (int step = 0; step < 256; ++step) {
    const Segment now{from.a + time * wayA, from.b + time * wayB};
    double t = isSphere ? 0.0 : nearestOnAxis(shape, now, kNoLimit);
    if (t < 0.0) t = signedDistance(shape, now.a).distance < signedDistance(shape, now.b).distance ? 0.0 : 1.0;
    const Vec3 centre = now.a + t * (now.b - now.a);
    const ShapePoint near = signedDistance(shape, centre);
    const double gap = near.distance - radius;
    if (gap <= tolerance || step == 255) {
      result.hit = true;
      result.time = time;
      result.point = near.point;
      result.normal = near.normal;
      return result;
    }
    const auto waitOf = [&](const Vec3& end, const Vec3& way) {  // until the end meets the plane over the nearest point
      const double closing = -near.normal.dot(way);
      return closing > 0.0 ? std::max(near.normal.dot(end - near.point) - radius, gap) / closing : kNoLimit;
    };
    time += std::min(waitOf(now.a, wayA), waitOf(now.b, wayB));
    if (!(time <= 1.0)) return result;
  }
  return result;
}

SweepHit sweepPart(const MeshModel& mesh, const Segment& from, const Segment& to, double radius, PartCache* cache) {
  if (from.a == from.b && to.a == to.b)
    return sweepSphere(mesh, from.a, to.a, radius, cache == nullptr ? nullptr : cache->points.data());
  return sweepCapsule(mesh, from, to, radius);
}

}  // namespace

int Scene::add(Obstacle obstacle) {
  const std::string name = "obstacle \"" + obstacle.name + "\"";
  if (obstacle.name.empty()) throw Error("an obstacle has no name");
  for (const Obstacle& other : obstacles_)
    if (other.name == obstacle.name) throw Error(name + " stands twice in the scene");
  const Mat3& R = obstacle.pose.rotation;
  if (!isFinite(obstacle.pose) || !obstacle.twist.allFinite()) throw Error(name + ": pose or twist is not finite");
  if ((R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-6 || R.determinant() < 0.0)
    throw Error(name + ": the rotation is not a right-handed orthonormal matrix to 1e-6");
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  bool sized = true;
  if (const auto* box = std::get_if<Box>(&obstacle.shape))
    sized = positive(box->half.minCoeff()) && box->half.allFinite();
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape)) sized = positive(sphere->radius);
  if (const auto* capsule = std::get_if<Capsule>(&obstacle.shape))
    sized = positive(capsule->radius) && positive(capsule->halfLength);
  if (const auto* mesh = std::get_if<MeshPointer>(&obstacle.shape)) sized = *mesh != nullptr;
  if (!sized) throw Error(name + ": the shape has a size that is not positive and finite, or no mesh");
  obstacles_.push_back(std::move(obstacle));
  return static_cast<int>(obstacles_.size()) - 1;
}

Mat3 frameAlong(const Vec3& axis) noexcept {
  const Vec3 side = (std::abs(axis.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY());
  Mat3 frame;
  frame.col(2) = axis;
  frame.col(1) = axis.cross(side).normalized();
  frame.col(0) = frame.col(1).cross(axis);
  return frame;
}

Obstacle halfSpace(const std::string& name, const Vec3& point, const Vec3& normal) {
  return {name, HalfSpace{}, {point, frameAlong(normal)}, Vec6::Zero(), 0};
}

Scene flatWall(const Vec3& point, const Vec3& normal) {
  Scene scene;
  scene.add(halfSpace("wall", point, normal));
  return scene;
}

void Scene::move(int obstacle, const Pose& pose, const Vec6& twist) noexcept {
  obstacles_[static_cast<std::size_t>(obstacle)].pose = pose;
  obstacles_[static_cast<std::size_t>(obstacle)].twist = twist;
}

ToolCache makeToolCache(const Scene& scene, const Tool& tool) {
  ToolCache cache;
  cache.parts.resize(scene.obstacles().size() * static_cast<std::size_t>(tool.count));
  return cache;
}

Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept {
  contacts.count = 0;
  if (!isFinite(pose) || !std::isfinite(margin)) return Status::notFinite;
  const auto visit = [&](const auto& shape, const Segment& axis, double radius, PartCache* known, Collector& out) {
    addPart(shape, axis, radius, known, out);
  };
  if (!forEachPart(scene, tool, pose, margin, cache, contacts, visit)) {
    contacts.count = 0;
    return Status::notFinite;
  }
  return Status::ok;
}

Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept {
  ContactSnapshot contacts;
  const auto visit = [&](const auto& shape, const Segment& axis, double radius, PartCache* known, Collector& out) {
    addNearest(shape, axis, radius, known, out);
  };
  if (!isFinite(pose) || !forEachPart(scene, tool, pose, kNoLimit, cache, contacts, visit) || contacts.count == 0) {
    Contact none;
    none.gap = kNoLimit;
    return none;
  }
  return contacts.contacts[0];
}

ToolSweep sweepTool(const Scene& scene, const Tool& tool, const Pose& from, const Pose& to, ToolCache* cache) noexcept {
  ToolSweep result;
  if (!isFinite(from) || !isFinite(to)) {
    result.status = Status::notFinite;
    return result;
  }
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const Obstacle& obstacle = obstacles[i];
    if (!isFinite(obstacle.pose)) {
      result = ToolSweep();
      result.status = Status::notFinite;
      return result;
    }
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      const Segment first = axisOf(part, from, obstacle), last = axisOf(part, to, obstacle);
      PartCache* known = cacheOf(cache, i, k, tool.count);
      const SweepHit hit =
          std::visit([&](const auto& shape) { return sweepPart(shapeOf(shape), first, last, part.radius, known); },
                     obstacle.shape);
      if (!hit.hit || (result.hit && !(hit.time < result.time))) continue;
      result.hit = true;
      result.time = hit.time;
      Contact& contact = result.contact;
      contact.normal = obstacle.pose.rotation * hit.normal;
      contact.point = obstacle.pose.rotation * hit.point + obstacle.pose.position;
      contact.gap = 0.0;
      contact.obstacleVelocity =
          obstacle.twist.head<3>() + Vec3(obstacle.twist.tail<3>()).cross(contact.point - obstacle.pose.position);
      contact.obstacle = static_cast<int>(i);
      contact.material = obstacle.material;
    }
  }
  return result;
}

}  // namespace enamel
