#include "enamel/render/position_control.hpp"

#include <cmath>
#include <string>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"

namespace enamel {

PositionControlRenderer::PositionControlRenderer(const TauModel& model, const Gain& gain, double period,
                                                 const PositionControlOptions& options)
    : model_(model), gain_(gain), period_(period), options_(options) {
  if (!gain_.allFinite()) throw Error("position-control renderer: the gain K is not finite");
  if (!(options_.releaseForce >= 0.0 && std::isfinite(options_.releaseForce)))
    throw Error("position-control renderer: release force is " + formatNumber(options_.releaseForce) +
                ", must be at least 0 N and finite");
}

void PositionControlRenderer::prepare(double period) {
  if (!(std::abs(period - period_) <= 1e-9 * period_))
    throw Error("position-control renderer: activated for a period of " + formatNumber(period) +
                " s, but its gain was designed for " + formatNumber(period_) + " s");
}

Status PositionControlRenderer::render(const TickInput& input, TickOutput& output) noexcept {
  TauConfiguration configuration;
  Status status = inverseKinematics(model_, input.pose, configuration);
  if (status != Status::ok) return status;

  if (state_.phase != kHolding && touches(input)) {
    status = hold(input, configuration);
    if (status != Status::ok) return status;
  }
  if (state_.phase == kHolding) {
    const Vec6 error = input.q - state_.reference;
    const Vec6 servo = -(gain_.leftCols<6>().lazyProduct(input.rates) + gain_.middleCols<6>(6).lazyProduct(error) +
                         gain_.rightCols<6>().lazyProduct(state_.integral));
    output.normalForce = state_.normal.dot(wrenchFromTorques(model_, configuration, servo).head<3>());
    if (options_.release && output.normalForce < -options_.releaseForce) {
      state_ = State{};
      state_.phase = kReleased;
      output.normalForce = 0.0;
    } else {
      output.mode = RenderMode::contact;
      output.torque = state_.feedForward + servo;
      const bool cut = (output.torque.array().abs() > input.maxTorque).any();
      if (!(options_.antiWindup && cut)) state_.integral -= period_ * error;
      return Status::ok;
    }
  }
  output.mode = RenderMode::free;
  output.torque = gravityTorque(model_, configuration);
  return Status::ok;
}

bool PositionControlRenderer::touches(const TickInput& input) noexcept {
  const bool inside = input.contacts.count > 0 && input.contacts.contacts[0].gap <= kTouchGap;
  if (!inside) {
    state_.phase = kFree;
    return false;
  }
  if (state_.phase == kFree) return true;
  const Contact& contact = input.contacts.contacts[0];
  const Vec3 arm = contact.point - input.pose.position;
  const Vec3 velocity = input.twist.head<3>() + crossMatrix(input.twist.tail<3>()) * arm - contact.obstacleVelocity;
  return contact.normal.dot(velocity) < 0.0;
}

// Takes the reference: the joint pose at first touch or, with release, the pose projected back to the surface.
Status PositionControlRenderer::hold(const TickInput& input, const TauConfiguration& configuration) noexcept {
  const Contact& contact = input.contacts.contacts[0];
  State next;
  next.normal = contact.normal;
  next.phase = kHolding;
  next.reference = input.q;
  TauConfiguration surface = configuration;
  if (options_.release && contact.gap < 0.0) {
    Pose pose = input.pose;
    pose.position -= contact.gap * contact.normal;
    const Status status = inverseKinematics(model_, pose, surface);
    if (status != Status::ok) return status;
    // Encoders may count several turns: move the measured angles by the difference.
    const Vec6 change = jointAngles(surface) - jointAngles(configuration);
    for (int i = 0; i < 6; ++i) next.reference[i] += std::remainder(change[i], 2.0 * M_PI);
  }
  next.feedForward = gravityTorque(model_, surface);
  state_ = next;
  return Status::ok;
}

}  // namespace enamel
