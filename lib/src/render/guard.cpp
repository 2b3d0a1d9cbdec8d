#include "enamel/render/guard.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "render/guard_options.hpp"

namespace enamel {
namespace {

constexpr double kOscillationTime = 0.1;
constexpr double kForgottenMisses = 0.01;
constexpr double kIntervalTime = 0.1, kShortest = 0.5;  // s, periods
constexpr double kRounding = 1.0 + 1e-9;
constexpr double kTouching = 1e-4;  // m: contacts with a larger gap carry no force
// A reading is frozen if it repeats for kStillTicks ticks although the joint should move. One sign is steady motion
// before: at least kPace counts a tick. The other: the measured rate adds up to kClaimed counts. The sum covers the
// second half of these ticks only, because a filtered rate lags.
constexpr int kStillTicks = 50;
constexpr double kPace = 10.0, kEven = 0.3, kClaimed = 5.0;

bool isSize(const JointVector& v, int n) noexcept { return v.size() == n; }

// False for NaN too.
bool eachWithin(const JointVector& v, double limit) noexcept { return (v.array().abs() <= limit).all(); }

// Angular velocity of the joints without a motor, W, rad/s.
Vec3 undrivenTurn(const Kinematics& k, const JointVector& effort, const Vec6& twist) noexcept {
  Vec3 turn = Vec3::Zero();
  for (Eigen::Index i = 0; i < effort.size(); ++i)
    if (effort[i] == 0.0) turn += k.jacobian.col(i).tail<3>() * k.inverseTransposed.col(i).dot(twist);
  return turn;
}

// Mean velocity of the touched obstacles in W, each weighted by the commanded force along its normal. `turn`: angular
// velocity of the tool that no motor drives, W, rad/s. The hand causes it, and it moves the tool over the obstacle as
// if the obstacle moved.
Vec3 surfaceVelocity(const TickFrame& frame, const Vec3& turn) noexcept {
  const ContactSnapshot& contacts = frame.contacts;
  const auto velocityOf = [&](const Contact& c) {
    return Vec3(c.obstacleVelocity - turn.cross(c.point - frame.kinematics.pose.position));
  };
  bool moves = !turn.isZero(0.0);
  for (int c = 0; c < contacts.count; ++c) moves = moves || !contacts.contacts[c].obstacleVelocity.isZero(0.0);
  if (contacts.count == 0 || !moves) return Vec3::Zero();
  const Vec3 force = wrenchOf(frame.kinematics, frame.command - frame.kinematics.gravity).head<3>();
  std::array<double, kMaxContacts> along{};
  double sum = 0.0;
  for (int c = 0; c < contacts.count; ++c) {
    const Contact& contact = contacts.contacts[c];
    if (contact.gap < kTouching) along[c] = std::max(0.0, contact.normal.dot(force));
    sum += along[c];
  }
  if (!(sum > 0.0)) return velocityOf(contacts.contacts[0]);
  Vec3 velocity = Vec3::Zero();
  for (int c = 0; c < contacts.count; ++c) velocity += along[c] / sum * velocityOf(contacts.contacts[c]);
  return velocity;
}

}  // namespace

Guard::Guard(const Mechanism& device, const GuardOptions& options)
    : options_(checked(device, options)),
      n_(device.joints()),
      damped_(!options.damping.isZero(0.0)),
      most_(device.limits().effort),
      ring_(kGuardTicks) {
  if (options_.drive.stiffness > 0.0) describeCables(device);
  for (int i = 0; i < n_; ++i)
    if (isDriven(i)) weight_[i] = 1.0 / (most_[i] * most_[i]);
  for (GuardTick& tick : ring_) tick.q = tick.requested = tick.applied = JointVector::Zero(n_);
}

void Guard::reset() noexcept {
  State fresh;
  fresh.torque = state_.torque;
  fresh.acted = state_.acted;
  fresh.sent = state_.sent;
  fresh.match = state_.match;
  fresh.power = state_.power;
  fresh.error = state_.error;
  fresh.withheld = true;
  state_ = fresh;
}

void Guard::restart() noexcept {
  state_ = State();
  count_ = 0;
  ignored_ = 0;
  ignoredJoint_ = -1;
}

template <typename AnyState, typename Visit>
void Guard::forEachNumber(AnyState& s, const Visit& visit) {
  visit(s.fault);
  for (auto* flag : {&s.started, &s.acted, &s.open, &s.withheld, &s.known, &s.shedding, &s.reports}) visit(*flag);
  for (auto* number : {&s.time, &s.sampleTime, &s.ticks, &s.weight, &s.interval, &s.peak, &s.missed}) visit(*number);
  visit(s.rampTicks);
  for (auto* row : {&s.q, &s.acting, &s.torque, &s.gravity, &s.rendered, &s.from, &s.fromGravity, &s.match, &s.power,
                    &s.error, &s.jerk, &s.pace, &s.claimed})
    for (auto& number : *row) visit(number);
  for (auto& row : s.sent)
    for (auto& number : row) visit(number);
  for (auto* account : {&s.commanded, &s.learnt, &s.reported}) {
    visit(account->energy);
    visit(account->misfit);
    visit(account->single);
    for (auto* row : {&account->beyond, &account->surprise})
      for (auto& number : *row) visit(number);
    for (auto& mode : account->modes)
      for (auto& number : mode) visit(number);
  }
  for (int i = 0; i < 6; ++i) visit(s.twist[i]);
  for (int i = 0; i < 3; ++i) visit(s.surface[i]);
  for (int i = 0; i < 9; ++i) visit(s.rotation.data()[i]);
  for (auto& flag : s.even) visit(flag);
  for (auto& ticks : s.still) visit(ticks);
}

std::size_t Guard::stateSize() noexcept {
  std::size_t count = 0;
  const State state;
  forEachNumber(state, [&count](const auto&) { ++count; });
  return count;
}

void Guard::saveState(double* state) const noexcept {
  forEachNumber(state_, [&state](const auto& number) { *state++ = static_cast<double>(number); });
}

void Guard::loadState(const double* state) noexcept {
  State loaded;
  bool isSound = true;
  forEachNumber(loaded, [&](auto& number) {
    using Number = std::decay_t<decltype(number)>;
    const double value = *state++;
    double least = -std::numeric_limits<double>::max(), most = -least;
    if constexpr (!std::is_same_v<Number, double>) {
      least = 0.0;
      most = std::is_same_v<Number, bool>  ? 1.0
             : std::is_same_v<Number, int> ? std::numeric_limits<int>::max()
                                           : static_cast<double>(kGuardReasons - 1);
      isSound = isSound && value == std::floor(value);
    }
    isSound = isSound && value >= least && value <= most;
    if (isSound) number = static_cast<Number>(value);
  });
  for (int i = 0; i < n_; ++i) isSound = isSound && std::abs(loaded.torque[i]) <= kLargestTorque;
  if (isSound && options_.on)
    for (int i = 0; i < n_; ++i)
      isSound = isSound && (!isDriven(i) || std::abs(loaded.torque[i]) <= options_.torque[i]);
  if (isSound)
    state_ = loaded;
  else
    reset();
}

// Check for invalid numbers, jumps, frozen encoders and clock errors.
GuardReason Guard::measured(const Measurement& m, double elapsed) noexcept {
  State& s = state_;
  if (!isSize(m.q, n_) || !isSize(m.rates, n_) || !m.q.allFinite() || !m.rates.allFinite() || !std::isfinite(m.time) ||
      !(!m.applied || (isSize(*m.applied, n_) && eachWithin(*m.applied, kLargestTorque))))
    return GuardReason::measurement;
  if (!s.started) return GuardReason::none;
  const double longest = options_.longestGap * options_.period * kRounding;
  if (m.age > 0) {
    if (!(elapsed > 0.0)) return GuardReason::clock;
    return m.age > options_.longestGap || elapsed > longest ? GuardReason::late : GuardReason::none;
  }
  const double time = std::max(m.time - s.sampleTime, options_.period);
  GuardReason reason = GuardReason::none;
  for (int i = 0; i < n_; ++i) {
    const double step = m.q[i] - s.q[i], way = std::abs(step), count = options_.encoderStep[i];
    if (!(way <= options_.rate[i] * time + 2.0 * count)) reason = GuardReason::jump;
    if (way == 0.0) {
      if (s.still[i] < kStillTicks) ++s.still[i];
      if (s.still[i] > kStillTicks / 2) s.claimed[i] += m.rates[i] * time / count;
      const bool moves = (s.even[i] && std::abs(s.pace[i]) >= kPace) || std::abs(s.claimed[i]) >= kClaimed;
      if (s.still[i] >= kStillTicks && moves && reason == GuardReason::none) reason = GuardReason::frozen;
    } else {
      s.still[i] = 0;
      s.claimed[i] = 0.0;
      s.even[i] = std::abs(step / count - s.pace[i]) <= kEven * std::abs(s.pace[i]);
      s.pace[i] = step / count;
    }
  }
  if (reason != GuardReason::none) return reason;
  if (!(elapsed > 0.0)) return GuardReason::clock;
  return elapsed > longest ? GuardReason::late : GuardReason::none;
}

// Check whether the requested torque oscillates.
GuardReason Guard::asked(const JointVector& requested, const Kinematics& k) noexcept {
  State& s = state_;
  const double share = std::min(1.0, options_.period / kOscillationTime);
  bool oscillates = false;
  for (int i = 0; i < n_; ++i) {
    const double rendered = requested[i] - k.gravity[i];
    const double limit = options_.torque[i];
    const double change = limit > 0.0 ? std::clamp((rendered - s.rendered[i]) / limit, -2.0, 2.0) : 0.0;
    s.rendered[i] = rendered;
    if (!s.started || s.weight == 0.0) continue;
    s.jerk[i] += share * (change * change - s.jerk[i]);
    oscillates = oscillates || !(s.jerk[i] <= options_.oscillation * options_.oscillation);
  }
  return oscillates ? GuardReason::oscillation : GuardReason::none;
}

// Gravity torque, scaled down if a motor cannot produce it.
Guard::Row Guard::bounded(const JointVector& gravity) const noexcept {
  double scale = 1.0;
  for (int i = 0; i < n_; ++i)
    if (std::abs(gravity[i]) > options_.torque[i] && isDriven(i))
      scale = std::min(scale, options_.torque[i] / std::abs(gravity[i]));
  Row row{};
  for (int i = 0; i < n_; ++i) row[i] = std::clamp(scale * gravity[i], -options_.torque[i], options_.torque[i]);
  return row;
}

// Move from the last torque towards the new one in a straight line, as far as the slew limit permits.
bool Guard::limitSlew(double elapsed, JointVector& torque) const noexcept {
  const double time = std::clamp(elapsed, 0.0, options_.period);
  double scale = 1.0;
  for (int i = 0; i < n_; ++i) {
    const double change = std::abs(torque[i] - state_.torque[i]), most = options_.slew[i] * time;
    if (change > most * kRounding && isDriven(i)) scale = std::min(scale, most / change);
  }
  if (scale == 1.0) return false;
  for (int i = 0; i < n_; ++i) torque[i] = state_.torque[i] + scale * (torque[i] - state_.torque[i]);
  return true;
}

// Whether the rendered torque is small enough to engage.
bool Guard::isSmall() const noexcept {
  bool small = true;
  for (int i = 0; i < n_; ++i)
    small = small && (!isDriven(i) || std::abs(state_.rendered[i]) <= options_.engage * options_.torque[i]);
  return small;
}

// Limit a request that has no fault.
GuardReason Guard::shape(const Measurement& m, const Kinematics& k, const JointVector& requested, double elapsed,
                         JointVector& torque) noexcept {
  State& s = state_;
  const GuardOptions& o = options_;
  const Vec6& twist = s.twist;
  GuardReason reason = GuardReason::none;
  if (!m.enabled) {
    s.open = false;
    s.withheld = true;
    s.weight = std::max(0.0, s.weight - o.period / std::max(o.rampOut, o.period));
    reason = GuardReason::disabled;
  } else if (!s.open && (s.weight > 0.0 || !isSmall())) {
    s.withheld = true;
    s.weight = std::max(0.0, s.weight - o.period / std::max(o.rampOut, o.period));
    reason = GuardReason::waiting;
  } else {
    s.open = true;
    s.weight = s.withheld ? std::min(1.0, s.weight + o.period / std::max(o.rampIn, o.period)) : 1.0;
    if (s.weight < 1.0) reason = GuardReason::engaging;
  }

  const double speed = twist.head<3>().norm(), turn = twist.tail<3>().norm();
  Vec6 brake = Vec6::Zero();
  if (speed > o.speed) brake.head<3>() = -o.brake * (1.0 - o.speed / speed) * twist.head<3>();
  if (turn > o.turn) brake.tail<3>() = -o.brakeTurn * (1.0 - o.turn / turn) * twist.tail<3>();
  for (int i = 0; i < 3; ++i)
    if (std::abs(k.pose.position[i]) > o.workspace[i] && twist[i] * k.pose.position[i] > 0.0)
      brake[i] = -o.brake * twist[i];
  const bool brakes = !brake.isZero(0.0);
  if (brakes && reason == GuardReason::none) reason = GuardReason::brake;

  Row rendered = s.rendered;
  for (int i = 0; i < n_; ++i) {
    if (s.weight < 1.0) rendered[i] *= s.weight;
    if (brakes) rendered[i] += k.jacobian.col(i).dot(brake);
  }
  double scale = 1.0;
  if (o.force < kUnlimited || o.moment < kUnlimited) {
    Vec6 wrench = Vec6::Zero();
    for (int i = 0; i < n_; ++i) wrench += k.inverseTransposed.col(i) * rendered[i];
    const double force = wrench.head<3>().norm(), moment = wrench.tail<3>().norm();
    if (force > o.force) scale = o.force / force;
    if (moment > o.moment) scale = std::min(scale, o.moment / moment);
    if (scale < 1.0 && reason == GuardReason::none) reason = GuardReason::force;
  }
  const Row& gravity = s.gravity;
  double fits = scale;
  for (int i = 0; i < n_; ++i) {
    const double most = rendered[i] > 0.0 ? o.torque[i] - gravity[i] : o.torque[i] + gravity[i];
    if (scale * std::abs(rendered[i]) > most * kRounding && isDriven(i))
      fits = std::min(fits, most / std::abs(rendered[i]));
  }
  if (fits < scale && reason == GuardReason::none) reason = GuardReason::torque;

  bool passes = s.weight == 1.0 && !brakes && fits == 1.0;
  for (int i = 0; i < n_; ++i) passes = passes && (std::abs(requested[i]) <= o.torque[i] || !isDriven(i));
  if (passes) {
    torque = requested;
  } else {
    for (int i = 0; i < n_; ++i) {
      torque[i] = gravity[i] + fits * rendered[i];
      if (isDriven(i)) torque[i] = std::clamp(torque[i], -o.torque[i], o.torque[i]);
    }
    if (reason == GuardReason::none) reason = GuardReason::torque;  // gravity alone exceeds the limit
  }
  if (s.acted && limitSlew(s.started ? elapsed : o.period, torque) && reason == GuardReason::none)
    reason = GuardReason::slew;
  return reason;
}

// After a fault, ramp to the gravity torque, or to zero if gravity is unknown. The rendered part is dropped at once if
// the tool moves in its direction.
void Guard::ramp(const Measurement& m, bool known, JointVector& torque) noexcept {
  State& s = state_;
  const GuardOptions& o = options_;
  if (s.known && !known && s.rampTicks > 0) {  // ramp from the present torque to zero
    s.from = s.torque;
    s.rampTicks = 0;
  }
  s.known = s.known && known;
  if (s.rampTicks < std::numeric_limits<int>::max()) ++s.rampTicks;  // do not overflow: a fault may last for months
  double left = std::max(0.0, 1.0 - s.rampTicks * o.period / std::max(o.rampOut, o.period));
  if (left < 1e-9) left = 0.0;
  double pushed = 0.0;
  if (s.known)
    for (int i = 0; i < n_; ++i) pushed += (s.from[i] - s.fromGravity[i]) * (m.q[i] - s.q[i]);
  s.shedding = s.shedding || (s.known && pushed > 0.0);
  for (int i = 0; i < n_; ++i) {
    double wanted = left * s.from[i];
    if (s.known) wanted = s.gravity[i] + (s.shedding ? 0.0 : left * (s.from[i] - s.fromGravity[i]));
    torque[i] = std::clamp(wanted, -o.torque[i], o.torque[i]);
  }
}

// Judge a tick with a readable measurement.
GuardReason Guard::judged(const Measurement& m, Status status, bool known, double elapsed,
                          const TickFrame& frame) noexcept {
  State& s = state_;
  const JointVector& requested = frame.output.torque;
  if (m.failed) return GuardReason::device;
  if (!known) return GuardReason::unreachable;
  if (status != Status::ok || !isSize(requested, n_) || !eachWithin(requested, kLargestTorque))
    return GuardReason::renderer;
  if (s.started) {
    if (const GuardReason found = m.age == 0 ? moved(m, frame) : GuardReason::none; found != GuardReason::none)
      return found;
    const double missed = std::max(0.0, std::round(elapsed / options_.period) - 1.0) + (m.age > 0 ? 1.0 : 0.0);
    s.missed += missed - kForgottenMisses * s.missed;
    if (s.missed > options_.mostMissed) return GuardReason::deadlines;
    if (m.age == 0) {
      const double between = m.time - s.sampleTime;
      s.interval += std::min(1.0, between / kIntervalTime) * (between - options_.period - s.interval);
      if (s.interval < (kShortest - 1.0) * options_.period) return GuardReason::early;
    }
  }
  return asked(requested, frame.kinematics);
}

// Keep the measurement for the next ticks.
void Guard::remember(const Measurement& m) noexcept {
  State& s = state_;
  s.time = m.time;
  s.started = true;
  if (m.age > 0) return;
  for (int i = 0; i < n_; ++i) s.q[i] = m.q[i];
  s.sampleTime = m.time;
  s.ticks = 0.0;
}

void Guard::step(const Measurement& m, Status status, TickFrame& frame) noexcept {
  State& s = state_;
  const Kinematics& k = frame.kinematics;
  const JointVector& requested = frame.output.torque;
  JointVector& torque = frame.command;
  torque.setZero(n_);
  frame.reason = GuardReason::none;
  if (m.age > 0 && !s.started) {  // no sample since reset(): repeat the last torque
    for (int i = 0; i < n_; ++i) torque[i] = s.torque[i];
    frame.reason = GuardReason::waiting;
    return;
  }
  learn(frame.output);
  const double elapsed = m.time - s.time;
  const GuardReason read = measured(m, elapsed);
  const bool believed = read == GuardReason::none || read == GuardReason::clock || read == GuardReason::late;
  const bool known = believed && isSize(k.q, n_) && k.q == m.q && isSize(k.gravity, n_) && k.jacobian.cols() == n_ &&
                     k.inverseTransposed.cols() == n_ && k.gravity.allFinite() && std::isfinite(k.jacobian.sum()) &&
                     std::isfinite(k.inverseTransposed.sum());
  if (!options_.on) {
    if (isSize(requested, n_)) torque = requested;
  } else {
    const GuardReason found = read == GuardReason::none ? judged(m, status, known, elapsed, frame) : read;
    if (s.fault == GuardReason::none && found != GuardReason::none) {
      s.fault = found;
      s.open = false;
      s.from = s.torque;
      s.fromGravity = s.gravity;
      s.rampTicks = 0;
    }
    if (known) s.gravity = bounded(k.gravity);
    if (s.fault == GuardReason::none) {
      frame.reason = shape(m, k, requested, elapsed, torque);
    } else {
      frame.reason = s.fault;
      ramp(m, known, torque);
      if (s.acted) (void)limitSlew(options_.period, torque);
    }
  }

  if (believed || read == GuardReason::jump || read == GuardReason::frozen) remember(m);
  s.ticks = std::min(s.ticks + 1.0, options_.longestGap + 2.0);  // do not grow forever: a fault may last for months
  for (int i = 0; i < n_; ++i) {
    if (!std::isfinite(torque[i])) torque[i] = 0.0;  // e.g. from a Jacobian of 1e308
    s.torque[i] = torque[i];
    if (options_.on && !isDriven(i)) torque[i] = 0.0;  // its share of the wall's force is not work of the renderer
    s.acting[i] = s.ticks == 1.0 ? s.torque[i] : s.acting[i] + (s.torque[i] - s.acting[i]) / s.ticks;
  }
  std::copy_backward(s.sent.begin(), s.sent.end() - 1, s.sent.end());
  s.sent[0] = s.torque;
  s.acted = true;
  if (m.age == 0 || !known) {
    Vec3 turn = Vec3::Zero();
    if (known && s.ticks == 1.0 && elapsed > 0.0)
      turn = n_ < 6 ? Vec3(rotationVector(k.pose.rotation * s.rotation.transpose()) / elapsed - s.twist.tail<3>())
                    : undrivenTurn(k, options_.torque, s.twist);
    s.surface = known && status == Status::ok ? surfaceVelocity(frame, turn) : Vec3(Vec3::Zero());
    if (known) s.rotation = k.pose.rotation;
  }
  if (s.fault == GuardReason::none || s.rampTicks * options_.period <= options_.rampOut * kRounding) {
    GuardTick& tick = ring_[count_++ % kGuardTicks];
    tick.time = m.time;
    tick.q = m.q;
    tick.requested = requested;
    tick.applied = torque;
    tick.energy = energy();
    tick.reason = frame.reason;
  }
}

}  // namespace enamel
