#include "enamel/render/impedance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"

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

  // Spring and damper are implicit in the motion of a movable obstacle, whose inverse mass is given.
  const auto share = [&](double stiffness, double inverse) {
    return 1.0 / (1.0 + (stiffness * period_ + options_.damping) * period_ * inverse);
  };
  const ContactYield& yield = frame.yield;
  std::array<bool, kMaxContacts> touches{};
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& contact = frame.contacts.contacts[i];
    const auto at = static_cast<std::size_t>(i);
    Vec3 velocity = contactVelocity(k, contact);
    double gap = predictedGap(frame, contact, period_), inverse = 0.0;
    if (yield.isAny) {
      inverse = yield.inverse[i][i];
      velocity += yield.velocity[at] - yield.after[at];
      gap -= period_ * contact.normal.dot(yield.after[at]);
    }
    const double compliance = 1.0 / options_.stiffness + 1.0 / contact.material.stiffness;  // stiffness 0: no force
    touches[at] = gap < 0.0;
    if (touches[at])
      output.normalForces[at] = share(1.0 / compliance, inverse) *
                                std::max(0.0, -gap / compliance - options_.damping * contact.normal.dot(velocity));
  }

  Vec6 wrench = Vec6::Zero();
  state_.friction.begin();
  output.mode = RenderMode::free;
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& contact = frame.contacts.contacts[i];
    const auto at = static_cast<std::size_t>(i);
    const Vec3 arm = contact.point - k.pose.position;
    Vec3 velocity = contactVelocity(k, contact), moves = frame.age * period_ * velocity;  // until the tick
    double across = 0.0;
    if (yield.isAny) {
      const Vec3 after = yield.afterUnder(output.normalForces, i, frame.contacts.count, period_);
      across = yield.across[at];
      velocity += yield.velocity[at] - after;
      moves -= period_ * after;
    }
    const SurfaceMotion slide{translationAt(way, arm) - elapsed * contact.obstacleVelocity, moves, velocity};
    const double held = share(options_.stiffness, across), force = output.normalForces[at];
    const TangentialGains gains{held * options_.stiffness, held * options_.damping};
    const Vec3 friction = state_.friction.force(contact, slide, gains, force);  // kept off the wall: it may touch again
    const Vec3 both = force * contact.normal + friction;
    wrench.head<3>() += both;
    wrench.tail<3>() += arm.cross(both);
    if (!touches[at]) continue;
    if (output.mode == RenderMode::free) output.normalForce = force;  // of the deepest contact
    output.mode = RenderMode::contact;
  }
  state_.friction.end();
  output.torque = staticTorque(k, wrench);
  return Status::ok;
}

}  // namespace enamel
