// Obstacles with names, at rest or moving, and guides.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "enamel/collision/guide.hpp"
#include "enamel/collision/material.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/shapes.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

using Shape =
    std::variant<HalfSpace, Box, Sphere, Capsule, std::shared_ptr<const MeshModel>, std::shared_ptr<const Solid>>;

/// How an obstacle moves under contact forces: a rigid body on six springs and dampers. Linear coordinates come first,
/// then turns, along and about the axes of the obstacle's frame at rest. These axes do not turn with the obstacle.
struct Suspension {
  Vec3 centre = Vec3::Zero();     ///< of the mass and of the springs, in the obstacle's frame, m
  Vec6 inertia = Vec6::Zero();    ///< kg and kg m^2, at least kLeastMovableInertia; 0: the obstacle does not move along
                                  ///< or about this axis
  Vec6 stiffness = Vec6::Zero();  ///< N/m and N m/rad; 0: a loose obstacle
  Vec6 damping = Vec6::Zero();    ///< N s/m and N m s/rad
};

/// An object that the tool may touch. Its pose and twist may change at every tick.
struct Obstacle {
  std::string name;
  Shape shape;
  Pose pose;                  ///< pose of the obstacle's frame in W
  Vec6 twist = Vec6::Zero();  ///< [v; w] of the obstacle's frame at its origin, axes of W, m/s and rad/s
  Material material;          ///< passed on to the contacts; a solid has a material for each layer
  double thickness = 0.0;     ///< above 0: the mesh is the middle of a sheet of this thickness, without an inside, m
  bool active = true;         ///< false: reserved for later; no query finds it
  std::shared_ptr<const Suspension> suspension = nullptr;  ///< null: contact forces do not move the obstacle
  Tap tap = {};  ///< how the handle vibrates after an impact; a solid has a tap for each layer
};

/// Limits of an obstacle: distance from the origin of W along each axis (m), speed (m/s), turn rate (rad/s).
inline constexpr double kFarthest = 100.0, kFastest = 100.0, kFastestTurn = 1000.0;

/// Least inertia of a suspension that is not 0, kg and kg m^2. A lighter obstacle would be lost in rounding.
inline constexpr double kLeastMovableInertia = 1e-12;

/// A list of obstacles, and guides. Add them before the ticks begin: in a tick only poses, twists and `active` may
/// change. To add obstacles later, give the tick a new TickScene.
class Scene {
 public:
  /// Add an obstacle and return its number, counted from 0. Realtime: no.
  /// Throws Error for:
  /// - a name that is empty or already used;
  /// - a pose that is not finite, farther than kFarthest, or not a rotation within 1e-6;
  /// - a twist that is not finite, or above kFastest or kFastestTurn;
  /// - a shape with a size that is not positive and finite, or with an empty pointer;
  /// - a material with a stiffness not above 0 N/m, friction outside 0 to 10, sliding friction outside 0 to the
  ///   friction, or a viscosity outside 0 to kLargestViscosity;
  /// - a thickness that is negative or not finite, or above 0 for a shape other than a mesh;
  /// - a tap with a number outside its limits, or of a solid;
  /// - a suspension with a number that is not finite or negative (except `centre`), without inertia, or with one
  ///   between 0 and kLeastMovableInertia.
  int add(Obstacle obstacle);

  /// Replace an obstacle; its number remains. Throws Error as add(), and if no obstacle has this number. Realtime: no.
  void replace(int obstacle, Obstacle by);

  /// Activate or deactivate an obstacle. Realtime: yes. Statuses: ok; outOfRange (no obstacle has this number).
  Status activate(int obstacle, bool active) noexcept;

  /// Set the pose and twist of an obstacle. SceneMotion defines the motion that a tick sees. Realtime: yes.
  /// Statuses: ok; notFinite; outOfRange. After an error the obstacle is unchanged. outOfRange means:
  /// - no obstacle has this number;
  /// - the matrix is not a rotation;
  /// - the position is farther than kFarthest;
  /// - the twist is above kFastest or kFastestTurn.
  Status move(int obstacle, const Pose& pose, const Vec6& twist) noexcept;

  const std::vector<Obstacle>& obstacles() const noexcept { return obstacles_; }

  /// Set all guides. Throws Error as checkGuide(), and for more than kMaxGuides. Realtime: no.
  void setGuides(std::vector<Guide> guides);

  /// Return the guides, which copies of the scene share; null: none. Realtime: yes.
  const std::shared_ptr<const std::vector<Guide>>& guides() const noexcept { return guides_; }

 private:
  void check(const Obstacle& obstacle, std::size_t number) const;

  std::vector<Obstacle> obstacles_;
  std::shared_ptr<const std::vector<Guide>> guides_;
};

/// Return whether an obstacle continues to exist in another scene. It must be active in both, with the same number,
/// name, shape and thickness. Meshes and solids are the same if they are the same object. Realtime: yes.
bool isSameObstacle(const Scene& before, const Scene& now, std::size_t number) noexcept;

/// Return the largest extent of a mesh or a solid along its axes, m, if it suggests another unit; otherwise 0. Usual
/// are 1 mm to 1 m, times `scale`, that of the device's workspace in W. Other shapes give 0. Realtime: no.
double unusualSize(const Obstacle& obstacle, double scale = 1.0);

/// Return a rotation whose third column is `axis` (unit length, W): the frame of a half space or a capsule.
/// Realtime: yes.
Mat3 frameAlong(const Vec3& axis) noexcept;

/// Return the half space behind the plane through `point` (m, W) with the outward unit normal `normal` (W).
Obstacle halfSpace(const std::string& name, const Vec3& point, const Vec3& normal);

/// Return a scene with one half space, "wall".
Scene flatWall(const Vec3& point = Vec3::Zero(), const Vec3& normal = Vec3::UnitZ());

}  // namespace enamel
