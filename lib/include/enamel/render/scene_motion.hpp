// Interpolation of obstacle poses that a host sets at frame rate.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/scene.hpp"

namespace enamel {

/// A copy of a scene in which obstacles move continuously. HapticTick has one.
///
/// If the pose of an obstacle is new at every tick, the obstacle is at that pose. Its velocity is the stated twist if
/// that is within half of the rate of the poses, else that rate. If poses come less often, the obstacle glides to each
/// one with constant velocity. A glide takes 1.2 times the time since the pose before, at most 0.12 s: the obstacle
/// arrives a fifth of a frame late and does not stop when a frame is late. Without new poses an obstacle is at rest,
/// whatever twist is stated.
class SceneMotion {
 public:
  /// Obstacles and shapes of the scene must not change later. Realtime: no.
  explicit SceneMotion(const Scene& scene);

  /// Return the scene at `time`, s, which must not decrease; `stated` is the original. Realtime: yes.
  const Scene& follow(const Scene& stated, double time) noexcept;

  /// Return the scene of the last call of follow(). Realtime: yes.
  const Scene& scene() const noexcept { return scene_; }

  /// Put all obstacles at their stated poses, at rest. Realtime: yes.
  void reset(const Scene& stated) noexcept;

  /// Return how often a twist above 1 mm/s or 0.02 rad/s contradicted the poses since construction (once a tick and
  /// obstacle), and the last such obstacle (-1: none). Realtime: yes.
  std::uint64_t ignoredTwists() const noexcept { return ignored_; }
  int ignoredObstacle() const noexcept { return ignoredObstacle_; }

 private:
  struct Glide {
    Pose goal;                  // the pose that was set last
    double set = 0.0;           // when, s
    double left = 0.0;          // time until the goal, s
    Vec6 twist = Vec6::Zero();  // until then
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
