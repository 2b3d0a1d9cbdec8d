#include "enamel/render/renderer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kLargestAngle = 1e3;      // rad
constexpr double kLargestRate = 1e3;       // rad/s
constexpr double kLargestPosition = 10.0;  // m
constexpr double kLargestSpeed = 100.0;    // m/s
constexpr double kLargestGap = 100.0;      // m
constexpr double kLargestViscosity = 1e3;  // N s/m
constexpr double kLargestJacobian = 1e3;   // m or 1: motion of the platform per joint motion
constexpr double kLargestInverse = 1e9;    // of its inverse, near a singularity

// Compare the norm: one sum without branches. False for NaN too.
template <typename Vector>
bool within(const Vector& v, double limit) noexcept {
  return v.squaredNorm() <= limit * limit;
}

bool isFinite(const Contact& c) noexcept {
  return c.point.allFinite() && c.normal.allFinite() && c.obstacleVelocity.allFinite() && std::isfinite(c.gap);
}

// A sum is finite only if each number is. A sum of finite numbers can overflow; then each number is checked.
template <typename Matrix>
bool allFinite(const Matrix& m) noexcept {
  return std::isfinite(m.sum()) || m.allFinite();
}

bool sizesAgree(const TickFrame& in) noexcept {
  const Kinematics& k = in.kinematics;
  const auto n = k.q.size();
  return n >= 1 && k.rates.size() == n && k.jacobian.cols() == n && k.inverseTransposed.cols() == n &&
         k.gravity.size() == n && (k.inertia.rows() == n || k.inertia.rows() == 0) &&
         k.inertia.cols() == k.inertia.rows() && in.maxTorque.size() == n && (!in.applied || in.applied->size() == n) &&
         (in.command.size() == n || in.command.size() == 0);
}

bool isMaterial(const Material& m) noexcept {
  return m.stiffness > 0.0 && m.friction >= 0.0 && m.friction <= 10.0 && m.slidingFriction >= 0.0 &&
         m.slidingFriction <= m.friction && m.viscosity >= 0.0 && m.viscosity <= kLargestViscosity &&
         m.exponent >= 1.0 && m.exponent <= kLargestExponent && m.thickness > 0.0 && m.hysteresis >= 0.0 &&
         m.hysteresis <= kLargestHysteresis && m.puncture > 0.0 && m.stribeck >= 0.0 && m.stribeck <= kLargestStribeck;
}

// Every value has a limit, so NaN and infinity fail.
bool isPlausible(const TickFrame& in) noexcept {
  const Kinematics& k = in.kinematics;
  bool plausible = std::isfinite(in.time) && isRotation(k.pose.rotation) && within(k.q, kLargestAngle) &&
                   within(k.rates, kLargestRate) && within(k.pose.position, kLargestPosition) &&
                   within(k.twist.head<3>(), kLargestSpeed) && within(k.twist.tail<3>(), kLargestRate) &&
                   within(k.gravity, kLargestTorque) && (!in.applied || within(*in.applied, kLargestTorque)) &&
                   within(in.command, kLargestTorque) && within(in.maxTorque, kLargestTorque) &&
                   in.maxTorque.minCoeff() >= 0.0 && within(k.jacobian, kLargestJacobian) &&
                   within(k.inverseTransposed, kLargestInverse) && allFinite(k.inertia);
  for (int i = 0; i < in.contacts.count; ++i) {
    const Contact& c = in.contacts.contacts[i];
    plausible = plausible && std::abs(c.gap) <= kLargestGap && within(c.point, kLargestPosition) &&
                within(c.obstacleVelocity, kLargestSpeed) && std::abs(c.normal.squaredNorm() - 1.0) <= 1e-6 &&
                isMaterial(c.material);
  }
  return plausible;
}

bool isFinite(const TickFrame& in) noexcept {
  const Kinematics& k = in.kinematics;
  bool finite = std::isfinite(in.time) && allFinite(k.q) && allFinite(k.rates) && allFinite(k.pose.position) &&
                allFinite(k.pose.rotation) && allFinite(k.twist) && allFinite(k.jacobian) &&
                allFinite(k.inverseTransposed) && allFinite(k.gravity) && allFinite(k.inertia) &&
                allFinite(in.maxTorque) && (!in.applied || allFinite(*in.applied)) && allFinite(in.command);
  for (int i = 0; i < in.contacts.count; ++i) finite = finite && isFinite(in.contacts.contacts[i]);
  return finite;
}

}  // namespace

Status checkFrame(const TickFrame& frame, double lastTime) noexcept {
  if (frame.contacts.count < 0 || frame.contacts.count > kMaxContacts || frame.age < 0 || !sizesAgree(frame))
    return Status::outOfRange;
  if (!isPlausible(frame)) return isFinite(frame) ? Status::outOfRange : Status::notFinite;
  return frame.time > lastTime ? Status::ok : Status::stale;
}

