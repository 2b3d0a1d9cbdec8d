#include "identify/simulation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/message.hpp"
#include "identify/local_dynamics.hpp"

namespace enamel::identify {
namespace {

constexpr int kSubsteps = 5;    // at least, in a tick
constexpr int kSlopeTicks = 4;  // between derivatives of the dynamics, with one place in a tick

// The torque of the motors, from commands that are constant between ticks.
template <int N>
class Motors {
 public:
  using Vector = Eigen::Matrix<double, N, 1, 0, N == Eigen::Dynamic ? kMaxJoints : N, 1>;

  Motors(const DeviceModel& model, const RecordedMotion& motion, Eigen::Index first)
      : motion_(motion),
        ratio_(torqueRatios(model)),
        step_(model.drive.torqueStep),
        lag_(model.lag),
        spread_(model.spread),
        whole_(static_cast<Eigen::Index>(std::floor(model.delay))),
        part_(model.delay - std::floor(model.delay)),
        now_(commandAt(first - 1)),
        torque_(now_) {}

  // Begin tick i, which has `substeps` parts of `length` s.
  void beginTick(Eigen::Index i, double length) {
    before_ = now_;
    now_ = commandAt(i);
    length_ = length;
    share_ = lag_ > 0.0 ? -std::expm1(-length / lag_) : 1.0;
  }

  // Mean torque from share `from` to share `to` of the tick: one part of it.
  Vector mean(double from, double to) {
    Vector sum = Vector::Zero(torque_.size());
    if (from >= part_ || to <= part_) {
      move(from >= part_ ? now_ : before_, length_, share_, sum);
    } else {
      const double first = (part_ - from) / (to - from) * length_, second = length_ - first;
      move(before_, first, lag_ > 0.0 ? -std::expm1(-first / lag_) : 1.0, sum);
      move(now_, second, lag_ > 0.0 ? -std::expm1(-second / lag_) : 1.0, sum);
    }
    return sum / length_;
  }

 private:
  // Command that acts `whole_` ticks after tick i. The amplifier rounds the command, not the sum with the observer's
  // torque: a step there would hide derivatives.
  Vector commandAt(Eigen::Index i) const {
    Vector sum = Vector::Zero(ratio_.size());
    for (int k = 0; k <= spread_; ++k) {
      Vector command = motion_.command.col(std::max<Eigen::Index>(0, i - whole_ - k));
      if (step_ > 0.0)
        for (double& c : command) c = step_ * std::nearbyint(c / step_);
      sum += command;
    }
    return (sum / (spread_ + 1.0)).cwiseProduct(ratio_);
  }

  void move(const Vector& command, double duration, double share, Vector& sum) {
    sum += duration * command + lag_ * share * (torque_ - command);
    torque_ += share * (command - torque_);
  }

  const RecordedMotion& motion_;
  Vector ratio_;
  double step_, lag_;  // N m, s
  int spread_;
  Eigen::Index whole_;
  double part_;
  Vector now_, before_, torque_;
  double length_ = 0.0, share_ = 0.0;  // s; how far the lag follows in that time
};

// The observer's torque; see Observer.
template <typename Vector>
class Spring {
 public:
  Spring(const Observer& observer, double period)
      : stiffness_(observer.stiffness),
        damping_(observer.damping / period),
        share_(-std::expm1(-2.0 * M_PI * kObserverFilter * period)) {
    restart();
  }

  void restart() { first_ = second_ = Vector::Zero(stiffness_.size()); }

  Vector torque(const Vector& error) {
    const Vector before = second_;
    first_ += share_ * (error - first_);
    second_ += share_ * (first_ - second_);
    return stiffness_.cwiseProduct(second_) + damping_.cwiseProduct(second_ - before);
  }

 private:
  Vector stiffness_, damping_;
  double share_;
  Vector first_, second_;
};

// The device in joint coordinates: the equations of ImperfectPlant (sim/imperfect_plant.hpp), with the mechanism's
// inertia and free acceleration constant during a part of a tick. They are those of its middle, by derivatives at a
// place near it (local_dynamics.hpp).
template <int N>
class Device {
 public:
  using Vector = typename Motors<N>::Vector;
  using Matrix =
      Eigen::Matrix<double, N, N, 0, N == Eigen::Dynamic ? kMaxJoints : N, N == Eigen::Dynamic ? kMaxJoints : N>;

  explicit Device(const DeviceModel& model)
      : device_(deviceOf(model)),
        drive_(device_.imperfections),
        n_(device_.mechanism->joints()),
        viscous_(viscousFriction(model)),
        friction_(device_.coulombFriction),
        cogging_(device_.cogging),
        phase_(device_.coggingPhase),
        hasCogging_(drive_.periods > 0.0 && (drive_.torqueRipple > 0.0 || cogging_.maxCoeff() > 0.0)),
        kinematics_(device_.mechanism->home()) {}

