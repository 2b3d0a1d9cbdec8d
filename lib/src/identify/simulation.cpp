#include "identify/simulation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace enamel::identify {
namespace {

constexpr int kSubsteps = 5;     // at least, in a tick
constexpr double kKnots = 4e-3;  // s, between knots of the path's dynamics

// Derivatives with respect to the parameters of a simulation, a column each.
template <int N>
using Lanes = Eigen::Matrix<double, N, kLanes, Eigen::RowMajor>;

// The torque of the motors, from commands that are constant between ticks.
template <int N>
class Motors {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  Motors(const DeviceModel& model, const RecordedMotion& motion, Eigen::Index first)
      : motion_(motion),
        ratio_(torqueRatios(model)),
        step_(model.drive.torqueStep),
        lag_(model.lag),
        spread_(model.spread),
        whole_(static_cast<Eigen::Index>(std::floor(model.delay))),
        part_(model.delay - std::floor(model.delay)),
        now_(commandAt(first - 1)),
        before_(now_),
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
    Vector sum = Vector::Zero();
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
    Vector sum = Vector::Zero();
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

// The observer's torque; see Observer. A column for each error.
template <typename Errors>
class Spring {
 public:
  Spring(const Observer& observer, double period)
      : stiffness_(kRate * kRate * observer.inertia),
        damping_(2.0 * kRate / period * observer.inertia),
        share_(-std::expm1(-2.0 * M_PI * kObserverFilter * period)) {
    restart();
  }

  void restart() { first_ = second_ = Errors::Zero(); }

  Errors torque(const Errors& error) {
    const Errors before = second_;
    first_ += share_ * (error - first_);
    second_ += share_ * (first_ - second_);
    return stiffness_.lazyProduct(second_) + damping_.lazyProduct(second_ - before);
  }

 private:
  static constexpr double kRate = 2.0 * M_PI * kObserverRate;  // rad/s

  Eigen::Matrix<double, Errors::RowsAtCompileTime, Errors::RowsAtCompileTime> stiffness_, damping_;
  double share_;
  Errors first_, second_;
};

// The numbers of the drives: parts of a number for each joint, and four that all joints share.
enum JointPart { kViscous, kFriction, kSine, kCosine, kRippleSine, kRippleCosine, kOffset, kJointParts };
enum Common { kPeriods, kStiffness, kDamping, kRotor, kCommons };

Eigen::VectorXd numbersOf(const DeviceModel& model) {
  const ImperfectDevice device = deviceOf(model);
  const Eigen::Index joints = model.sine.size();
  JointVector sine = JointVector::Constant(joints, model.drive.torqueRipple), cosine = JointVector::Zero(joints);
  for (Eigen::Index i = 0; i < sine.size(); ++i) {
    const double amplitude = std::hypot(model.sine[i], model.cosine[i]);  // the ripple has the phase of the cogging
    if (amplitude == 0.0) continue;
    cosine[i] = sine[i] * model.cosine[i] / amplitude;
    sine[i] *= model.sine[i] / amplitude;
  }
  Eigen::VectorXd numbers(kJointParts * sine.size() + kCommons);
  numbers << viscousFriction(model), model.coulomb, model.sine, model.cosine, sine, cosine, device.offset,
      model.drive.periods, model.drive.cableStiffness, model.drive.cableDamping, device.rotorInertia;
  return numbers;
}

// The device in joint coordinates: the equations of ImperfectPlant (sim/imperfect_plant.hpp), with the mechanism's
// inertia and free acceleration constant during a part of a tick. They are those of its middle. The slopes follow the
// same steps, linearised.
template <int N>
class Device {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Slopes = Lanes<N>;

