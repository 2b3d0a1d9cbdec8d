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

using MeshPointer = std::shared_ptr<const MeshModel>;

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

// A local minimum of the distance from a point.
struct Minimum {
  Vec3 point, normal;
  double distance = 0.0;
  int triangle = 0;
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
  for (; place > 0 && minimum.distance == minima.all[place - 1].distance; --place) {
    Minimum& known = minima.all[place - 1];
    if (known.point == minimum.point) {  // a corner or edge, seen from another triangle
      known.triangle = std::min(known.triangle, minimum.triangle);
      return;
    }
    if (known.triangle < minimum.triangle) break;
  }
  if (place == Minima::kMost) return;
  minima.count = std::min(minima.count + 1, Minima::kMost);
  for (int i = minima.count - 1; i > place; --i) minima.all[i] = minima.all[i - 1];
  minima.all[place] = minimum;
}

// From the nearest on, one for each direction.
void thinOut(Minima& minima) {
  int kept = 0;
  for (int i = 0; i < minima.count && kept < kMaxContacts; ++i) {
    const Minimum& candidate = minima.all[i];
    const bool isNew = std::none_of(minima.all.begin(), minima.all.begin() + kept, [&](const Minimum& known) {
      return known.normal.dot(candidate.normal) > kSameDirection;
    });
    if (isNew) minima.all[kept++] = candidate;
  }
  minima.count = kept;
}

struct MinimaSearch {
  const MeshData* data;
  Vec3 p;
  Minima minima;
};

// Whether triangle `number` has a point nearer to p than `squared`.
bool hasNearer(const MinimaSearch& s, std::int32_t number, double squared) {
  if (number < 0) return false;
  Candidate c;
  closestOnTriangle(&s.data->triangles[s.data->slotOf[number]], s.p.data(), &c);
  return c.squared < squared * (1.0 - 1e-12);
}

// A point on an edge or corner is a local minimum if no other triangle there comes nearer.
bool isMinimum(const MinimaSearch& s, std::int32_t number, const Candidate& c) {
  if (c.feature == kFace) return true;
  const auto& neighbour = s.data->neighbour;
  if (c.feature >= kEdge01) return !hasNearer(s, neighbour[number][c.feature - kEdge01], c.squared);
  const auto& triangles = s.data->mesh.triangles;
  const int place = s.data->place[triangles[number][c.feature]];
  for (const int turn : {2, 0}) {  // round the corner one way, and the other way where a border stops the walk
    std::int32_t at = number;
    for (int step = 0; step < kMostFanSteps; ++step) {
      int corner = 0;
      while (corner < 2 && s.data->place[triangles[at][corner]] != place) ++corner;
      at = neighbour[at][(corner + turn) % 3];
      if (at == number) return true;
      if (at < 0) break;
      if (hasNearer(s, at, c.squared)) return false;
    }
  }
  return true;
}

double tryMinimum(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<MinimaSearch*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  Candidate c;
  closestOnTriangle(&triangle, s.p.data(), &c);
  if (!(c.squared <= reach * reach) || !(c.squared > 0.0)) return reach;
  Minimum minimum;
  minimum.point = vec(c.point);
  minimum.distance = std::sqrt(c.squared);
  minimum.normal = (s.p - minimum.point) / minimum.distance;
  minimum.triangle = triangle.index;
  if (isMinimum(s, triangle.index, c)) keepMinimum(minimum, s.minima);
  return reach;
}

// Contacts of one tick while they are collected; the deepest first.
struct Collector {
  ContactSnapshot* contacts;
  const Obstacle* obstacle;
  int number;
  double margin;

