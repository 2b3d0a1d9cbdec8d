#include "enamel/study/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enamel/control/tuning.hpp"

namespace enamel {

const std::array<Metric, kMetrics>& allMetrics() noexcept {
  using M = PushMetrics;
  static const std::array<Metric, kMetrics> metrics = {{
      {"D_z1", "first impact depth", "m", "mm", 1e3, &M::firstDepth},
      {"K_z1", "first impact stiffness", "N/m", "kN/m", 1e-3, &M::firstStiffness},
      {"K_d", "depth stiffness", "N/m", "kN/m", 1e-3, &M::depthStiffness},
      {"D_zs", "steady depth (signed mean)", "m", "mm", 1e3, &M::steadyDepth},
      {"C_zs", "steady compliance", "m/N", "mm/N", 1e3, &M::steadyCompliance},
      {"rms depth", "", "m", "mm", 1e3, &M::rmsDepth},
      {"depth 95 %", "", "m", "mm", 1e3, &M::depth95},
      {"largest depth", "", "m", "mm", 1e3, &M::largestDepth},
      {"chatter", "torque's standard deviation, last second", "N m", "N m", 1.0, &M::chatter},
      {"saturated share", "", "", "%", 100.0, &M::saturatedShare},
      {"tangential force", "rms", "N", "N", 1.0, &M::tangentialForce},
      {"work", "on the tool", "J", "J", 1.0, &M::work},
      {"drift", "across the normal", "m", "mm", 1e3, &M::drift},
      {"share of limit", "K_z1 over what physics allows", "", "%", 100.0, &M::limitShare},
      {"bounce", "largest gap above the rest", "m", "mm", 1e3, &M::bounce},
  }};
  return metrics;
}

std::size_t indexOf(const MetricMember& member) noexcept {
  std::size_t i = 0;
  while (i + 1 < kMetrics && allMetrics()[i].member != member) ++i;
  return i;
}

std::string keyOf(const Metric& metric) {
  return *metric.unit == 0 ? metric.symbol : std::string(metric.symbol) + " [" + metric.unit + "]";
}

std::optional<double> valueOf(const PushMetrics& metrics, const Metric& metric) noexcept {
  if (const auto* member = std::get_if<double PushMetrics::*>(&metric.member)) return metrics.**member;
  return metrics.*std::get<1>(metric.member);
}

double largestStiffness(const Mechanism& plant, const PushSetup& setup) {
  const HandModel& hand = setup.hand;
  Kinematics there;
  if (hand.scenario != 1 || plant.reach(setup.start, Vec6::Zero(), true, there) != Status::ok) return 0.0;
  const Vec3 grip = setup.start.position + setup.start.rotation * hand.grip;
  return firstImpactLimit(effectiveMass(there, grip, hand.normal), setup.period, setup.delay.high, hand.force,
                          largestForce(there, plant.limits().effort, grip, hand.normal), hand.preload);
}

MetricsCollector::MetricsCollector(const PushSetup& setup, double limit, JointVector maxTorque)
    : setup_(setup), limit_(limit), maxTorque_(std::move(maxTorque)), times_(timesOf(setup)), impact_(setup.period) {
  depths_.reserve(times_.end);
  torques_.reserve(times_.end - times_.lastSecond + 1);
}

void MetricsCollector::add(const TickRecord& tick) {
  const Vec3& normal = setup_.hand.normal;
  const double depth = -tick.nearest.gap;
  const Vec3 force = tick.rendered.head<3>();
  if (tick.tick >= times_.steady) {
    depths_.push_back(depth);
    tangentialSquares_ += (force - normal.dot(force) * normal).squaredNorm();
  }
  if (tick.tick >= times_.lastSecond) torques_.push_back(tick.torque);
  const Vec3 moved = tick.pose.position + tick.pose.rotation * setup_.hand.grip - setup_.start.position -
                     setup_.start.rotation * setup_.hand.grip;
  running_.drift = std::max(running_.drift, (moved - normal.dot(moved) * normal).norm());
  running_.largestDepth = std::max(running_.largestDepth, depth);
  running_.work += setup_.period * tick.rendered.dot(tick.twist);
  if (tick.status != Status::ok) ++running_.faults;
  if (tick.saturated) ++saturated_;
  stopped_ = stopped_ || isFault(tick.guard);
  ++ticks_;

  const ImpactTick impact{tick.nearest.gap,
                          tick.gapRate,
                          -normal.dot(tick.handWrench.head<3>()),
                          running_.drift,
                          tick.saturated,
                          maxTorque_.size() > 0 ? JointVector(tick.torque.cwiseQuotient(maxTorque_)) : JointVector()};
  const auto rest = static_cast<std::uint64_t>(std::llround(ImpactMonitor::kRestWindow / setup_.period));
  // The step does not cause a reversal in its own tick.
  const std::uint64_t pushed = times_.onset + (setup_.hand.instant > 0.0 ? 1 : 0);
  if (tick.tick >= pushed)
    impact_.push(impact);
  else if (tick.tick + rest >= times_.onset && tick.tick < times_.onset)
    impact_.rest(impact);
}

double chatterOf(const std::vector<JointVector>& torques) {
  if (torques.empty()) return 0.0;
  const double count = static_cast<double>(torques.size());
  JointVector mean = JointVector::Zero(torques.front().size()), squares = mean;
  for (const JointVector& torque : torques) mean += torque / count;
  for (const JointVector& torque : torques) squares += (torque - mean).cwiseAbs2() / count;
  return std::sqrt(squares.maxCoeff());
}

PushMetrics MetricsCollector::metrics() const {
  PushMetrics m = running_;
  if (!depths_.empty()) {
    const double count = static_cast<double>(depths_.size());
    std::vector<double> sorted = depths_;
    double sum = 0.0, squares = 0.0;
    for (double& depth : sorted) {
      sum += depth;
      squares += depth * depth;
      depth = std::abs(depth);
    }
    const auto rank = static_cast<std::ptrdiff_t>(0.95 * (count - 1.0));
    std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
    m.steadyDepth = sum / count;
    m.steadyCompliance = setup_.hand.force > 0.0 ? m.steadyDepth / setup_.hand.force : 0.0;
    m.rmsDepth = std::sqrt(squares / count);
    m.depth95 = sorted[static_cast<std::size_t>(rank)];
    m.tangentialForce = std::sqrt(tangentialSquares_ / count);
  }
  m.chatter = chatterOf(torques_);
  if (ticks_ > 0) m.saturatedShare = static_cast<double>(saturated_) / static_cast<double>(ticks_);

  m.bounce = impact_.bounce();
  if (setup_.hand.scenario == 1 && impact_.deepest() > 0.0) m.depthStiffness = setup_.hand.force / impact_.deepest();
  m.verdict = setup_.hand.scenario == 1 ? impact_.verdict() : FirstImpactVerdict::noStep;
  if (stopped_ || impact_.unstable()) m.verdict = FirstImpactVerdict::unstable;
  if (m.verdict == FirstImpactVerdict::measured) {
    m.firstDepth = impact_.depth();
    m.firstStiffness = impact_.stiffness();
    if (limit_ > 0.0) m.limitShare = impact_.stiffness() / limit_;
  }
  return m;
}

}  // namespace enamel
