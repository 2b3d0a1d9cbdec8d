#include "identify/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/LU>

#include "core/message.hpp"

namespace enamel::identify {
namespace {

constexpr int kSubsteps = 5;  // at least, in a tick

// The torque of the motors during one substep, from commands that are constant between ticks.
class Motors {
 public:
  Motors(const DeviceModel& model, const RecordedMotion& motion, Eigen::Index first)
      : motion_(motion),
        ratio_(torqueRatios(model)),
        step_(model.drive.torqueStep),
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
    for (int k = 0; k <= spread_; ++k) sum += rounded(motion_.command.col(std::max<Eigen::Index>(0, i - whole_ - k)));
    return (sum / (spread_ + 1.0)).cwiseProduct(ratio_);
  }

  // The amplifier rounds the command, not the sum with the observer's torque: a step there would hide derivatives.
  JointVector rounded(JointVector command) const {
    if (step_ > 0.0)
      for (double& c : command) c = step_ * std::nearbyint(c / step_);
    return command;
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
  double step_, lag_;  // N m, s
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

// The device in joint coordinates: the equations of ImperfectPlant (sim/imperfect_plant.hpp), with the mechanism's
// inertia and free acceleration constant during a tick. They are those of the middle of the tick.
class Device {
 public:
  explicit Device(const DeviceModel& model)
      : device_(deviceOf(model)),
        drive_(device_.imperfections),
        n_(device_.mechanism->joints()),
        kinematics_(device_.mechanism->home()),
        before_(kinematics_.jacobian) {}

  // Put the device at rest at a reading. Returns whether it reaches it.
  bool start(const JointVector& reading) {
    const double compliance = hasCables() ? 1.0 / drive_.cableStiffness : 0.0;
    JointVector q = reading - device_.offset - compliance * device_.mechanism->home().gravity;
    kinematics_ = device_.mechanism->home();
    if (device_.mechanism->track(q, JointVector::Zero(n_), false, kinematics_) != Status::ok) return false;
    before_ = kinematics_.jacobian;
    link_ = {q, JointVector::Zero(n_)};
    rotor_ = {q + compliance * kinematics_.gravity, JointVector::Zero(n_)};
    presliding_ = JointVector::Zero(n_);
    return true;
  }

  JointVector reading() const { return (hasCables() ? rotor_.angle : link_.angle) + device_.offset; }

  // Freeze inertia and free acceleration for a tick of `duration` s. Returns false if the mechanism cannot go there.
  bool beginTick(double duration) {
    const JointVector middle = link_.angle + 0.5 * duration * link_.rate, none = JointVector::Zero(n_);
    if (!(link_.rate.norm() < kFastest)) return false;
    if (device_.mechanism->track(middle, link_.rate, true, kinematics_) != Status::ok) return false;
    Vec6 free;
    if (device_.mechanism->accelerate(kinematics_.pose, kinematics_.twist, none, Vec6::Zero(), free) != Status::ok)
      return false;
    free -= (kinematics_.jacobian - before_) * link_.rate / duration;  // J' q'
    before_ = kinematics_.jacobian;
    falling_ = kinematics_.inverseTransposed.transpose() * free;
    mobility_ = kinematics_.inertia.inverse();
    return true;
  }

  // Move by `h` s under the torque of the motors.
  void move(double h, const JointVector& torque) {
    relax(0.5 * h);
    hasCables() ? moveWithCables(h, torque) : moveRigidly(h, torque);
    relax(0.5 * h);
  }

 private:
  struct Part {
    JointVector angle, rate;
  };

  bool hasCables() const noexcept { return drive_.cableStiffness > 0.0; }

  // Dahl's friction at constant speed, as ImperfectPlant.
  void relax(double h) {
    const JointVector& rate = hasCables() ? rotor_.rate : link_.rate;
    for (Eigen::Index i = 0; i < n_; ++i) {
      const double limit = std::copysign(1.0, rate[i]);
      presliding_[i] = limit + (presliding_[i] - limit) * std::exp(-std::abs(rate[i]) * h / kPresliding);
    }
  }

  double disturbed(Eigen::Index i, double torque, double angle) const {
    double sum = torque - device_.coulombFriction[i] * presliding_[i];
    if (drive_.periods > 0.0)
      sum += (drive_.torqueRipple * torque + device_.cogging[i]) * std::sin(drive_.periods * angle + device_.coggingPhase[i]);
    return sum;
  }

  // Second order in h: the speed is linear, the torque that of the middle.
  void moveRigidly(double h, const JointVector& torque) {
    JointVector sum(n_);
    for (Eigen::Index i = 0; i < n_; ++i) sum[i] = disturbed(i, torque[i], link_.angle[i] + 0.5 * h * link_.rate[i]);
    const JointVector acceleration = falling_ + mobility_ * sum;
    link_.angle += h * link_.rate + 0.5 * h * h * acceleration;
    link_.rate += h * acceleration;
  }

  // Kutta's step for rotors, cables and links.
  void moveWithCables(double h, const JointVector& torque) {
    JointVector motor(n_);
    for (Eigen::Index i = 0; i < n_; ++i) motor[i] = disturbed(i, torque[i], rotor_.angle[i] + 0.5 * h * rotor_.rate[i]);
    Part link = link_, rotor = rotor_, linkSum{link_.rate, JointVector::Zero(n_)}, rotorSum{rotor_.rate, linkSum.rate};
    linkSum.angle.setZero();
    rotorSum.angle.setZero();
    const double weights[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, ahead[3] = {0.5, 0.5, 1.0};
    for (int stage = 0; stage < 4; ++stage) {
      const JointVector cable = drive_.cableStiffness * (rotor.angle - link.angle) + drive_.cableDamping * (rotor.rate - link.rate);
      const JointVector pushed = falling_ + mobility_ * cable, turned = (motor - cable) / device_.rotorInertia;
      linkSum.angle += weights[stage] * link.rate;
      linkSum.rate += weights[stage] * pushed;
      rotorSum.angle += weights[stage] * rotor.rate;
      rotorSum.rate += weights[stage] * turned;
      if (stage == 3) break;
      const double step = ahead[stage] * h;
      const JointVector linkRate = link.rate, rotorRate = rotor.rate;
      link = {link_.angle + step * linkRate, link_.rate + step * pushed};
      rotor = {rotor_.angle + step * rotorRate, rotor_.rate + step * turned};
    }
    link_.angle += h * linkSum.angle;
    link_.rate += h * linkSum.rate;
    rotor_.angle += h * rotorSum.angle;
    rotor_.rate += h * rotorSum.rate;
  }

  static constexpr double kPresliding = 2e-4;  // rad or m, of Dahl's friction, as ImperfectPlant
  static constexpr double kFastest = 1e3;      // rad/s or m/s

  ImperfectDevice device_;
  const Imperfections& drive_;
  Eigen::Index n_;
  Kinematics kinematics_;  // at the middle of the tick
  Jacobian before_;        // J at the middle of the tick before
  JointVector falling_;    // accelerations of the links without torque
  JointMatrix mobility_;   // M^-1
  Part link_, rotor_;
  JointVector presliding_;  // share of the friction, -1 to 1
};

}  // namespace

Observer observerFor(const DeviceModel& model, double period) {
  const ImperfectDevice device = deviceOf(model);
  const double rate = 2.0 * M_PI * kObserverRate;
  JointVector inertia = device.mechanism->home().inertia.diagonal();
  Observer observer;
  if (model.hasCables()) {
    const double links = inertia.minCoeff();
    const double resonance = std::sqrt(model.drive.cableStiffness * (1.0 / device.rotorInertia + 1.0 / links));
    observer.substeps = std::clamp(static_cast<int>(std::ceil(resonance * period / 0.3)), kSubsteps, 20);
    inertia.array() += device.rotorInertia;
  }
  observer.stiffness = rate * rate * inertia;
  observer.damping = 2.0 * rate * inertia;
  return observer;
}

Simulated simulate(const DeviceModel& model, const RecordedMotion& motion, const Observer& observer,
                   Eigen::Index first, Eigen::Index count) {
  Device device(model);
  require(device.start(motion.reading.col(first)),
          "the recorded joints are out of the reach of \"" + nameOf(model.device) + "\"");
  const double step = 1.0 / observer.substeps;
  Motors motors(model, motion, first);
  Spring spring(observer, motion.period);
  Simulated simulated;
  simulated.reading.resize(motion.reading.rows(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = first + k;
    simulated.reading.col(k) = device.reading();
    if (k + 1 == count) break;
    const JointVector held = spring.torque(motion.reading.col(i) - device.reading());
    const auto at = static_cast<std::size_t>(i);
    const double duration = motion.time[at + 1] - motion.time[at];
    const bool isPossible = device.beginTick(duration);
    for (int s = 0; s < observer.substeps; ++s) {
      const JointVector torque = held + motors.mean(i, s * step, (s + 1) * step, duration);
      if (isPossible) device.move(step * duration, torque);
    }
    if (isPossible) continue;
    ++simulated.restarts;
    spring.restart();
    (void)device.start(motion.reading.col(i));
  }
  return simulated;
}

}  // namespace enamel::identify