  // `normal` and `velocity` are made from the obstacle's frame.
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

// Signed distance of p, or, where a ball known from an earlier tick shows that it is more than `reach`, no more than it
// is. Outside of a closed surface the sign cannot change before the surface is met.
SurfacePoint distanceBeyond(const MeshModel& mesh, const Vec3& p, double reach, PointCache* cache) {
  if (cache == nullptr || !mesh.data().closed) return signedDistance(mesh, p, cache ? &cache->proximity : nullptr);
  if (cache->revision == mesh.data().view.revision) {
    SurfacePoint bound;
    bound.distance = cache->clear - (p - cache->centre).norm();
    if (bound.distance > reach) return bound;
  }
  const SurfacePoint found = signedDistance(mesh, p, &cache->proximity);
  cache->revision = mesh.data().view.revision;
  cache->centre = p;
  cache->clear = (found.triangle < 0 ? kNoLimit : found.distance) * (1.0 - 1e-9);
  return found;
}

void addSphere(const MeshModel& mesh, const Vec3& centre, double radius, PointCache* cache, Collector& out) {
  const double reach = radius + std::max(out.margin, 0.0);
  const SurfacePoint nearest = distanceBeyond(mesh, centre, reach, cache);
  if (nearest.triangle < 0 || nearest.distance > radius + out.margin) return;
  const double single = 1e-9 * reach;
  if (nearest.distance <= single) {  // on or behind the surface: one way out
    out.add(centre, nearest.normal, nearest.distance, radius);
    return;
  }
  MinimaSearch s{&mesh.data(), centre, {}};
  loops().visitMinima(s.data->view, centre.data(), reach, &tryMinimum, &s);
  thinOut(s.minima);
  if (s.minima.count == 0) out.add(centre, nearest.normal, nearest.distance, radius);
  for (int i = 0; i < s.minima.count; ++i) out.add(centre, s.minima.all[i].normal, s.minima.all[i].distance, radius);
}

template <typename Analytic>
void addSphere(const Analytic& shape, const Vec3& centre, double radius, PointCache*, Collector& out) {
  const ShapePoint nearest = signedDistance(shape, centre);
  out.add(centre, nearest.normal, nearest.distance, radius);
}

// The signed distance, or a number above `reach` that is no more than it.
double distanceOf(const MeshModel& mesh, const Vec3& p, double reach, PointCache* cache) {
  const SurfacePoint found = distanceBeyond(mesh, p, reach, cache);
  return found.triangle < 0 && found.distance == 0.0 ? kNoLimit : found.distance;
}

template <typename Analytic>
double distanceOf(const Analytic& shape, const Vec3& p, double, PointCache*) {
  return signedDistance(shape, p).distance;
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

template <typename ShapeType>
void addPart(const ShapeType& shape, const Segment& axis, double radius, PointCache* caches, Collector& out) {
  const auto cache = [caches](int i) { return caches == nullptr ? nullptr : caches + i; };
  addSphere(shape, axis.a, radius, cache(0), out);
  if (axis.a == axis.b) return;
  addSphere(shape, axis.b, radius, cache(1), out);
  // Distances change by no more than the way: between the ends they are at least (|a| + |b| - length) / 2.
  const double reach = radius + std::max(out.margin, 0.0);
  const double atA = distanceOf(shape, axis.a, reach, cache(0)), atB = distanceOf(shape, axis.b, reach, cache(1));
  if (std::abs(atA) + std::abs(atB) - (axis.b - axis.a).norm() > 2.0 * reach) return;
  const double t = nearestOnAxis(shape, axis, reach);
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec3 middle = axis.a + t * (axis.b - axis.a);
  // What is out of reach counts as far, so that a bound does as well as the distance.
  const double ends = std::min(atA > reach ? kNoLimit : atA, atB > reach ? kNoLimit : atB);
  if (distanceOf(shape, middle, reach, cache(2)) < ends - kClearlyNearer)
    addSphere(shape, middle, radius, cache(2), out);
}

SurfacePoint nearestOf(const MeshModel& mesh, const Vec3& p, PointCache* cache) {
  return signedDistance(mesh, p, cache == nullptr ? nullptr : &cache->proximity);
}

template <typename Analytic>
ShapePoint nearestOf(const Analytic& shape, const Vec3& p, PointCache*) {
  return signedDistance(shape, p);
}

// Adds the nearest place of a part, under the rules of addPart().
template <typename ShapeType>
void addNearest(const ShapeType& shape, const Segment& axis, double radius, PointCache* caches, Collector& out) {
  const auto cache = [caches](int i) { return caches == nullptr ? nullptr : caches + i; };
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
  if (between.distance < ends - kClearlyNearer)
    out.add(middle, between.normal, between.distance, radius);
}

Vec3 toObstacle(const Obstacle& obstacle, const Vec3& p_W) {
  return obstacle.pose.rotation.transpose() * (p_W - obstacle.pose.position);
}

Segment axisOf(const ToolPart& part, const Pose& pose, const Obstacle& obstacle) {
  return {toObstacle(obstacle, pose.rotation * part.a + pose.position),
          toObstacle(obstacle, pose.rotation * part.b + pose.position)};
}

bool isFinite(const Pose& pose) { return pose.position.allFinite() && pose.rotation.allFinite(); }

PointCache* cachesOf(ToolCache* cache, std::size_t obstacle, int part, int parts) {
  if (cache == nullptr) return nullptr;
  const std::size_t first = 3 * (obstacle * static_cast<std::size_t>(parts) + static_cast<std::size_t>(part));
  return first + 3 <= cache->points.size() ? &cache->points[first] : nullptr;
}

// Calls visit(shape, axis, radius, caches, collector) for every part and obstacle; false where an obstacle's pose is
// not finite.
template <typename Visit>
bool forEachPart(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                 ContactSnapshot& contacts, const Visit& visit) {
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (!isFinite(obstacles[i].pose)) return false;
    Collector out{&contacts, &obstacles[i], static_cast<int>(i), margin};
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      const Segment axis = axisOf(part, pose, obstacles[i]);
      PointCache* caches = cachesOf(cache, i, k, tool.count);
      std::visit([&](const auto& shape) { visit(shapeOf(shape), axis, part.radius, caches, out); }, obstacles[i].shape);
    }
  }
  return true;
}

