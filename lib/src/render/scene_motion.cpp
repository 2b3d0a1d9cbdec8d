#include "enamel/render/scene_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enamel {
namespace {

constexpr double kLongestFrame = 0.1;                    // s: a newer pose belongs to a motion
constexpr double kStretch = 1.2;                         // of a frame: how late the next one may be
constexpr double kTwistError = 0.5;                      // share of the stated twist, or of the motion
constexpr double kLeastSpeed = 1e-3, kLeastTurn = 0.02;  // m/s, rad/s: smaller differences do not count

bool isSame(const Pose& a, const Pose& b) noexcept { return a.position == b.position && a.rotation == b.rotation; }

// Twist [v; w] in W between two poses that are `time` s apart.
Vec6 twistBetween(const Pose& from, const Pose& to, double time) noexcept {
  Vec6 twist;
  twist << (to.position - from.position) / time, rotationVector(to.rotation * from.rotation.transpose()) / time;
  return twist;
}

bool agrees(const Vec3& stated, const Vec3& real, double least) noexcept {
  return (stated - real).norm() <= std::max(least, kTwistError * std::max(stated.norm(), real.norm()));
}

bool agrees(const Vec6& stated, const Vec6& real) noexcept {
  return agrees(stated.head<3>(), real.head<3>(), kLeastSpeed) && agrees(stated.tail<3>(), real.tail<3>(), kLeastTurn);
}

}  // namespace

SceneMotion::SceneMotion(const Scene& scene) : scene_(scene), glides_(scene.obstacles().size()) { reset(scene); }

void SceneMotion::reset(const Scene& stated) noexcept {
  for (std::size_t i = 0; i < glides_.size() && i < stated.obstacles().size(); ++i) {
    glides_[i] = {stated.obstacles()[i].pose, 0.0, 0.0, Vec6::Zero()};
    (void)scene_.move(static_cast<int>(i), glides_[i].goal, Vec6::Zero());
    (void)scene_.activate(static_cast<int>(i), stated.obstacles()[i].active);
  }
  started_ = false;
}

void SceneMotion::takeOver(const SceneMotion& old) noexcept {
  if (!old.started_) return;
  started_ = true;
  time_ = old.time_;
  ignored_ = old.ignored_;
  ignoredObstacle_ = old.ignoredObstacle_;
  for (std::size_t i = 0; i < glides_.size(); ++i) {
    glides_[i].set = time_ - kLongestFrame;
    if (!isSameObstacle(old.scene_, scene_, i)) continue;
    const Obstacle& moved = old.scene_.obstacles()[i];
    glides_[i] = old.glides_[i];
    (void)scene_.move(static_cast<int>(i), moved.pose, moved.twist);
  }
}

const Scene& SceneMotion::follow(const Scene& stated, double time) noexcept {
  if (!started_) {
    reset(stated);
    for (Glide& glide : glides_) glide.set = time - kLongestFrame;
    started_ = true;
  }
  const double before = std::exchange(time_, time);
  for (std::size_t i = 0; i < glides_.size() && i < stated.obstacles().size(); ++i)
    followOne(stated.obstacles()[i], static_cast<int>(i), before);
  return scene_;
}

void SceneMotion::followOne(const Obstacle& stated, int number, double before) noexcept {
  Glide& glide = glides_[static_cast<std::size_t>(number)];
  if (stated.active != scene_.obstacles()[static_cast<std::size_t>(number)].active) {
    (void)scene_.activate(number, stated.active);
    (void)scene_.move(number, stated.pose, Vec6::Zero());  // it appears at its stated pose, at rest
    glide = {stated.pose, time_ - kLongestFrame, 0.0, Vec6::Zero()};
    return;
  }
  const Pose& pose = scene_.obstacles()[static_cast<std::size_t>(number)].pose;
  const bool isNew = !isSame(stated.pose, glide.goal);
  if (!isNew && glide.left == 0.0 && glide.twist.isZero(0.0) && stated.twist.isZero(0.0)) return;  // most obstacles
  const double elapsed = time_ - before, since = std::min(time_ - glide.set, kLongestFrame);
  if (!isNew && glide.left == 0.0) glide.twist.setZero();
  Vec6 measured = glide.twist;  // from the poses
  if (isNew) {
    measured = twistBetween(glide.goal, stated.pose, since);
    if (glide.set == before) {  // a new pose in every tick
      glide.left = elapsed;
      glide.twist = agrees(stated.twist, measured) ? stated.twist : measured;
    } else {
      glide.left = std::max(elapsed, kStretch * since);
      glide.twist = twistBetween(pose, stated.pose, glide.left);
    }
    glide.goal = stated.pose;
    glide.set = time_;
  }
  const bool begins = isNew && since == kLongestFrame;  // the first pose of a motion says nothing about the velocity
  if (!begins && !stated.twist.isZero(0.0) && !agrees(stated.twist, measured)) {
    ++ignored_;
    ignoredObstacle_ = number;
  }
  if (glide.left > elapsed * (1.0 + 1e-9)) {
    Pose next;
    next.position = pose.position + elapsed * glide.twist.head<3>();
    next.rotation = rotationFromVector(elapsed * glide.twist.tail<3>()) * pose.rotation;
    glide.left -= elapsed;
    if (scene_.move(number, next, glide.twist) == Status::ok) return;  // otherwise rounding has spoilt the rotation
  }
  glide.left = 0.0;
  (void)scene_.move(number, glide.goal, glide.twist);
}

}  // namespace enamel
