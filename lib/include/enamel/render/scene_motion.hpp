// Motion of obstacles: poses that a host sets at frame rate, and contact forces on movable obstacles.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/scene.hpp"
#include "enamel/render/frame.hpp"
#include "enamel/render/suspended.hpp"

namespace enamel {

/// A copy of a scene in which obstacles move continuously. HapticTick has one.
///
/// - New pose at every tick: the obstacle is at that pose. Its velocity is the stated twist if that agrees within half
///   with the rate of the poses. Otherwise its velocity is that rate.
/// - Poses less often: the obstacle glides to each pose with constant velocity. A glide takes 1.2 times the time since
///   the last pose, at most 0.12 s. The obstacle therefore arrives a fifth of a frame late, but does not stop when a
///   frame is late.
/// - No new poses: the obstacle is at rest, whatever its stated twist.
///
/// For an obstacle with a Suspension, this motion is that of its place at rest.
class SceneMotion {
 public:
  /// Copy the scene. Its obstacles and shapes must not change later. Realtime: no.
  explicit SceneMotion(const Scene& scene);

  /// Return the scene at `time`, s, which must not decrease; `stated` is the original. Movable obstacles advance by
  /// `elapsed` s under the forces of push(). Realtime: yes.
  const Scene& follow(const Scene& stated, double time, double elapsed = 0.0) noexcept;

  /// Fill in how the movable obstacles at the contacts answer a force in a tick of `period` s. `scale`: of the device's
  /// workspace, as masses are stated for forces at the hand. Realtime: yes.
  void yieldAt(const ContactSnapshot& contacts, double period, double scale, ContactYield& yield) const noexcept;

  /// Add a force (W, N, at the hand) on a movable obstacle at a point (W, m). Others ignore it. Realtime: yes.
  void push(int obstacle, const Vec3& point, const Vec3& force) noexcept;
  /// Add an impulse of another device's tool, as in SuspendedState. Realtime: yes.
  void push(int obstacle, const Vec6& impulse) noexcept;

  /// Add the force of a pit around the tool, across `normal` (W) at a point. It is that of a spring of `stiffness`,
  /// N/m, by the way of the obstacle in the next step of `period` s: implicit Euler, as the suspension. Call it after
  /// push(). Realtime: yes.
  void hold(int obstacle, const Vec3& point, const Vec3& normal, double stiffness, double period) noexcept;

  /// Multiply all forces of push() by a factor. Realtime: yes.
  void scaleForces(double factor) noexcept;

  /// Return the state of a movable obstacle; null for others. Realtime: yes.
  const SuspendedState* suspended(int obstacle) const noexcept;

  /// Save and load the states of the movable obstacles as stateSize() numbers. Realtime: yes.
  std::size_t stateSize() const noexcept;
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

  /// Return the scene of the last call of follow(). Realtime: yes.
  const Scene& scene() const noexcept { return scene_; }

  /// Put all obstacles at their stated poses, at rest. Realtime: yes.
  void reset(const Scene& stated) noexcept;

  /// Continue the motions of `old` among the obstacles that both scenes have (isSameObstacle()). Realtime: yes.
  void takeOver(const SceneMotion& old) noexcept;

  /// Return how often a twist above 1 mm/s or 0.02 rad/s contradicted the poses since construction, once per tick and
  /// obstacle. ignoredObstacle() returns the last such obstacle, or -1. Realtime: yes.
  std::uint64_t ignoredTwists() const noexcept { return ignored_; }
  int ignoredObstacle() const noexcept { return ignoredObstacle_; }

 private:
  struct Glide {
    Pose goal;                  // last pose that was set
    double set = 0.0;           // time when it was set, s
    double left = 0.0;          // time left until the goal, s
    Vec6 twist = Vec6::Zero();  // velocity until then
  };
  struct Body {  // a movable obstacle
    int obstacle;
    Pose rest;  // of its frame, W
    Vec6 restTwist = Vec6::Zero();
    SuspendedState state;
  };
  void followOne(const Obstacle& stated, int number, double before) noexcept;
  void goToStated(const Scene& stated) noexcept;
  bool place(const Body& body) noexcept;
  const Suspension& of(const Body& body) const noexcept;
  const Body* find(int obstacle) const noexcept;
  Vec6 wrenchAt(const Body& body, const Vec3& point, const Vec3& force) const noexcept;

  Scene scene_;
  std::vector<Glide> glides_;
  std::vector<Body> bodies_;
  double time_ = 0.0;  // of the last call, s
  bool started_ = false;
  std::uint64_t ignored_ = 0;
  int ignoredObstacle_ = -1;
};

}  // namespace enamel
