// Obstacles between the poses that a host sets: a host at frame rate moves them in steps, a tick sees them glide.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/scene.hpp"

namespace enamel {

/// A copy of a scene whose obstacles move as the poses of the original say. A value; HapticTick has one.
///
/// An obstacle whose pose is new at every tick is where its pose is. One whose pose is new less often glides from pose
/// to pose, over 1.2 times the time since the pose before and at most 0.12 s: so it arrives a fifth of a frame after
/// the pose, and does not stop where a frame comes late. Its velocity is that of its motion. The stated twist counts
/// where the pose is new at every tick and the twist is within half of the pose's rate; elsewhere it is ignored. An
/// obstacle whose pose stays does not move, whatever its twist says.
class SceneMotion {
 public:
  /// The scene must not get obstacles, nor other shapes, later. Realtime: no.
  explicit SceneMotion(const Scene& scene);

  /// The scene at a time that is not before that of the last call, s; `stated` is the original. Realtime: yes.
  const Scene& follow(const Scene& stated, double time) noexcept;

  /// As it was at the last call of follow(). Realtime: yes.
  const Scene& scene() const noexcept { return scene_; }

  /// All obstacles are at rest where they are stated. Realtime: yes.
  void reset(const Scene& stated) noexcept;

  /// Twists above 1 mm/s or 0.02 rad/s that contradicted the poses, a tick and obstacle each, since construction, and
  /// the last one's obstacle (-1: none). Realtime: yes.
  std::uint64_t ignoredTwists() const noexcept { return ignored_; }
  int ignoredObstacle() const noexcept { return ignoredObstacle_; }

 private:
  struct Glide {
    Pose goal;                  // the pose that was set last
    double set = 0.0;           // when, s
    double left = 0.0;          // time until the goal, s
    Vec6 twist = Vec6::Zero();  // until then
  };
  void followOne(const Obstacle& stated, int number, double elapsed) noexcept;

  Scene scene_;
  std::vector<Glide> glides_;
  double time_ = 0.0;  // of the last call, s
  bool started_ = false;
  std::uint64_t ignored_ = 0;
  int ignoredObstacle_ = -1;
};

}  // namespace enamel
