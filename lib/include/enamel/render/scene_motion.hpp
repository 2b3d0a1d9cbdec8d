// Interpolation of obstacle poses that a host sets at frame rate.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/scene.hpp"

namespace enamel {

/// A copy of a scene in which obstacles move continuously. HapticTick has one.
///
/// - New pose at every tick: the obstacle is at that pose. Its velocity is the stated twist if that agrees within half
///   with the rate of the poses. Otherwise its velocity is that rate.
/// - Poses less often: the obstacle glides to each pose with constant velocity. A glide takes 1.2 times the time since
///   the last pose, at most 0.12 s. The obstacle therefore arrives a fifth of a frame late, but does not stop when a
///   frame is late.
/// - No new poses: the obstacle is at rest, whatever its stated twist.
class SceneMotion {
 public:
  /// Copy the scene. Its obstacles and shapes must not change later. Realtime: no.
  explicit SceneMotion(const Scene& scene);

  /// Return the scene at `time`, s, which must not decrease; `stated` is the original. Realtime: yes.
  const Scene& follow(const Scene& stated, double time) noexcept;

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
  void followOne(const Obstacle& stated, int number, double before) noexcept;

  Scene scene_;
  std::vector<Glide> glides_;
  double time_ = 0.0;  // of the last call, s
  bool started_ = false;
  std::uint64_t ignored_ = 0;
  int ignoredObstacle_ = -1;
};

}  // namespace enamel