  Device(const DeviceModel& model, const PathDynamics& path, const std::vector<ModelChange>& changes)
      : numbers_(numbersOf(model)),
        path_(path),
        changes_(changes),
        platform_(isPlatformDamped(model) ? deviceOf(model).mechanism : nullptr),
        hasCogging_(common(kPeriods) > 0.0 && numbers_.template segment<4 * N>(kSine * N).cwiseAbs().maxCoeff() > 0.0) {
    for (std::size_t lane = 0; lane < changes.size(); ++lane)
      changed_.col(static_cast<Eigen::Index>(lane)) =
          (numbersOf(changes[lane].after) - numbersOf(changes[lane].before)) / changes[lane].width;
  }

  // Put the device at rest at the reading of a tick.
  void start(const Vector& reading, double tick) {
    near_.interpolate(path_, tick);
    near_.moveTo(Vector::Zero());
    rotor_ = link_ = {reading - part(kOffset), Vector::Zero()};
    if (hasCables()) link_.angle -= near_.gravity() / common(kStiffness);
    presliding_ = acceleration_ = Vector::Zero();
    linkSlopes_ = rotorSlopes_ = {-changed(kOffset), Slopes::Zero()};
    preslidingSlopes_ = Slopes::Zero();
  }

  Vector reading() const { return (hasCables() ? rotor_ : link_).angle + part(kOffset); }
  const Vector& joints() const { return link_.angle; }
  Slopes readingSlopes() const { return (hasCables() ? rotorSlopes_ : linkSlopes_).angle + changed(kOffset); }

  // Freeze inertia and free acceleration for a part of a tick, `duration` s. They are those of its middle, `tick` ticks
  // after the beginning of the path, if the acceleration continues. Returns false if the device is out of reach.
  bool beginPart(double tick, double duration) {
    const Vector rate = link_.rate + 0.5 * duration * acceleration_;
    if (!(rate.norm() < kFastest)) return false;
    near_.interpolate(path_, tick);
    const Vector away = link_.angle + 0.25 * duration * (link_.rate + rate) - near_.place();
    near_.moveTo(away);
    const Eigen::LLT<Matrix> factor(near_.inertia());
    if (factor.info() != Eigen::Success) return false;
    mobility_ = factor.solve(Matrix::Identity());
    // C(v) is quadratic: C(v) = C(rate) + turning (v - rate), and turning rate = 2 C(rate).
    Matrix pushed = Matrix::Zero();
    const Vector bias = near_.bias(rate, pushed);
    damping_ = pushed - pushed.transpose();
    for (int k = 0; k < N; ++k) damping_ += rate[k] * near_.inertiaSlope(k);
    falling_ = -(mobility_ * (bias - damping_ * rate));
    if (platform_ != nullptr) {
      if (platform_->track(near_.place() + away, rate, false, kinematics_) != Status::ok) return false;
      damped_ = kinematics_.jacobian.template topRows<N>();
    }
    damping_ += damped_.transpose() * part(kViscous).asDiagonal() * damped_;
    if (!changes_.empty()) beginSlopes(tick, duration, rate, away);
    if (!hasCogging_) return true;
    begin_ = (hasCables() ? rotor_ : link_).angle;
    const Vector phase = common(kPeriods) * (begin_ + part(kOffset));
    sine_ = phase.array().sin();
    cosine_ = phase.array().cos();
    return true;
  }

  // Move by `h` s under the torque of the motors. Friction has half a step before and after; two halves that meet are
  // one step.
  void move(double h, const Vector& torque, const Slopes& torqueSlopes, bool isFirst, bool isLast) {
    if (isFirst) relax(0.5 * h);
    const Vector motor = disturbed(h, torque, torqueSlopes);
    hasCables() ? moveWithCables(h, motor) : moveRigidly(h, motor);
    relax(isLast ? 0.5 * h : h);
  }

 private:
  template <typename Value>
  struct Part {
    Value angle = Value::Zero(), rate = Value::Zero();
  };

