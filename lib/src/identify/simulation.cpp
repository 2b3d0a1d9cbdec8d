#include "identify/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/message.hpp"

namespace enamel::identify {
namespace {

const auto nothing = [](double, const Pose&, const Vec6&) noexcept { return Vec6(Vec6::Zero()); };

// The torque of the motors during one substep, from commands that are constant between ticks.
class Motors {
 public:
  Motors(const DeviceModel& model, const RecordedMotion& motion, Eigen::Index first)
      : motion_(motion),
        ratio_(torqueRatios(model)),
        lag_(model.lag),
        spread_(model.spread),
        whole_(static_cast<Eigen::Index>(std::floor(model.delay))),
        part_(model.delay - std::floor(model.delay)) {
    torque_ = commandAt(first);
  }

  // Mean torque from share `from` to share `to` of tick i, which takes `duration` s.
  JointVector mean(Eigen::Index i, double from, double to, double duration) {
    JointVector sum = JointVector::Zero(torque_.size());
    if (from < part_) move(commandAt(i - 1), (std::min(to, part_) - from) * duration, sum);
    if (to > part_) move(commandAt(i), (to - std::max(from, part_)) * duration, sum);
    return sum / ((to - from) * duration);
  }

 private:
  // Command that acts `whole_` ticks after tick i.
  JointVector commandAt(Eigen::Index i) const {
    JointVector sum = JointVector::Zero(ratio_.size());
    for (int k = 0; k <= spread_; ++k) sum += motion_.command.col(std::max<Eigen::Index>(0, i - whole_ - k));
    return (sum / (spread_ + 1.0)).cwiseProduct(ratio_);
  }

  void move(const JointVector& command, double duration, JointVector& sum) {
    if (lag_ <= 0.0) {
      torque_ = command;
      sum += duration * command;
      return;
    }
    const double share = -std::expm1(-duration / lag_);
    sum += duration * command + lag_ * share * (torque_ - command);
    torque_ += share * (command - torque_);
  }

  const RecordedMotion& motion_;
  JointVector ratio_, torque_;
  double lag_;
  int spread_;
  Eigen::Index whole_;
  double part_;
};

// The observer's torque; see Observer.
class Spring {
 public:
  Spring(const Observer& observer, double period) : observer_(observer), period_(period) { restart(); }

  void restart() { first_ = second_ = JointVector::Zero(observer_.stiffness.size()); }

  JointVector torque(const JointVector& error) {
    const double share = -std::expm1(-2.0 * M_PI * kObserverFilter * period_);
    const JointVector before = second_;
    first_ += share * (error - first_);
    second_ += share * (first_ - second_);
    return observer_.stiffness.cwiseProduct(second_) + observer_.damping.cwiseProduct(second_ - before) / period_;
  }

 private:
  const Observer& observer_;
  double period_;
  JointVector first_, second_;
};

// Put the plant at rest at a recorded reading. Returns the status of the kinematics.
Status startAt(const JointVector& reading, const DeviceModel& model, const ImperfectDevice& device, Plant& plant) {
  Kinematics there = device.mechanism->home();
  JointVector q = reading - device.offset;
  if (model.hasCables()) q -= device.mechanism->home().gravity / model.drive.cableStiffness;
  const Status status = device.mechanism->track(q, JointVector::Zero(q.size()), false, there);
  return status == Status::ok ? plant.start(there.pose) : status;
}

}  // namespace

Observer observerFor(const DeviceModel& model, double period) {
  const ImperfectDevice device = deviceOf(model);
  const double rate = 2.0 * M_PI * kObserverRate;
  JointVector inertia = device.mechanism->home().inertia.diagonal();
  Observer observer;
  if (model.hasCables()) {
    const double links = inertia.minCoeff();
    const double resonance = std::sqrt(model.drive.cableStiffness * (1.0 / device.rotorInertia + 1.0 / links));
    observer.substeps = std::clamp(static_cast<int>(std::ceil(resonance * period / 0.7)), 2, 8);
    inertia.array() += device.rotorInertia;
  }
  observer.stiffness = rate * rate * inertia;
  observer.damping = 2.0 * rate * inertia;
  return observer;
}

Simulated simulate(const DeviceModel& model, const RecordedMotion& motion, const Observer& observer,
                   Eigen::Index first, Eigen::Index count) {
  const ImperfectDevice device = deviceOf(model);
  const double step = 1.0 / observer.substeps;
  ImperfectPlant plant(device, 2.0 * motion.period);  // one step for each advance()
  require(startAt(motion.reading.col(first), model, device, plant) == Status::ok,
          "the recorded joints are out of the reach of \"" + nameOf(model.device) + "\"");
  Motors motors(model, motion, first);
  Spring spring(observer, motion.period);
  Simulated simulated;
  simulated.reading.resize(motion.reading.rows(), count);
  const Kinematics unused;
  JointVector reading, rates;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = first + k;
    plant.read(unused, reading, rates);
    simulated.reading.col(k) = reading;
    if (k + 1 == count) break;
    const JointVector held = spring.torque(motion.reading.col(i) - reading);
    const double begin = motion.time[static_cast<std::size_t>(i)];
    const double duration = motion.time[static_cast<std::size_t>(i + 1)] - begin;
    for (int s = 0; s < observer.substeps; ++s) {
      const JointVector torque = held + motors.mean(i, s * step, (s + 1) * step, duration);
      if (plant.advance(begin + s * step * duration, step * duration, torque, nothing) == Status::ok) continue;
      ++simulated.restarts;
      spring.restart();
      (void)startAt(motion.reading.col(i), model, device, plant);
    }
  }
  return simulated;
}

}  // namespace enamel::identify
