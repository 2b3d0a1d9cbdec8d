#include "enamel/study/metrics.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {

MetricsCollector::MetricsCollector(const PushSetup& setup) : setup_(setup) {
  const auto tickAt = [&setup](double time) {
    return static_cast<std::uint64_t>(std::llround(std::max(0.0, time) / setup.period));
  };
  onset_ = tickAt(1.0);
  steady_ = setup.person.scenario == 1 ? onset_ : tickAt(2.0);
  lastSecond_ = tickAt(setup.duration - 1.0);
  depths_.reserve(tickAt(setup.duration));
  torques_.reserve(tickAt(1.0) + 1);
}

void MetricsCollector::add(const TickRecord& tick) {
  const Vec3& normal = setup_.person.normal;
  const double depth = -tick.nearest.gap;
  const double velocity = normal.dot(tick.twist.head<3>());
  if (setup_.person.scenario == 1 && tick.tick > onset_ && !running_.firstDepth && depth > 0.0 && lastVelocity_ < 0.0 &&
      velocity >= 0.0) {
    running_.firstDepth = depth;
    running_.firstStiffness = -normal.dot(tick.person.head<3>()) / depth;
  }
  lastVelocity_ = velocity;

  const Vec3 force = tick.rendered.head<3>();
  if (tick.tick >= steady_) {
    depths_.push_back(depth);
    tangentialSquares_ += (force - normal.dot(force) * normal).squaredNorm();
  }
  if (tick.tick >= lastSecond_) torques_.push_back(tick.torque);
  const Vec3 moved = tick.pose.position - setup_.start.position;
  running_.drift = std::max(running_.drift, (moved - normal.dot(moved) * normal).norm());
  running_.largestDepth = std::max(running_.largestDepth, depth);
  running_.work += setup_.period * tick.rendered.dot(tick.twist);
  if (tick.status != Status::ok) ++running_.faults;
  if (tick.saturated) ++saturated_;
  ++ticks_;
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
    Vec6 mean = Vec6::Zero(), squares = Vec6::Zero();
    for (const Vec6& torque : torques_) mean += torque / count;
    for (const Vec6& torque : torques_) squares += (torque - mean).cwiseAbs2() / count;
    m.chatter = std::sqrt(squares.maxCoeff());
  }
  if (ticks_ > 0) m.saturatedShare = static_cast<double>(saturated_) / static_cast<double>(ticks_);
  return m;
}

}  // namespace enamel
