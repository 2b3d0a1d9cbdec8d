#include "hand.hpp"

#include <algorithm>

namespace enamel::viewer {
namespace {

constexpr double kHandRate = 30.0;                              // rad/s
constexpr double kStopStiffness = 3000.0, kStopDamping = 20.0;  // N/m, N s/m

}  // namespace

Vec3 stiffnessOf(const Grip& grip) noexcept {
  const double across = std::max(grip.stiffness, kGuideGrip.stiffness);
  return {across, across, grip.stiffness};
}

Vec3 dampingOf(const Grip& grip) noexcept {
  const double across = std::max(grip.damping, kGuideGrip.damping);
  return {across, across, grip.damping};
}

void keepWithinReach(Hand& hand, const Vec3& tool) noexcept {
  const Vec3 stretch = hand.target - tool;
  const double force = stiffnessOf(hand.grip).cwiseProduct(stretch).norm();
  if (force > kLargestHandForce) hand.target = tool + (kLargestHandForce / force) * stretch;
  constexpr double end = kStop + kBeyondStop;
  for (int i = 0; i < 3; ++i) {
    if (tool[i] >= kStop) hand.target[i] = std::min(hand.target[i], end);
    if (tool[i] <= -kStop) hand.target[i] = std::max(hand.target[i], -end);
  }
}

void moveHand(Hand& hand, double dt) noexcept {
  const Vec3 acceleration = kHandRate * kHandRate * (hand.target - hand.position) - 2.0 * kHandRate * hand.velocity;
  hand.velocity += dt * acceleration;
  hand.position += dt * hand.velocity;
}

HandWrench::HandWrench(const Hand& hand, double since, const Vec3& held) noexcept
    : stiffness_(stiffnessOf(hand.grip)),
      damping_(dampingOf(hand.grip)),
      position_(hand.position),
      velocity_(hand.velocity),
      held_(held),
      since_(since) {}

Vec6 HandWrench::operator()(double time, const Pose& pose, const Vec6& twist) const noexcept {
  const Vec3 point = position_ + (time - since_) * velocity_;
  Vec6 wrench;
  wrench.head<3>() =
      held_ + stiffness_.cwiseProduct(point - pose.position) + damping_.cwiseProduct(velocity_ - twist.head<3>());
  wrench.tail<3>() = holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
  for (int i = 0; i < 3; ++i) {
    const double excess = pose.position[i] - std::clamp(pose.position[i], -kStop, kStop);
    if (excess != 0.0) wrench[i] -= kStopStiffness * excess + kStopDamping * twist[i];
  }
  return wrench;
}

}  // namespace enamel::viewer
