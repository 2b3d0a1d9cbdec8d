#include "enamel/study/metrics.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {

namespace {

constexpr double kRestWindow = 0.1;                // s before the onset
constexpr double kSettling = 0.5, kJudged = 0.25;  // s after the onset that do not count, and that at least must
constexpr double kRinging = 0.25;                  // of D_z1

std::uint64_t ticksIn(double time, double period) noexcept {
  return static_cast<std::uint64_t>(std::llround(time / period));
}

}  // namespace

const char* toString(FirstImpactVerdict verdict) noexcept {
  switch (verdict) {
    case FirstImpactVerdict::measured: return "measured";
    case FirstImpactVerdict::noStep: return "no step of force";
    case FirstImpactVerdict::noReturn: return "never returned";
    case FirstImpactVerdict::rings: return "rings";
    case FirstImpactVerdict::slips: return "slipped";
  }
  return "unknown verdict";
}

const std::array<Metric, kMetrics>& allMetrics() noexcept {
  using M = PushMetrics;
  static const std::array<Metric, kMetrics> metrics = {{
      {"D_z1", "first impact depth", "m", "mm", 1e3, &M::firstDepth},
      {"K_z1", "first impact stiffness", "N/m", "kN/m", 1e-3, &M::firstStiffness},
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

MetricsCollector::MetricsCollector(const PushSetup& setup) : setup_(setup), times_(timesOf(setup)) {
  depths_.reserve(times_.end);
  torques_.reserve(times_.end - times_.lastSecond + 1);
}

// Of each interval between two ticks; the force is held over it.
void MetricsCollector::watchImpact(const TickRecord& tick, double depth) {
  const Vec3& normal = setup_.person.normal;
  if (tick.tick <= times_.onset) {
    if (tick.tick + ticksIn(kRestWindow, setup_.period) >= times_.onset) {
      restSum_ += depth;
      ++restTicks_;
    }
    if (tick.tick == times_.onset) impact_ = FirstImpact(restTicks_ > 0 ? -restSum_ / restTicks_ : 0.0);
  } else if (impact_.add(lastGap_, lastRate_, tick.nearest.gap, tick.gapRate, setup_.period)) {
    running_.firstDepth = impact_.depth();
    running_.firstStiffness = lastForce_ / impact_.depth();
    slipped_ = running_.drift > impact_.depth();
  }
  lastGap_ = tick.nearest.gap;
  lastRate_ = tick.gapRate;
  lastForce_ = -normal.dot(tick.person.head<3>());
  if (tick.tick >= times_.onset + ticksIn(kSettling, setup_.period)) {
    lateSum_ += depth;
    lateSquares_ += depth * depth;
    lateSaturated_ += tick.saturated;
    ++lateTicks_;
  }
}

void MetricsCollector::add(const TickRecord& tick) {
  const Vec3& normal = setup_.person.normal;
  const double depth = -tick.nearest.gap;
  const Vec3 force = tick.rendered.head<3>();
  if (tick.tick >= times_.steady) {
    depths_.push_back(depth);
    tangentialSquares_ += (force - normal.dot(force) * normal).squaredNorm();
  }
  if (tick.tick >= times_.lastSecond) torques_.push_back(tick.torque);
  const Vec3 moved = tick.pose.position - setup_.start.position;
  running_.drift = std::max(running_.drift, (moved - normal.dot(moved) * normal).norm());
  running_.largestDepth = std::max(running_.largestDepth, depth);
  running_.work += setup_.period * tick.rendered.dot(tick.twist);
  if (tick.status != Status::ok) ++running_.faults;
  if (tick.saturated) ++saturated_;
  ++ticks_;
  if (setup_.person.scenario == 1) watchImpact(tick, depth);
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
    m.steadyCompliance = setup_.person.force > 0.0 ? m.steadyDepth / setup_.person.force : 0.0;
    m.rmsDepth = std::sqrt(squares / count);
    m.depth95 = sorted[static_cast<std::size_t>(rank)];
    m.tangentialForce = std::sqrt(tangentialSquares_ / count);
  }
  if (!torques_.empty()) {
    const double count = static_cast<double>(torques_.size());
    JointVector mean = JointVector::Zero(torques_.front().size()), squares = mean;
    for (const JointVector& torque : torques_) mean += torque / count;
    for (const JointVector& torque : torques_) squares += (torque - mean).cwiseAbs2() / count;
    m.chatter = std::sqrt(squares.maxCoeff());
  }
  if (ticks_ > 0) m.saturatedShare = static_cast<double>(saturated_) / static_cast<double>(ticks_);

  bool rings = false;
  if (m.firstDepth && lateTicks_ >= ticksIn(kJudged, setup_.period)) {
    const double count = static_cast<double>(lateTicks_), mean = lateSum_ / count;
    const double deviation = std::sqrt(std::max(0.0, lateSquares_ / count - mean * mean));
    rings = deviation > kRinging * *m.firstDepth || 2 * lateSaturated_ > lateTicks_;
  }
  m.verdict = setup_.person.scenario != 1 ? FirstImpactVerdict::noStep
              : !m.firstDepth             ? FirstImpactVerdict::noReturn
              : rings                     ? FirstImpactVerdict::rings
              : slipped_                  ? FirstImpactVerdict::slips
                                          : FirstImpactVerdict::measured;
  if (m.verdict != FirstImpactVerdict::measured) m.firstDepth = m.firstStiffness = std::nullopt;
  return m;
}

}  // namespace enamel