void Renderer::activate(double period) {
  active_ = isReady_ = false;
  requirePeriod(period, "renderer: ");
  prepare(period);
  isReady_ = true;
  kept_.resize(stateBlock().size);
  reset();
  active_ = true;
}

Status Renderer::step(const TickFrame& frame, TickOutput& output) noexcept {
  const auto joints = frame.kinematics.q.size();
  output = TickOutput{};
  output.torque.setZero(joints);
  if (!active_) return Status::inactive;
  Status status = checkFrame(frame, lastTime_);
  if (status != Status::ok) return status;
  const StateBlock before = stateBlock();
  std::copy_n(static_cast<const unsigned char*>(before.data), before.size, kept_.begin());
  status = render(frame, output);
  if (status == Status::ok &&
      !(output.torque.size() == joints && allFinite(output.torque) && std::isfinite(output.normalForce)))
    status = Status::notFinite;
  if (status == Status::ok &&
      !(within(output.torque, kLargestTorque) && std::abs(output.normalForce) <= kLargestTorque))
    status = Status::outOfRange;
  if (status == Status::ok) {
    // the renderer may have cut the torque itself
    output.saturated = saturate(output.torque, frame.kinematics.gravity, frame.maxTorque) || output.saturated;
    lastTime_ = frame.time;
  } else {
    output = TickOutput{};
    output.torque.setZero(joints);
    std::copy_n(kept_.begin(), before.size, static_cast<unsigned char*>(before.data));
    stateLoaded();
  }
  return status;
}

void Renderer::reset() noexcept {
  if (!isReady_) return;
  lastTime_ = -std::numeric_limits<double>::infinity();
  resetState();
}

// stateBlock() is not const because loadState() writes through it. These two functions only read.
std::size_t Renderer::stateSize() const noexcept {
  return isReady_ ? sizeof(lastTime_) + const_cast<Renderer*>(this)->stateBlock().size : 0;
}

void Renderer::saveState(void* state) const noexcept {
  if (!isReady_) return;
  const StateBlock block = const_cast<Renderer*>(this)->stateBlock();
  std::memcpy(state, &lastTime_, sizeof(lastTime_));
  if (block.size > 0) std::memcpy(static_cast<char*>(state) + sizeof(lastTime_), block.data, block.size);
}

void Renderer::loadState(const void* state) noexcept {
  if (!isReady_) return;
  const StateBlock block = stateBlock();
  std::memcpy(&lastTime_, state, sizeof(lastTime_));
  if (block.size > 0) std::memcpy(block.data, static_cast<const char*>(state) + sizeof(lastTime_), block.size);
  stateLoaded();
  if (!(lastTime_ < std::numeric_limits<double>::infinity())) reset();
}

bool Renderer::isFinite(const StateBlock& block) noexcept {
  double value;
  for (std::size_t at = 0; at + sizeof(value) <= block.size; at += sizeof(value)) {
    std::memcpy(&value, static_cast<const char*>(block.data) + at, sizeof(value));
    if (!std::isfinite(value)) return false;
  }
  return true;
}

bool saturate(JointVector& torque, const JointVector& gravity, const JointVector& maxTorque) noexcept {
  double scale = 1.0;
  bool cut = false;
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    if (maxTorque[i] == 0.0) torque[i] = 0.0;
    if (std::abs(torque[i]) <= maxTorque[i]) continue;
    cut = true;
    const double rendered = torque[i] - gravity[i];
    // Limit on the side of `rendered`. The scale becomes 0 if gravity's torque alone exceeds it.
    const double most = std::copysign(maxTorque[i], rendered) - gravity[i];
    scale = std::min(scale, std::max(0.0, most / rendered));
  }
  if (!cut) return false;
  for (Eigen::Index i = 0; i < torque.size(); ++i)
    torque[i] = std::clamp(gravity[i] + scale * (torque[i] - gravity[i]), -maxTorque[i], maxTorque[i]);
  return true;
}

Vec3 translationAt(const Vec6& motion, const Vec3& arm) noexcept {
  return motion.head<3>() + motion.tail<3>().cross(arm);
}

Vec3 contactVelocity(const Kinematics& kinematics, const Contact& contact) noexcept {
  return translationAt(kinematics.twist, contact.point - kinematics.pose.position) - contact.obstacleVelocity;
}

double predictedGap(const TickFrame& frame, const Contact& contact, double period) noexcept {
  if (frame.age == 0) return contact.gap;
  return contact.gap + frame.age * period * contact.normal.dot(contactVelocity(frame.kinematics, contact));
}

}  // namespace enamel
