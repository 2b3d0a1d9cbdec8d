#include "enamel/render/tick.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace enamel {
namespace {

// What forward kinematics goes on from; the inertia is made anew.
template <typename AnyKinematics, typename Visit>
void forEachMatrix(AnyKinematics& k, const Visit& visit) {
  visit(k.pose.position);
  visit(k.pose.rotation);
  visit(k.twist);
  visit(k.q);
  visit(k.rates);
  visit(k.gravity);
  visit(k.jacobian);
  visit(k.inverseTransposed);
}

// With the last command, the sample's time and age, the tick's time, and the guard's reason.
std::size_t kinematicsSize(int joints) noexcept { return 18 + 16 * static_cast<std::size_t>(joints) + 4; }

constexpr double kLeastStep = 1e-3;  // of a tick whose sample is older than the prediction before it, periods

}  // namespace

HapticTick::HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
                       const GuardOptions& guard, const Pose& start)
    : mechanism_(mechanism),
      scene_(scene),
      tool_(tool),
      renderer_(renderer),
      guard_(mechanism, guard),
      track_(makeToolTrack(scene, tool)) {
  placeAt(start);
  input_.maxTorque = guard.on ? guard.torque : mechanism.limits().torque;
  output_.torque.setZero(mechanism.joints());
  renderer.activate(guard.period);
  numbers_.resize(kinematicsSize(mechanism.joints()) + track_.stateSize() + Guard::stateSize());
}

Status HapticTick::operator()(const Measurement& measurement, Command& command) noexcept {
  const bool isNext = measurement.age == 0 && measurement.time > sampleTime_ && measurement.time > input_.time;
  return tick(isNext ? measurement : adjusted(measurement), command);
}

// A sample that repeats its time stamp is none. A sample older than the prediction before it comes a little after it.
Measurement HapticTick::adjusted(const Measurement& measurement) const noexcept {
  const double period = guard_.options().period;
  Measurement m = measurement;
  if (m.age == 0 && m.time == sampleTime_) {
    m.age = input_.age + 1;
    m.time = input_.time + period;
  } else if (m.age == 0 && m.time > sampleTime_ && input_.age > 0) {
    m.time = std::max(m.time, input_.time + kLeastStep * period);
  }
  if (m.age > 0) {
    m.q = input_.kinematics.q;
    m.rates = input_.kinematics.rates;
  }
  return m;
}

Status HapticTick::tick(const Measurement& measurement, Command& command) noexcept {
  Status status = see(measurement);
  if (status == Status::ok) {
    status = renderer_.step(input_, output_);
  } else {
    output_ = TickOutput{};
    output_.torque.setZero(mechanism_.joints());
  }
  const bool touches = status == Status::ok && input_.contacts.count > 0;
  const GuardedCommand guarded =
      guard_.step(measurement, input_.kinematics, output_.torque, status,
                  touches ? input_.contacts.contacts[0].obstacleVelocity : Vec3(Vec3::Zero()));
  last_ = command.torque = guarded.torque;
  reason_ = guarded.reason;
  const bool stopped = guard_.fault() != GuardReason::none;
  if (guard_.options().on && !stopped && !guard_.engaged()) renderer_.reset();
  return status != Status::ok ? status : stopped ? Status::stopped : Status::ok;
}

void HapticTick::placeAt(const Pose& start) noexcept {
  input_.kinematics = Kinematics();
  if (!isRotation(start.rotation) || mechanism_.reach(start, Vec6::Zero(), false, input_.kinematics) != Status::ok)
    input_.kinematics = mechanism_.home();
}

void HapticTick::reset() noexcept {
  guard_.reset();
  renderer_.reset();
  sampleTime_ = kNever;
}

void HapticTick::restart(const Pose& start) noexcept {
  guard_.restart();
  renderer_.reset();
  sampleTime_ = kNever;
  placeAt(start);
  std::fill(numbers_.begin(), numbers_.end(), std::numeric_limits<double>::quiet_NaN());
  track_.loadState(scene_, numbers_.data());  // what no track can have: that of a new one
  output_ = TickOutput{};
  output_.torque.setZero(mechanism_.joints());
  last_ = JointVector();
  reason_ = GuardReason::none;
}

