// Named obstacles and the contacts of a tool with them: what a haptic tick asks of the collision module.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "enamel/collision/contact.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/shapes.hpp"
#include "enamel/collision/sweep.hpp"

namespace enamel {

using Shape = std::variant<HalfSpace, Box, Sphere, Capsule, std::shared_ptr<const MeshModel>>;

/// Something that the tool may touch. Its pose and twist may change from tick to tick.
struct Obstacle {
  std::string name;
  Shape shape;
  Pose pose;                  ///< of the obstacle's frame in W
  Vec6 twist = Vec6::Zero();  ///< [v; w] of the obstacle's frame, at its origin, axes of W, m/s and rad/s
  int material = 0;           ///< carried through to the contacts
};

/// Obstacles by number. Add them before the ticks begin; in a tick only poses and twists change.
class Scene {
 public:
  /// Returns the obstacle's number, counted from 0. Throws Error for a name that is empty or taken, a pose that is not
  /// finite or not a rotation to 1e-6, a shape without size, an empty mesh pointer. Realtime: no.
  int add(Obstacle obstacle);

  /// Moves an obstacle. Inputs are not checked: queries report notFinite. Realtime: yes.
  void move(int obstacle, const Pose& pose, const Vec6& twist) noexcept;

  const std::vector<Obstacle>& obstacles() const noexcept { return obstacles_; }

 private:
  std::vector<Obstacle> obstacles_;
};

/// Rotation whose third column is `axis` (unit length, W): the frame of a half space or a capsule. Realtime: yes.
Mat3 frameAlong(const Vec3& axis) noexcept;

/// Half space behind the plane through `point` (m, W) with the outward unit normal `normal` (W).
Obstacle halfSpace(const std::string& name, const Vec3& point, const Vec3& normal);

/// The scene of one half space, "wall".
Scene flatWall(const Vec3& point = Vec3::Zero(), const Vec3& normal = Vec3::UnitZ());

/// Capsule fixed to the platform frame P: a sphere where both ends are the same, a point where the radius is 0.
struct ToolPart {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis, in P, m
  double radius = 0.0;                      ///< m
};

inline constexpr int kMaxToolParts = 8;

/// Compound of capsules; by default one point at the TCP.
struct Tool {
  std::array<ToolPart, kMaxToolParts> parts{};
  int count = 1;
};

/// What is known of one part of a tool and one obstacle; private to the queries.
struct PartCache {
  std::array<ProximityCache, 3> points;  // both ends and the place between them
  std::uint64_t revision = 0;            // of the mesh that the rest belongs to
  Segment axis;                          // of an earlier tick, in the obstacle's frame
  double clear = -1.0;                   // the axis lay outside of the obstacle, at least so far from it
  bool isAheadA = false;                 // its ends lay outside
  bool isAheadB = false;
  int nearest = -1;  // triangle that was nearest to the axis
};

/// Caches of one tool in one scene. Made outside the ticks; not shared between threads.
struct ToolCache {
  std::vector<PartCache> parts;  ///< one for each part and obstacle
};

/// Caches for `tool` in `scene` as it is now. Realtime: no.
ToolCache makeToolCache(const Scene& scene, const Tool& tool);

/// All contacts whose gap is at most `margin`, the deepest first (then by obstacle), at most kMaxContacts.
/// A sphere at p touches an obstacle at every local minimum of the distance |p - x| over its surface, one for each
/// direction within 15 deg; inside an obstacle at the nearest surface point only. A capsule touches with its two ends
/// and, where its signed distance is below theirs by more than 1e-9 m, with one point of its axis between them: the
/// deepest one in an analytic shape; the one nearest to a mesh, and only while both ends are outside of it. The
/// obstacle's velocity is v + w x r. `cache` may be null and must else come from makeToolCache() of this scene and
/// tool; the contacts are the same (with meshes whose sign is defined: signedDistance()). notFinite: a pose or the
/// margin is not finite; no contacts then. Realtime: yes. Threads: const scene, own cache.
Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept;

/// The contact of smallest gap, near or far, among equals the first of the scene: the first of findContacts() where its
/// gap is within the margin. For a scene without surfaces or a pose that is not finite the gap is kNoLimit.
/// Realtime: yes. Threads: as findContacts().
Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept;

/// First touch of a moving tool.
struct ToolSweep {
  Status status = Status::ok;
  bool hit = false;
  double time = 1.0;  ///< of the first touch, as SweepHit::time
  Contact contact;    ///< there; the point is the obstacle's, the gap 0
};

/// First touch of the tool on its way from one pose to the other, with the obstacles at rest in their poses. The ends
/// of the parts move on straight lines; spheres are exact as in sweepSphere(), capsules as in sweepCapsule().
/// Realtime: yes.
ToolSweep sweepTool(const Scene& scene, const Tool& tool, const Pose& from, const Pose& to, ToolCache* cache) noexcept;

}  // namespace enamel