  // Put the device at rest at a reading. Returns whether it reaches it.
  bool start(const JointVector& reading) {
    const double compliance = hasCables() ? 1.0 / drive_.cableStiffness : 0.0;
    JointVector q = reading - device_.offset - compliance * device_.mechanism->home().gravity;
    kinematics_ = device_.mechanism->home();
    if (device_.mechanism->track(q, JointVector::Zero(n_), false, kinematics_) != Status::ok) return false;
    link_ = {q, Vector::Zero(n_)};
    acceleration_ = link_.rate;
    rotor_ = {q + compliance * kinematics_.gravity, Vector::Zero(n_)};
    presliding_ = Vector::Zero(n_);
    return true;
  }

  Vector reading() const { return (hasCables() ? rotor_.angle : link_.angle) + device_.offset; }

  // Compute the dynamics at a place: in the middle of the next `duration` s, if the acceleration continues. With
  // `isKnot` also their derivatives. Returns false if the mechanism cannot go there.
  bool beginPlace(double duration, bool isKnot) {
    if (!(link_.rate.norm() < kFastest)) return false;
    const JointVector rates = link_.rate + 0.5 * duration * acceleration_,
                      middle = link_.angle + 0.25 * duration * (link_.rate + rates);
    if (dynamicsAt(*device_.mechanism, middle, rates, kinematics_, near_) != Status::ok) return false;
    mobilityThere_ = near_.mobility;
    if (isKnot) {
      const DynamicsSlopes slopes = slopesAt(*device_.mechanism, kinematics_);
      for (std::size_t i = 0; i < slopes.inertia.size(); ++i) inertiaSlopes_[i] = slopes.inertia[i];
      gravitySlopes_ = slopes.gravity;
    }
    Matrix pushed(n_, n_);
    balance_ = near_.balance - coriolis(near_.rates, pushed);
    return true;
  }

  // Freeze inertia and free acceleration for a part of a tick, `duration` s. They are those of its middle, if the
  // acceleration continues.
  void beginPart(double duration) {
    const Vector rate = link_.rate + 0.5 * duration * acceleration_;
    const Vector away = link_.angle + 0.25 * duration * (link_.rate + rate) - near_.place;
    Matrix change = Matrix::Zero(n_, n_), pushed(n_, n_);
    for (Eigen::Index k = 0; k < n_; ++k) change += away[k] * inertiaSlopes_[static_cast<std::size_t>(k)];
    mobility_ = mobilityThere_ - mobilityThere_ * (change * mobilityThere_);
    falling_ = -(mobility_ * (balance_ + gravitySlopes_ * away + coriolis(rate, pushed)));
    if (!hasCogging_) return;
    begin_ = hasCables() ? rotor_.angle : link_.angle;
    const Vector phase = drive_.periods * begin_ + phase_;
    sine_ = phase.array().sin();
    cosine_ = phase.array().cos();
  }

  // Move by `h` s under the torque of the motors. Friction has half a step before and after; two halves that meet are
  // one step.
  void move(double h, const Vector& torque, bool isFirst, bool isLast) {
    if (isFirst) relax(0.5 * h);
    hasCables() ? moveWithCables(h, torque) : moveRigidly(h, torque);
    relax(isLast ? 0.5 * h : h);
  }

 private:
  struct Part {
    Vector angle, rate;
  };

  // Coriolis and centrifugal torque. Column k of `pushed` becomes dM/dq_k q'.
  Vector coriolis(const Vector& rate, Matrix& pushed) const {
    for (Eigen::Index k = 0; k < n_; ++k) pushed.col(k).noalias() = inertiaSlopes_[static_cast<std::size_t>(k)] * rate;
    return pushed * rate - 0.5 * pushed.transpose() * rate;
  }

  bool hasCables() const noexcept { return drive_.cableStiffness > 0.0; }

  // Dahl's friction at constant speed, as ImperfectPlant.
  void relax(double h) {
    const Vector& rate = hasCables() ? rotor_.rate : link_.rate;
    for (Eigen::Index i = 0; i < n_; ++i) {
      const double limit = std::copysign(1.0, rate[i]);
      presliding_[i] = limit + (presliding_[i] - limit) * std::exp(-std::abs(rate[i]) * h / kPresliding);
    }
  }

  double disturbed(Eigen::Index i, double torque, double angle) const {
    double sum = torque - friction_[i] * presliding_[i];
    if (hasCogging_) {  // sine of the angle by a series about the beginning of the part
      const double d = drive_.periods * (angle - begin_[i]), square = d * d;
      const double sine = sine_[i] * (1.0 - square * (0.5 - square / 24.0)) +
                          cosine_[i] * d * (1.0 - square * (1.0 / 6.0 - square / 120.0));
      sum += (drive_.torqueRipple * torque + cogging_[i]) * sine;
    }
    return sum;
  }

  // Second order in h: the speed is linear, the torque that of the middle.
  void moveRigidly(double h, const Vector& torque) {
    Vector sum(n_);
    for (Eigen::Index i = 0; i < n_; ++i)
      sum[i] = disturbed(i, torque[i], link_.angle[i] + 0.5 * h * link_.rate[i]) - viscous_[i] * link_.rate[i];
    Vector acceleration = falling_ + mobility_ * sum;
    acceleration -= mobility_ * (0.5 * h * viscous_.cwiseProduct(acceleration));  // viscous friction of the middle
    acceleration_ = acceleration;
    link_.angle += h * link_.rate + 0.5 * h * h * acceleration;
    link_.rate += h * acceleration;
  }