std::size_t HapticTick::stateSize() const noexcept { return numbers_.size() * sizeof(double) + renderer_.stateSize(); }

void HapticTick::saveState(void* state) const noexcept {
  double* at = numbers_.data();
  forEachMatrix(input_.kinematics, [&at](const auto& matrix) { at = std::copy_n(matrix.data(), matrix.size(), at); });
  std::fill_n(at, mechanism_.joints(), 0.0);
  std::copy_n(last_.data(), last_.size(), at);
  at += mechanism_.joints();
  for (const double number : {sampleTime_, input_.time, static_cast<double>(input_.age), static_cast<double>(reason_)})
    *at++ = number;
  track_.saveState(scene_, at);
  guard_.saveState(at + track_.stateSize());
  const std::size_t size = numbers_.size() * sizeof(double);
  std::memcpy(state, numbers_.data(), size);
  renderer_.saveState(static_cast<char*>(state) + size);
}

void HapticTick::loadState(const void* state) noexcept {
  const std::size_t size = numbers_.size() * sizeof(double);
  std::memcpy(numbers_.data(), state, size);
  const double* at = numbers_.data();
  const double* const reason = at + kinematicsSize(mechanism_.joints()) - 1;
  bool isSound = isRotation(Eigen::Map<const Mat3>(at + 3)) && *reason >= 0.0 &&
                 *reason <= static_cast<double>(GuardReason::deadlines) && *reason == std::floor(*reason);
  for (const double* number = at; number < reason; ++number) isSound = isSound && std::isfinite(*number);
  if (!isSound) {
    reset();
    return;
  }
  forEachMatrix(input_.kinematics, [&at](auto& matrix) {
    std::copy_n(at, matrix.size(), matrix.data());
    at += matrix.size();
  });
  last_ = Eigen::Map<const JointVector>(at, mechanism_.joints());
  sampleTime_ = reason[-3];
  input_.time = reason[-2];
  input_.age = static_cast<int>(std::clamp(reason[-1], 0.0, 1e6));
  reason_ = static_cast<GuardReason>(*reason);
  track_.loadState(scene_, reason + 1);
  guard_.loadState(reason + 1 + track_.stateSize());
  renderer_.loadState(static_cast<const char*>(state) + size);
}

Status HapticTick::see(const Measurement& measurement) noexcept {
  // Where the device cannot tell, the renderer takes its own answer for what acted, unless the guard changed it.
  const bool isTold = measurement.applied.size() > 0 || reason_ == GuardReason::none;
  if (measurement.age > 0) {
    if (sampleTime_ == kNever) return Status::stale;
    input_.time = measurement.time;
    input_.age = measurement.age;
    input_.applied = isTold ? measurement.applied : last_;
    return Status::ok;
  }
  Vec3 force = Vec3::Zero();  // of the wall at the last tick
  if (drill_ != nullptr && output_.mode == RenderMode::contact)
    force = wrenchOf(input_.kinematics, output_.torque - input_.kinematics.gravity).head<3>();
  const double periods = 1.0 + input_.age;  // since the last sample
  sampleTime_ = kNever;                     // until this one is known
  const Status status = mechanism_.track(measurement.q, measurement.rates, renderer_.needsInertia(), input_.kinematics);
  if (status != Status::ok) return status;
  input_.time = measurement.time;
  input_.age = measurement.age;
  input_.applied = isTold ? measurement.applied : last_;
  const Pose& pose = input_.kinematics.pose;
  const Status found = followContacts(scene_, tool_, pose, kContactMargin, track_, input_.contacts);
  if (found != Status::ok) return found;
  if (drill_ != nullptr) drill_->cut(scene_, pose, force, periods * guard_.options().period, input_.contacts);
  sampleTime_ = measurement.time;
  return Status::ok;
}

}  // namespace enamel
