// Named obstacles, at rest or moving.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "enamel/collision/material.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/shapes.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

using Shape =
    std::variant<HalfSpace, Box, Sphere, Capsule, std::shared_ptr<const MeshModel>, std::shared_ptr<const Solid>>;

/// Something that the tool may touch. Its pose and twist may change from tick to tick.
struct Obstacle {
  std::string name;
  Shape shape;
  Pose pose;                  ///< of the obstacle's frame in W
  Vec6 twist = Vec6::Zero();  ///< [v; w] of the obstacle's frame, at its origin, axes of W, m/s and rad/s
  Material material;          ///< carried through to the contacts; a solid's layers have their own
  double thickness = 0.0;     ///< above 0: the mesh is the middle of a sheet as thick as this, without an inside, m
};

/// Limits of an obstacle: distance from the origin of W along each axis, speed, turn rate; m, m/s, rad/s.
inline constexpr double kFarthest = 100.0, kFastest = 100.0, kFastestTurn = 1000.0;

/// Obstacles by number. Add them before the ticks begin; in a tick only poses and twists change.
class Scene {
 public:
  /// Returns the obstacle's number, counted from 0. Throws Error for a name that is empty or taken, a pose that is not
  /// finite, farther than kFarthest or not a rotation to 1e-6, a twist above kFastest or kFastestTurn, a shape without
  /// size, an empty pointer, a thickness that is negative, not finite or of another shape than a mesh. Realtime: no.
  int add(Obstacle obstacle);

  /// Moves an obstacle. Statuses: ok; notFinite; outOfRange for a number that no obstacle has, a matrix that is no
  /// rotation, a position farther than kFarthest, a twist above kFastest or kFastestTurn; the obstacle is then where it
  /// was. A tick sees the motion as SceneMotion has it. Realtime: yes.
  Status move(int obstacle, const Pose& pose, const Vec6& twist) noexcept;

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

}  // namespace enamel
