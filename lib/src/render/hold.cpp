#include "enamel/render/hold.hpp"

#include <algorithm>
#include <cmath>

#include "core/message.hpp"

namespace enamel {

HoldRenderer::HoldRenderer(const ServoGain& gain, double period, const HoldOptions& options)
    : joints_(gain.rows()), period_(period), options_(options) {
  require(gain.rows() >= 1 && gain.cols() == 3 * gain.rows(), "hold renderer: the gain K is " +
                                                                  std::to_string(gain.rows()) + " x " +
                                                                  std::to_string(gain.cols()) + ", must be n x 3n");
  require(gain.allFinite(), "hold renderer: the gain K is not finite");
  require(
      options_.releaseForce >= 0.0 && std::isfinite(options_.releaseForce),
      "hold renderer: release force is " + formatNumber(options_.releaseForce) + ", must be at least 0 N and finite");
  const Eigen::MatrixXd& commands = options_.commandGain;
  require(commands.size() == 0 || (commands.rows() == joints_ && commands.cols() % joints_ == 0 &&
                                   commands.cols() <= kMaxHoldDelay * joints_ && commands.allFinite()),
          "hold renderer: the command gain is " + std::to_string(commands.rows()) + " x " +
              std::to_string(commands.cols()) + ", must be n x dn for a delay d of at most " +
              std::to_string(kMaxHoldDelay) + " ticks, and finite");
  gain_.setZero();
  commandGain_.setZero();
  commandGain_.topLeftCorner(commands.rows(), commands.cols()) = commands;
  gain_.topLeftCorner(gain.rows(), gain.cols()) = gain;
}

void HoldRenderer::prepare(double period) {
  require(std::abs(period - period_) <= 1e-9 * period_,
          "hold renderer: activated for a period of " + formatNumber(period) + " s, but its gain was designed for " +
              formatNumber(period_) + " s");
}

void HoldRenderer::stateLoaded() noexcept {
  if (!isFinite(stateBlock())) resetState();
}

Status HoldRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& k = frame.kinematics;
  const auto n = joints_;
  if (k.q.size() != n) return Status::outOfRange;
  updatePhase(frame);
  output.mode = RenderMode::free;
  output.torque = k.gravity;
  if (state_.phase != kHolding) return Status::ok;

  moveReference(frame);
  const JointVector error = k.q + frame.age * period_ * k.rates - state_.reference.head(n);
  Eigen::Matrix<double, kRows, 1> answer = Eigen::Matrix<double, kRows, 1>::Zero();
  const auto add = [&](Eigen::Index column, double value) { answer -= value * gain_.col(column); };
  for (Eigen::Index i = 0; i < n; ++i) {
    add(i, k.rates[i]);
    add(n + i, error[i]);
    add(2 * n + i, state_.integral[i]);
  }
  for (Eigen::Index i = 0; i < options_.commandGain.cols(); ++i) answer -= state_.commands[i] * commandGain_.col(i);
  const JointVector servo = answer.head(n);
  const double normalForce = state_.normal.dot(wrenchOf(k, servo).head<3>());
  if (options_.release && normalForce < -options_.releaseForce) {
    state_ = State{};
    state_.phase = kReleased;
    return Status::ok;
  }
  output.mode = RenderMode::contact;
  output.normalForce = normalForce;
  output.torque = state_.feedForward.head(n) + servo;
  const bool cut = (output.torque.array().abs() > frame.maxTorque.array()).any();
  if (!(options_.antiWindup && cut)) state_.integral.head(n) -= period_ * error;
  output.saturated = cut;
  if (cut && output.torque.allFinite())
    output.torque = output.torque.cwiseMin(frame.maxTorque).cwiseMax(-frame.maxTorque);
  if (const Eigen::Index late = options_.commandGain.cols(); late > 0) {
    std::copy_backward(state_.commands.begin(), state_.commands.begin() + late - n, state_.commands.begin() + late);
    for (Eigen::Index i = 0; i < n; ++i) state_.commands[i] = output.torque[i] - state_.feedForward[i];
  }
  return Status::ok;
}

void HoldRenderer::updatePhase(const TickFrame& frame) noexcept {
  if (state_.phase == kHolding) return;
  const Contact& contact = frame.contacts.contacts[0];
  const bool inside = frame.contacts.count > 0 && contact.gap <= kTouchGap;
  if (!inside)
    state_.phase = kFree;
  else if (state_.phase == kFree || contact.normal.dot(contactVelocity(frame.kinematics, contact)) < 0.0)
    hold(frame);
}

// Move the reference with the obstacle and on towards the surface.
void HoldRenderer::moveReference(const TickFrame& frame) noexcept {
  const double step = std::min(state_.left, kReferenceSpeed * period_);
  state_.left -= step;
  Vec6 way = Vec6::Zero();
  way.head<3>() = step * state_.normal;
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& contact = frame.contacts.contacts[i];
    if (contact.obstacle != state_.obstacle) continue;
    way.head<3>() += period_ * contact.obstacleVelocity;
    break;
  }
  if (!way.isZero(0.0)) state_.reference.head(joints_) += torqueOf(frame.kinematics.inverseTransposed, way);
}

// Store the reference: the joint pose at first touch or, with release, that pose moved back to the surface.
void HoldRenderer::hold(const TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  const Contact& contact = frame.contacts.contacts[0];
  const auto n = joints_;
  state_ = State{};
  state_.phase = kHolding;
  state_.normal = contact.normal;
  state_.obstacle = contact.obstacle;
  state_.reference.head(n) = k.q;
  state_.feedForward.head(n) = k.gravity;
  if (options_.release && contact.gap < 0.0) {
    Vec6 back = Vec6::Zero();
    const double step = std::min(-contact.gap, kMaxReferenceStep);
    state_.left = -contact.gap - step;
    back.head<3>() = step * contact.normal;
    state_.reference.head(n) += torqueOf(k.inverseTransposed, back);  // J^-1 times the motion back
  }
}

}  // namespace enamel
