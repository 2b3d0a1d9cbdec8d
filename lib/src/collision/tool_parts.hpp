// Shared by the queries of whole tools: parts in the frame of an obstacle, their caches, contacts.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "enamel/collision/contacts.hpp"
#include "mesh_data.hpp"

namespace enamel::kernel {

/// Knowledge about one part of a tool and one obstacle from an earlier tick.
struct PartCache {
  std::array<Cache, 3> points;  ///< both ends and the place between them
  std::uint64_t revision = 0;   ///< of the mesh that the rest belongs to
  Segment axis;                 ///< in the obstacle's frame
  double clear = -1.0;          ///< the axis was outside of the obstacle, at least this far away
  bool isAheadA = false;        ///< its ends were outside
  bool isAheadB = false;
  int nearest = -1;  ///< triangle that was nearest to the axis

  /// Return the cache of a part, or null if it is missing.
  static PartCache* of(ToolCache* cache, std::size_t obstacle, int part) noexcept {
    if (cache == nullptr || obstacle >= cache->parts_.size()) return nullptr;
    std::vector<PartCache>& parts = cache->parts_[obstacle];
    return static_cast<std::size_t>(part) < parts.size() ? &parts[static_cast<std::size_t>(part)] : nullptr;
  }
};

/// Knowledge about a place on an axis and a solid from the last tick. A cut leaves less material, so that `clear`
/// holds.
struct SolidNear {
  Vec3 point = Vec3::Zero();
  double clear = -1.0;  ///< lower bound of the distance of the surface from the point, outside
  std::uint64_t restorations = 0;
  SolidCache cache;
};

/// The place of a part's axis outside the surface, in the frame of one obstacle: a god object.
struct PartTrack {
  Segment axis;                ///< follows the part's axis, but never through the surface
  double clear = -1.0;         ///< lower bound of its distance from the surface
  std::uint64_t revision = 0;  ///< of the mesh
  bool isKnown = false;        ///< false: the part began inside and has not left yet
  SolidNear near;              ///< of the end a; saves work and changes no contact

  enum class State { unknown, open, held };

  /// Follow the part's axis to `goal`. held: the goal is on the other side of the surface.
  State follow(const Obstacle& obstacle, const Segment& goal, PartCache* cache) noexcept;
};

/// Return the first touch of a part with an obstacle, in the obstacle's frame. `advances`: steps of sweepCapsule() on a
/// triangle before it counts as touched.
SweepHit sweepPart(const Obstacle& obstacle, const Segment& from, const Segment& to, double radius, int advances,
                   PartCache* cache) noexcept;

inline Cache* pointOf(PartCache* cache, std::size_t i) noexcept {
  return cache == nullptr ? nullptr : &cache->points[i];
}

inline bool isFinite(const Pose& pose) noexcept { return pose.position.allFinite() && pose.rotation.allFinite(); }

/// Return whether a tool can be there: ok, notFinite, or outOfRange if it is farther away than kFarthestTool.
inline Status checkPlace(const Pose& pose) noexcept {
  if (!isFinite(pose)) return Status::notFinite;
  return pose.position.squaredNorm() <= kFarthestTool * kFarthestTool ? Status::ok : Status::outOfRange;
}

/// Return the axis of a part in the obstacle's frame.
inline Segment axisOf(const ToolPart& part, const Pose& pose, const Obstacle& obstacle) noexcept {
  const auto toObstacle = [&](const Vec3& p_P) {
    return Vec3(obstacle.pose.rotation.transpose() * (pose.rotation * p_P + pose.position - obstacle.pose.position));
  };
  return {toObstacle(part.a), toObstacle(part.b)};
}

inline const MeshModel& shapeOf(const std::shared_ptr<const MeshModel>& mesh) noexcept { return *mesh; }
inline const Solid& shapeOf(const std::shared_ptr<const Solid>& solid) noexcept { return *solid; }
template <typename Analytic>
const Analytic& shapeOf(const Analytic& shape) noexcept {
  return shape;
}
/// Call `work` with an obstacle's shape. Unlike std::visit, compilers see that this cannot throw.
template <std::size_t I = 0, typename Work>
decltype(auto) onShape(const Obstacle& obstacle, const Work& work) noexcept {
  if constexpr (I + 1 < std::variant_size_v<Shape>)
    if (obstacle.shape.index() != I) return onShape<I + 1>(obstacle, work);
  return work(shapeOf(*std::get_if<I>(&obstacle.shape)));
}

/// Return the place on the axis with the smallest signed distance, 0 to 1, or -1 for one of the ends. The signed
/// distance of a convex shape is convex along the axis, so bisect by its slope, which the normal gives.
inline double nearestOnAxis(const HalfSpace&, const Segment&) noexcept { return -1.0; }

template <typename Analytic>
double nearestOnAxis(const Analytic& shape, const Segment& axis) noexcept {
  constexpr int kHalvings = 64;  // below 1e-18 of the length
  const Vec3 along = axis.b - axis.a;
  const auto rises = [&](double t) { return signedDistance(shape, axis.a + t * along).normal.dot(along) > 0.0; };
  if (rises(0.0)) return 0.0;
  if (!rises(1.0)) return 1.0;
  double low = 0.0, high = 1.0;
  for (int step = 0; step < kHalvings; ++step) {
    const double middle = 0.5 * (low + high);
    (rises(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

inline int triangleOf(const ShapePoint&) noexcept { return -1; }
inline int triangleOf(const SolidPoint&) noexcept { return -1; }
template <typename OnMesh>
int triangleOf(const OnMesh& found) noexcept {
  return found.triangle;
}

template <typename Found>
const Material& materialOf(const Obstacle& obstacle, const Found&) noexcept {
  return obstacle.material;
}
inline const Material& materialOf(const Obstacle& obstacle, const SolidPoint& found) noexcept {
  const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape);
  return (*solid)->layers()[static_cast<std::size_t>(found.layer)].material;
}

/// A tool's part and an obstacle of the scene.
struct Pair {
  const Obstacle* obstacle;
  int number;
  int part;
};

/// Fill the contact at contact.point from the pair and the place `found` on the surface.
template <typename Found>
void complete(const Pair& pair, const Found& found, Contact& contact) noexcept {
  const Obstacle& obstacle = *pair.obstacle;
  contact.obstacleVelocity =
      obstacle.twist.head<3>() + Vec3(obstacle.twist.tail<3>()).cross(contact.point - obstacle.pose.position);
  contact.obstacle = pair.number;
  contact.material = materialOf(obstacle, found);
  contact.compression = -1.0;
  contact.isPunctured = false;
  contact.part = pair.part;
  contact.triangle = triangleOf(found);
  contact.feature = found.feature;
  contact.featureIndex = found.featureIndex;
}

}  // namespace enamel::kernel
