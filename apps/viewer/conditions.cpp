#include "conditions.hpp"

#include <algorithm>
#include <cmath>

#include "hand.hpp"
#include "settings.hpp"

namespace enamel::viewer {

Delivered deliveredOf(const Vec3& force, const Contact& nearest) noexcept {
  const double normal = nearest.normal.dot(force);
  return {normal, (force - normal * nearest.normal).norm(), force.norm()};
}

Readout readoutOf(const TickRecord& record) noexcept {
  return {-record.nearest.gap, record.rendered.head<3>(), -record.nearest.normal.dot(record.handWrench.head<3>())};
}

const Readout& ReadoutFilter::add(const TickRecord& record) noexcept {
  const Readout now = readoutOf(record);
  const double passed = record.time - time_;
  time_ = record.time;
  const bool follows = passed > 0.0 && passed < kSmoothing && std::isfinite(now.depth - smooth_.depth);
  if (!follows || isFault(record.guard)) return smooth_ = now;
  const double share = 1.0 - std::exp(-passed / kSmoothing);
  smooth_.depth += share * (now.depth - smooth_.depth);
  smooth_.force += share * (now.force - smooth_.force);
  smooth_.hand += share * (now.hand - smooth_.hand);
  return smooth_;
}

const Conditions& ConditionWatch::add(const TickRecord& record, const JointVector& maxTorque) noexcept {
  const JointVector shares = record.torque.cwiseQuotient(maxTorque);
  const bool unstable = chatters(record, shares), slipped = slips(record);
  const bool now[] = {record.saturated || shares.cwiseAbs().maxCoeff() > 1.0 - 1e-6, unstable, slipped,
                      record.pose.position.cwiseAbs().maxCoeff() >= kStop};
  bool* const shown[] = {&conditions_.saturated, &conditions_.unstable, &conditions_.slipped, &conditions_.edge};
  for (std::size_t i = 0; i < shownFor_.size(); ++i) {
    shownFor_[i] = now[i] ? Conditions::kShown : std::max(0, shownFor_[i] - 1);
    *shown[i] = shownFor_[i] > 0;
  }
  return conditions_;
}

double ConditionWatch::forceRange() const noexcept {
  const Block& last = complete_.ticks > 0 ? complete_ : block_;
  return last.highForce - last.lowForce;
}

bool ConditionWatch::chatters(const TickRecord& record, const JointVector& shares) noexcept {
  constexpr double least = 0.25;  // standard deviation relative to the torque limit, as in ImpactMonitor
  const double force = deliveredOf(record).normal;
  if (block_.ticks == 0) {
    block_.lowForce = block_.highForce = force;
    block_.sum = block_.squares = JointVector::Zero(shares.size());
  }
  block_.lowForce = std::min(block_.lowForce, force);
  block_.highForce = std::max(block_.highForce, force);
  block_.sum += shares;
  block_.squares += shares.cwiseAbs2();
  bool unstable = record.guard == GuardReason::oscillation || record.guard == GuardReason::energy;
  if (++block_.ticks == kBlock) {
    const JointVector mean = block_.sum / kBlock;
    const bool now = (block_.squares / kBlock - mean.cwiseAbs2()).maxCoeff() > least * least;
    unstable = unstable || (now && chattered_);  // a single block may be an impact
    chattered_ = now;
    complete_ = block_;
    block_.ticks = 0;
  }
  return unstable;
}

bool ConditionWatch::slips(const TickRecord& record) noexcept {
  const Vec3 speed = record.twist.head<3>(), normal = record.nearest.normal;
  const double across = (speed - normal.dot(speed) * normal).norm();
  const bool slides =
      record.mode == RenderMode::contact && record.nearest.material.friction > 0.0 && across > Conditions::kSlip;
  slid_ = slides ? slid_ + kPeriod * across : 0.0;
  return slid_ > Conditions::kSlipPath;
}

}  // namespace enamel::viewer