  auto part(JointPart i) const { return numbers_.template segment<N>(N * i); }
  double common(Common i) const { return numbers_[N * kJointParts + i]; }
  auto changed(JointPart i) const { return changed_.template middleRows<N>(N * i); }
  auto changed(Common i) const { return changed_.row(N * kJointParts + i); }
  auto inertiaChange(std::size_t lane) { return inertiaChanges_.template middleCols<N>(N * static_cast<int>(lane)); }
  bool hasCables() const noexcept { return common(kStiffness) > 0.0; }
  // The damping of a Cartesian device opposes the turning of the platform, not the rates of its rotation vector.
  static bool isPlatformDamped(const DeviceModel& model) {
    return N == 6 && std::holds_alternative<CartesianParameters>(model.device);
  }
  Slopes viscousSlopes(const Vector& rate) const {
    const Matrix torques = damped_.transpose() * Vector(damped_ * rate).asDiagonal();
    return torques.lazyProduct(changed(kViscous));
  }

  void beginSlopes(double tick, double duration, const Vector& rate, const Vector& away) {
    awaySlopes_ = linkSlopes_.angle + 0.5 * duration * linkSlopes_.rate;
    Matrix gravity = Matrix::Zero();
    for (int k = 0; k < N; ++k) gravity.col(k) = near_.gravitySlope(k);
    biasSlopes_ = gravity.lazyProduct(awaySlopes_);
    for (std::size_t lane = 0; lane < changes_.size(); ++lane) {
      if (changes_[lane].path == nullptr) continue;
      PlaceDynamics<N> change;
      change.interpolate(*changes_[lane].path, tick);
      change.moveTo(away);
      Matrix unused = Matrix::Zero();
      biasSlopes_.col(static_cast<Eigen::Index>(lane)) += change.bias(rate, unused);
      inertiaChange(lane) = change.inertia();
    }
  }

  // Slopes of the torque that moves the links with an acceleration.
  Slopes inertialSlopes(const Vector& acceleration) {
    Matrix away = Matrix::Zero();
    for (int k = 0; k < N; ++k) away.col(k).noalias() = near_.inertiaSlope(k) * acceleration;
    Slopes slopes = biasSlopes_ + away.lazyProduct(awaySlopes_);
    for (std::size_t lane = 0; lane < changes_.size(); ++lane)
      if (changes_[lane].path != nullptr)
        slopes.col(static_cast<Eigen::Index>(lane)) += inertiaChange(lane) * acceleration;
    return slopes;
  }

  // Dahl's friction at constant speed, as ImperfectPlant.
  void relax(double h) {
    const Vector& rate = (hasCables() ? rotor_ : link_).rate;
    const Slopes& rateSlopes = (hasCables() ? rotorSlopes_ : linkSlopes_).rate;
    for (int i = 0; i < N; ++i) {
      const double limit = std::copysign(1.0, rate[i]), length = h / kPresliding;
      const double decay = std::exp(-std::abs(rate[i]) * length), away = decay * (presliding_[i] - limit);
      presliding_[i] = limit + away;
      if (!changes_.empty())
        preslidingSlopes_.row(i) = decay * preslidingSlopes_.row(i) - away * limit * length * rateSlopes.row(i);
    }
  }