  // Kutta's step for rotors, cables and links.
  void moveWithCables(double h, const Vector& torque) {
    Vector motor(n_);
    for (Eigen::Index i = 0; i < n_; ++i)
      motor[i] = disturbed(i, torque[i], rotor_.angle[i] + 0.5 * h * rotor_.rate[i]);
    Part link = link_, rotor = rotor_, linkSum{link_.rate, Vector::Zero(n_)}, rotorSum{rotor_.rate, linkSum.rate};
    linkSum.angle.setZero();
    rotorSum.angle.setZero();
    const double weights[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, ahead[3] = {0.5, 0.5, 1.0};
    for (int stage = 0; stage < 4; ++stage) {
      const Vector cable =
          drive_.cableStiffness * (rotor.angle - link.angle) + drive_.cableDamping * (rotor.rate - link.rate);
      const Vector pushed = falling_ + mobility_ * (cable - viscous_.cwiseProduct(link.rate)),
                   turned = (motor - cable) / device_.rotorInertia;
      linkSum.angle += weights[stage] * link.rate;
      linkSum.rate += weights[stage] * pushed;
      rotorSum.angle += weights[stage] * rotor.rate;
      rotorSum.rate += weights[stage] * turned;
      acceleration_ = pushed;
      if (stage == 3) break;
      const double step = ahead[stage] * h;
      const Vector linkRate = link.rate, rotorRate = rotor.rate;
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
  Vector viscous_, friction_, cogging_, phase_;
  Vector begin_, sine_, cosine_;  // angle at the beginning of the part, and sine and cosine of its cogging
  bool hasCogging_;
  Kinematics kinematics_;  // at the last place
  LocalDynamics near_;     // there
  Vector balance_;         // of near_, without the torque of its velocities
  Matrix mobilityThere_, gravitySlopes_;
  std::array<Matrix, N == Eigen::Dynamic ? kMaxJoints : N> inertiaSlopes_;
  Vector acceleration_;  // of the links in the last step
  Vector falling_;       // accelerations of the links without torque
  Matrix mobility_;      // M^-1
  Part link_, rotor_;
  Vector presliding_;  // share of the friction, -1 to 1
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

namespace {

template <int N>
Simulated simulateJoints(const DeviceModel& model, const RecordedMotion& motion, const Observer& observer,
                         Eigen::Index first, Eigen::Index count) {
  using Vector = typename Motors<N>::Vector;
  Device<N> device(model);
  require(device.start(motion.reading.col(first)),
          "the recorded joints are out of the reach of \"" + nameOf(model.device) + "\"");
  const double step = 1.0 / observer.substeps;
  const int part = observer.substeps / observer.parts, place = observer.substeps / observer.places;
  const int knot = observer.places > 1 ? 1 : kSlopeTicks;
  Motors<N> motors(model, motion, first);
  Spring<Vector> spring(observer, motion.period);
  Simulated simulated;
  simulated.reading.resize(motion.reading.rows(), count);
  Vector error = Vector::Zero(motion.reading.rows());
  bool isNew = true;  // at the beginning, and after a restart
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = first + k;
    simulated.reading.col(k) = device.reading();
    if (k + 1 == count) break;
    const auto at = static_cast<std::size_t>(i);
    // Without a sample the last error holds: that of an interpolated reading grows with the acceleration.
    if (motion.isSample[at] != 0) error = motion.reading.col(i) - device.reading();
    const Vector held = spring.torque(error);
    const double duration = motion.time[at + 1] - motion.time[at];
    bool isPossible = true;
    motors.beginTick(i, step * duration);
    for (int s = 0; s < observer.substeps; ++s) {
      const Vector torque = held + motors.mean(s * step, (s + 1) * step);
      if (s % place == 0)
        isPossible = isPossible && device.beginPlace(place * step * duration, isNew || (s == 0 && k % knot == 0));
      if (!isPossible) continue;
      if (s % part == 0) device.beginPart(part * step * duration);
      device.move(step * duration, torque, s == 0, s + 1 == observer.substeps);
      isNew = false;
    }
    if (isPossible) continue;
    isNew = true;
    ++simulated.restarts;
    spring.restart();
    error.setZero();
    (void)device.start(motion.reading.col(i));
  }
  return simulated;
}

}  // namespace

Simulated simulate(const DeviceModel& model, const RecordedMotion& motion, const Observer& observer, Eigen::Index first,
                   Eigen::Index count) {
  switch (motion.reading.rows()) {
    case 3: return simulateJoints<3>(model, motion, observer, first, count);
    case 6: return simulateJoints<6>(model, motion, observer, first, count);
    default: return simulateJoints<Eigen::Dynamic>(model, motion, observer, first, count);
  }
}

}  // namespace enamel::identify
