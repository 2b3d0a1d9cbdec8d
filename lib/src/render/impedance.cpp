#include "enamel/render/impedance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "enamel/render/compliance.hpp"

namespace enamel {
namespace {

void requireNotNegative(double value, const char* name, const char* unit) {
  require(value >= 0.0 && std::isfinite(value), std::string("impedance renderer: ") + name + " is " +
                                                    formatNumber(value) + ", must be at least 0 " + unit +
                                                    " and finite");
}

}  // namespace

double requiredDamping(const ImpedanceOptions& options, double period) noexcept {
  return 0.5 * options.stiffness * period + std::abs(options.damping);
}

ImpedanceRenderer::ImpedanceRenderer(const ImpedanceOptions& options) : options_(options) {
  requireNotNegative(options.stiffness, "stiffness", "N/m");
  requireNotNegative(options.damping, "damping", "N s/m");
}

void ImpedanceRenderer::stateLoaded() noexcept {
  if (!isFinite(stateBlock())) resetState();
}

Status ImpedanceRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& k = frame.kinematics;
  JointVector moved = JointVector::Zero(k.q.size());
  for (Eigen::Index i = 0; i < k.q.size(); ++i) {
    if (state_.started != 0.0) moved[i] = k.q[i] - state_.q[i];
    state_.q[i] = k.q[i];
  }
  const Vec6 way = twistOf(k.jacobian, moved);
  double elapsed = 0.0;  // between samples, s
  if (frame.age == 0) {
    if (state_.started != 0.0) elapsed = frame.time - state_.sampleTime;
    state_.sampleTime = frame.time;
    state_.started = 1.0;
  }

  const ContactYield& yield = frame.yield;
  // Spring and damper are implicit in the motion of a movable obstacle, whose inverse mass is given.
  const auto share = [&](double stiffness, double inverse) {
    return 1.0 / (1.0 + (stiffness * period_ + options_.damping) * period_ * inverse);
  };
  // Return the normal force; below 0: no contact.
  const auto pressAt = [&](int i, Vec3 velocity) {
    const Contact& contact = frame.contacts.contacts[i];
    double gap = predictedGap(frame, contact, period_), answers = 1.0;
    if (yield.isAny) {
      velocity += yield.velocity[i] - yield.after[i];
      gap -= period_ * contact.normal.dot(yield.after[i]);
    }
    if (!(gap < 0.0)) return -1.0;
    const double spring = 1.0 / options_.stiffness;  // stiffness 0: no force
    const double compliance = spring + softness(contact, -gap, spring, period_);
    if (yield.isAny) answers = share(1.0 / compliance, yield.inverse[i][i]);
    return answers * std::max(0.0, -gap / compliance - options_.damping * contact.normal.dot(velocity));
  };
  std::array<double, kMaxContacts> pressed;
  for (int i = 0; yield.isAny && i < frame.contacts.count; ++i) {
    pressed[i] = pressAt(i, contactVelocity(k, frame.contacts.contacts[i]));
    output.normalForces[i] = std::max(0.0, pressed[i]);
  }

  Vec6 wrench = Vec6::Zero();
  state_.friction.begin();
  output.mode = RenderMode::free;
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& contact = frame.contacts.contacts[i];
    const Vec3 arm = contact.point - k.pose.position;
    Vec3 velocity = contactVelocity(k, contact), moves = frame.age * period_ * velocity;  // until the tick
    const double force = yield.isAny ? pressed[i] : pressAt(i, velocity);
    TangentialGains gains{options_.stiffness, options_.damping};
    if (yield.isAny) {
      const Vec3 after = yield.afterUnder(output.normalForces, i, frame.contacts.count, period_);
      const double answers = share(options_.stiffness, yield.across[i]);
      gains = {answers * options_.stiffness, answers * options_.damping};
      velocity += yield.velocity[i] - after;
      moves -= period_ * after;
    }
    const SurfaceMotion slide{translationAt(way, arm) - elapsed * contact.obstacleVelocity, moves, velocity};
    if (force < 0.0 && !(contact.grip > 0.0)) {
      (void)state_.friction.force(contact, slide, gains, 0.0);  // keeps its friction state: it may touch again at once
      continue;
    }
    const double pushes = std::max(0.0, force);
    const Vec3 both = pushes * contact.normal + state_.friction.force(contact, slide, gains, pushes + contact.grip);
    wrench.head<3>() += both;
    wrench.tail<3>() += arm.cross(both);
    if (output.mode == RenderMode::free) output.normalForce = pushes;  // of the deepest contact
    output.normalForces[i] = pushes;
    output.mode = RenderMode::contact;
  }
  state_.friction.end();
  output.torque = staticTorque(k, wrench);
  return Status::ok;
}

}  // namespace enamel