// Analytic shapes: the signed distance of the sphere's centre is convex in time, so Newton's steps from the left never
// pass its first root. A capsule advances by what distance and speed allow.
template <typename Analytic>
SweepHit sweepPart(const Analytic& shape, const Segment& from, const Segment& to, double radius, PointCache*) {
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
    if (gap <= (isSphere ? tolerance : 1e-10 * speed + tolerance) || step == 255) {
      result.hit = true;
      result.time = time;
      result.point = near.point;
      result.normal = near.normal;
      return result;
    }
    const double closing = isSphere ? -near.normal.dot(wayA) : speed;
    if (!(closing > 0.0)) return result;
    time += gap / closing;
    if (!(time <= 1.0)) return result;
  }
  return result;
}

SweepHit sweepPart(const MeshModel& mesh, const Segment& from, const Segment& to, double radius, PointCache* caches) {
  if (from.a == from.b && to.a == to.b)
    return sweepSphere(mesh, from.a, to.a, radius, caches == nullptr ? nullptr : &caches->proximity);
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
  cache.points.resize(3 * scene.obstacles().size() * static_cast<std::size_t>(tool.count));
  return cache;
}

Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept {
  contacts.count = 0;
  if (!isFinite(pose) || !std::isfinite(margin)) return Status::notFinite;
  const auto visit = [&](const auto& shape, const Segment& axis, double radius, PointCache* caches, Collector& out) {
    addPart(shape, axis, radius, caches, out);
  };
  if (!forEachPart(scene, tool, pose, margin, cache, contacts, visit)) {
    contacts.count = 0;
    return Status::notFinite;
  }
  return Status::ok;
}

Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept {
  ContactSnapshot contacts;
  const auto visit = [&](const auto& shape, const Segment& axis, double radius, PointCache* caches, Collector& out) {
    addNearest(shape, axis, radius, caches, out);
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
      PointCache* caches = cachesOf(cache, i, k, tool.count);
      const SweepHit hit =
          std::visit([&](const auto& shape) { return sweepPart(shapeOf(shape), first, last, part.radius, caches); },
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