  // Torque of the motors in the middle of a step, minus friction.
  Vector disturbed(double h, const Vector& torque, const Slopes& torqueSlopes) {
    const auto& driven = hasCables() ? rotor_ : link_;
    const auto& drivenSlopes = hasCables() ? rotorSlopes_ : linkSlopes_;
    Vector motor = torque - part(kFriction).cwiseProduct(presliding_);
    for (int i = 0; i < N; ++i) {
      double sine = 0.0, cosine = 0.0;
      const double angle = driven.angle[i] + 0.5 * h * driven.rate[i], periods = common(kPeriods);
      if (hasCogging_) {  // by a series about the beginning of the part
        const double d = periods * (angle - begin_[i]), square = d * d;
        const double c = 1.0 - square * (0.5 - square / 24.0), s = d * (1.0 - square * (1.0 / 6.0 - square / 120.0));
        sine = sine_[i] * c + cosine_[i] * s;
        cosine = cosine_[i] * c - sine_[i] * s;
      }
      const double withSine = part(kSine)[i] + part(kRippleSine)[i] * torque[i],
                   withCosine = part(kCosine)[i] + part(kRippleCosine)[i] * torque[i];
      motor[i] += withSine * sine + withCosine * cosine;
      if (changes_.empty()) continue;
      motorSlopes_.row(i) = torqueSlopes.row(i) - part(kFriction)[i] * preslidingSlopes_.row(i) -
                            presliding_[i] * changed(kFriction).row(i);
      if (!hasCogging_) continue;
      motorSlopes_.row(i) +=
          (part(kRippleSine)[i] * sine + part(kRippleCosine)[i] * cosine) * torqueSlopes.row(i) +
          sine * (changed(kSine).row(i) + torque[i] * changed(kRippleSine).row(i)) +
          cosine * (changed(kCosine).row(i) + torque[i] * changed(kRippleCosine).row(i)) +
          (withSine * cosine - withCosine * sine) *
              (periods * (drivenSlopes.angle.row(i) + 0.5 * h * drivenSlopes.rate.row(i) + changed(kOffset).row(i)) +
               (angle + part(kOffset)[i]) * changed(kPeriods));
    }
    return motor;
  }

  // Second order in h: the speed is linear, the torque that of the middle.
  void moveRigidly(double h, const Vector& motor) {
    const Vector begin = falling_ + mobility_ * (motor - damping_ * link_.rate);
    acceleration_ = begin - mobility_ * (0.5 * h * damping_ * begin);
    if (!changes_.empty()) {
      const Slopes torque = motorSlopes_ - inertialSlopes(acceleration_) - damping_.lazyProduct(linkSlopes_.rate) -
                            viscousSlopes(link_.rate + 0.5 * h * begin);
      const Slopes first = mobility_.lazyProduct(torque), held = 0.5 * h * damping_.lazyProduct(first);
      const Slopes slopes = first - mobility_.lazyProduct(held);
      linkSlopes_.angle += h * linkSlopes_.rate + 0.5 * h * h * slopes;
      linkSlopes_.rate += h * slopes;
    }
    link_.angle += h * link_.rate + 0.5 * h * h * acceleration_;
    link_.rate += h * acceleration_;
  }

  // Kutta's step for rotors, cables and links. `slopesAt` gives the slopes of angles and rates in a stage.
  template <typename Value, typename SlopesAt>
  static void step(double h, Part<Value>& link, Part<Value>& rotor, const SlopesAt& slopesAt) {
    const Part<Value> linkBegin = link, rotorBegin = rotor;
    Part<Value> linkAt = link, rotorAt = rotor;
    const double weights[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, ahead[4] = {0.5, 0.5, 1.0, 0.0};
    for (int stage = 0; stage < 4; ++stage) {
      Value pushed = Value::Zero(), turned = pushed;
      slopesAt(stage, linkAt, rotorAt, pushed, turned);
      const double share = weights[stage] * h, next = ahead[stage] * h;
      link.angle += share * linkAt.rate;
      link.rate += share * pushed;
      rotor.angle += share * rotorAt.rate;
      rotor.rate += share * turned;
      linkAt = {linkBegin.angle + next * linkAt.rate, linkBegin.rate + next * pushed};
      rotorAt = {rotorBegin.angle + next * rotorAt.rate, rotorBegin.rate + next * turned};
    }
  }

  void moveWithCables(double h, const Vector& motor) {
    const double stiffness = common(kStiffness), damping = common(kDamping), inertia = common(kRotor);
    Part<Vector> stretch[4];
    Vector turning[4] = {Vector::Zero(), Vector::Zero(), Vector::Zero(), Vector::Zero()};
    const Part<Vector> begin = link_;
    step(h, link_, rotor_,
         [&](int i, const Part<Vector>& link, const Part<Vector>& rotor, Vector& pushed, Vector& turned) {
           stretch[i] = {rotor.angle - link.angle, rotor.rate - link.rate};
           const Vector cable = stiffness * stretch[i].angle + damping * stretch[i].rate;
           pushed = falling_ + mobility_ * (cable - damping_ * link.rate);
           turned = turning[i] = (motor - cable) / inertia;
           acceleration_ = pushed;
         });
    if (changes_.empty()) return;
    const Slopes held = inertialSlopes((link_.rate - begin.rate) / h) +
                        viscousSlopes((link_.angle - begin.angle) / h);  // means of the step
    step(h, linkSlopes_, rotorSlopes_,
         [&](int i, const Part<Slopes>& link, const Part<Slopes>& rotor, Slopes& pushed, Slopes& turned) {
           const Slopes cable = stiffness * (rotor.angle - link.angle) + damping * (rotor.rate - link.rate) +
                                stretch[i].angle * changed(kStiffness) + stretch[i].rate * changed(kDamping);
           const Slopes torque = cable - damping_.lazyProduct(link.rate) - held;
           pushed = mobility_.lazyProduct(torque);
           turned = (motorSlopes_ - cable - turning[i] * changed(kRotor)) / inertia;
         });
  }

  static constexpr double kPresliding = 2e-4;  // rad or m, of Dahl's friction, as ImperfectPlant
  static constexpr double kFastest = 1e3;      // rad/s or m/s

  Eigen::Matrix<double, kJointParts * N + kCommons, 1> numbers_;
  const PathDynamics& path_;
  const std::vector<ModelChange>& changes_;
  Eigen::Matrix<double, kJointParts * N + kCommons, kLanes, Eigen::RowMajor> changed_ = decltype(changed_)::Zero();
  std::shared_ptr<const Mechanism> platform_;  // null: damping is that of joints
  Kinematics kinematics_;
  Matrix damped_ = Matrix::Identity();  // rates that damping opposes, from those of the joints
  bool hasCogging_;
  PlaceDynamics<N> near_;
  Vector begin_ = Vector::Zero();           // angle at the beginning of the part
  Vector sine_ = begin_, cosine_ = begin_;  // of its cogging
  Vector acceleration_ = begin_;            // of the links in the last step
  Vector falling_ = begin_;                 // accelerations of the links without torque
  Matrix damping_ = Matrix::Zero();         // torque of friction and velocities in the part: damping_ q'
  Matrix mobility_ = Matrix::Zero();        // M^-1
  Part<Vector> link_, rotor_;
  Vector presliding_ = begin_;  // share of the friction, -1 to 1
  Part<Slopes> linkSlopes_, rotorSlopes_;
  Slopes preslidingSlopes_ = Slopes::Zero(), motorSlopes_ = preslidingSlopes_;
  Slopes awaySlopes_ = preslidingSlopes_, biasSlopes_ = preslidingSlopes_;  // of q - q0 and g + C in the part
  Eigen::Matrix<double, N, N* kLanes> inertiaChanges_ = decltype(inertiaChanges_)::Zero();
};

// The change of the motors' torque with a parameter of the motors.
template <int N>
struct MotorChange {
  Eigen::Index lane;
  double width;
  Motors<N> before, after;
};

template <int N>
std::vector<MotorChange<N>> motorChanges(const std::vector<ModelChange>& changes, const RecordedMotion& motion,
                                         Eigen::Index first) {
  std::vector<MotorChange<N>> all;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const DeviceModel &a = changes[i].before, &b = changes[i].after;
    if (a.ratio != b.ratio || a.lag != b.lag || a.delay != b.delay)
      all.push_back(
          {static_cast<Eigen::Index>(i), changes[i].width, Motors<N>(a, motion, first), Motors<N>(b, motion, first)});
  }
  return all;
}

template <int N>
Simulated simulateJoints(const DeviceModel& model, const PathDynamics& path, const RecordedMotion& motion,
                         const Observer& observer, Eigen::Index first, Eigen::Index count,
                         const std::vector<ModelChange>& changes) {
  using Vector = typename Device<N>::Vector;
  using Slopes = Lanes<N>;
  Device<N> device(model, path, changes);
  device.start(motion.reading.col(first), 0.0);
  const double step = 1.0 / observer.substeps;
  const int part = observer.substeps / observer.parts;
  Motors<N> motors(model, motion, first);
  std::vector<MotorChange<N>> motorChange = motorChanges<N>(changes, motion, first);
  Spring<Vector> spring(observer, motion.period);
  Spring<Slopes> springSlopes(observer, motion.period);
  Simulated simulated;
  simulated.restarts = path.outside;
  simulated.reading.resize(N, count);
  simulated.joints.resize(N, count);
  simulated.slopes.assign(changes.size(), Eigen::MatrixXd(N, count));
  Vector error = Vector::Zero();
  Slopes errorSlopes = Slopes::Zero(), heldSlopes = errorSlopes, torqueSlopes = errorSlopes;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = first + k;
    simulated.reading.col(k) = device.reading();
    simulated.joints.col(k) = device.joints();
    const Slopes readingSlopes = device.readingSlopes();
    for (std::size_t lane = 0; lane < changes.size(); ++lane)
      simulated.slopes[lane].col(k) = readingSlopes.col(static_cast<Eigen::Index>(lane));
    if (k + 1 == count) break;
    const auto at = static_cast<std::size_t>(i);
    // Without a sample the last error holds: that of an interpolated reading grows with the acceleration.
    if (motion.isSample[at] != 0) {
      error = motion.reading.col(i) - device.reading();
      errorSlopes = -readingSlopes;
    }
    const Vector held = spring.torque(error);
    if (!changes.empty()) heldSlopes = springSlopes.torque(errorSlopes);
    const double duration = motion.time[at + 1] - motion.time[at];
    bool isPossible = true;
    motors.beginTick(i, step * duration);
    for (MotorChange<N>& change : motorChange) {
      change.before.beginTick(i, step * duration);
      change.after.beginTick(i, step * duration);
    }
    for (int s = 0; s < observer.substeps; ++s) {
      const double from = s * step, to = (s + 1) * step;
      const Vector torque = held + motors.mean(from, to);
      if (!changes.empty()) torqueSlopes = heldSlopes;
      for (MotorChange<N>& change : motorChange)
        torqueSlopes.col(change.lane) += (change.after.mean(from, to) - change.before.mean(from, to)) / change.width;
      if (s % part == 0)
        isPossible =
            isPossible && device.beginPart(static_cast<double>(k) + (s + 0.5 * part) * step, part * step * duration);
      if (isPossible) device.move(step * duration, torque, torqueSlopes, s == 0, s + 1 == observer.substeps);
    }
    if (isPossible) continue;
    ++simulated.restarts;
    spring.restart();
    springSlopes.restart();
    error.setZero();
    errorSlopes.setZero();
    device.start(motion.reading.col(i), static_cast<double>(k));
  }
  return simulated;
}

}  // namespace

Observer observerFor(const DeviceModel& model, double period) {
  const ImperfectDevice device = deviceOf(model);
  Observer observer;
  observer.inertia = device.mechanism->home().inertia;
  if (model.hasCables()) {
    const double links = observer.inertia.diagonal().minCoeff();
    const double resonance = std::sqrt(model.drive.cableStiffness * (1.0 / device.rotorInertia + 1.0 / links));
    observer.substeps = std::clamp(static_cast<int>(std::ceil(resonance * period / 0.3)), kSubsteps, 20);
    observer.inertia.diagonal().array() += device.rotorInertia;
  }
  observer.interval = std::max(1, static_cast<int>(std::lround(kKnots / period)));
  return observer;
}

Simulated simulate(const DeviceModel& model, const PathDynamics& path, const RecordedMotion& motion,
                   const Observer& observer, Eigen::Index first, Eigen::Index count,
                   const std::vector<ModelChange>& changes) {
  return motion.reading.rows() == 3 ? simulateJoints<3>(model, path, motion, observer, first, count, changes)
                                    : simulateJoints<6>(model, path, motion, observer, first, count, changes);
}

}  // namespace enamel::identify
