#include "enamel/render/tap_transient.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "enamel/render/renderer.hpp"

namespace enamel {
namespace {

constexpr double kLeastSpeed = 0.02;  // m/s: slower touches are presses, and encoder noise is not an impact
constexpr double kFollow = 0.5;       // filter gain per sample for the twist
constexpr double kNewImpact = 2.0;    // a faster touch than this multiple of the vibration is another impact
constexpr double kDecays = 6.0;       // times 1 / B: the end of a transient

bool hasTap(const Material& material) noexcept { return material.tap.frequency > 0.0; }

Eigen::Map<const Vec3> normalOf(const std::array<double, 3>& normal) noexcept {
  return Eigen::Map<const Vec3>(normal.data());
}

}  // namespace

bool hasTaps(const Scene& scene) noexcept {
  for (const Obstacle& obstacle : scene.obstacles()) {
    if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) {
      for (const SolidLayer& layer : (*solid)->layers())
        if (hasTap(layer.material)) return true;
    } else if (hasTap(obstacle.material)) {
      return true;
    }
  }
  return false;
}

const Contact* TapTransient::contactOf(const TickFrame& frame) const noexcept {
  for (int i = 0; i < frame.contacts.count; ++i)
    if (frame.contacts.contacts[i].obstacle == static_cast<int>(state_.obstacle)) return &frame.contacts.contacts[i];
  return nullptr;
}

// Start a transient if the tool will be inside a surface before the next command acts.
void TapTransient::detect(const TickFrame& frame) noexcept {
  State& s = state_;
  const Kinematics& k = frame.kinematics;
  const double lead = (delay_ + frame.age) * period_;
  const Eigen::Map<const Vec6> twist(s.twist.data());
  bool isTouching = false;
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& c = frame.contacts.contacts[i];
    if (!hasTap(c.material)) continue;
    isTouching = isTouching || c.gap <= 0.0;
    const Vec3 arm = c.point - k.pose.position;
    const double speed = -c.normal.dot(translationAt(twist, arm) - c.obstacleVelocity);
    const double vibrates = s.obstacle < 0.0 ? 0.0 : s.speed * std::exp(-s.decay * s.elapsed);
    if (s.touched != 0.0 || !(speed > std::max(kLeastSpeed, kNewImpact * vibrates)) || c.gap > speed * (lead + period_))
      continue;
    const double mass = effectiveMass(k, c.point, c.normal),
                 most = std::min(largestForce(k, frame.maxTorque, c.point, c.normal),
                                 largestForce(k, frame.maxTorque, c.point, -c.normal));
    if (!(mass > 0.0 && most > 0.0 && std::isfinite(mass + most))) continue;
    const std::array<double, 6> kept = s.twist;
    s = State{};
    s.twist = kept;
    Eigen::Map<Vec3>(s.normal.data()) = c.normal;
    s.obstacle = c.obstacle;
    s.speed = speed;
    s.frequency = c.material.tap.frequency;
    s.decay = c.material.tap.decay;
    s.mass = mass;
    s.most = most;
    const double w = 2.0 * M_PI * s.frequency;
    s.deflection = 2.0 * s.decay * speed / (s.decay * s.decay + w * w);  // the acceleration begins at 0
    s.rate = -speed;
    s.place = c.gap - speed * lead;
    s.gap = c.gap;
    break;
  }
  if (frame.age == 0) s.touched = isTouching ? 1.0 : 0.0;
}

void TapTransient::move(TickFrame& frame, int delay, double period) noexcept {
  State& s = state_;
  delay_ = std::clamp(delay, 0, kMaxLoopDelay);
  period_ = period;
  for (int i = 0; i < 6 && frame.age == 0; ++i) s.twist[i] += kFollow * (frame.kinematics.twist[i] - s.twist[i]);
  if (const Contact* contact = contactOf(frame); contact != nullptr && frame.age == 0) {
    double acted = 0.0;  // mean force since the last sample
    const int ticks = 1 + static_cast<int>(s.missed);
    for (int i = 0; i < ticks; ++i) acted += s.sent[std::min(delay_ + i, kMaxLoopDelay)] / ticks;
    s.energy -= acted * (contact->gap - s.gap);
    s.gap = contact->gap;
  }
  s.missed = frame.age;
  detect(frame);
  seen_ = frame.contacts.contacts;
  if (s.obstacle < 0.0) return;
  // Before the impact, the surface recedes before the tool.
  const bool isBefore = s.elapsed == 0.0 && s.place > 0.0;
  const double speed = isBefore ? s.rate : s.rate - s.decay * s.place,
               place = (isBefore ? 0.0 : s.place) - speed * (delay_ + frame.age) * period_;
  const auto normal = normalOf(s.normal);
  for (int i = 0; i < frame.contacts.count; ++i) {
    Contact& c = frame.contacts.contacts[i];
    if (c.obstacle != static_cast<int>(s.obstacle)) continue;
    c.gap -= place * normal.dot(c.normal);
    c.obstacleVelocity += speed * normal;
  }
}

void TapTransient::push(TickFrame& frame) noexcept {
  State& s = state_;
  std::copy_n(seen_.begin(), frame.contacts.count, frame.contacts.contacts.begin());
  s.force = 0.0;
  if (s.obstacle < 0.0 || frame.output.mode == RenderMode::fault) return;
  const Contact* const contact = contactOf(frame);
  if (contact == nullptr || s.elapsed * s.decay > kDecays || s.elapsed > 1.0) {
    s.obstacle = -1.0;
    return;
  }
  const Kinematics& k = frame.kinematics;
  const auto normal = normalOf(s.normal);
  const double T = period_, w = 2.0 * M_PI * s.frequency, B = s.decay, square = B * B + w * w;
  // Motion of y'' + 2 B y' + (B^2 + w^2) y = 0, in the part of the tick after the impact.
  const double part = s.elapsed == 0.0 ? std::clamp(T - s.place / s.speed, 0.0, T) : T;
  const double fades = std::exp(-B * part), cosine = std::cos(w * part), sine = std::sin(w * part) / w;
  const double deflection = fades * ((cosine + B * sine) * s.deflection + sine * s.rate),
               rate = fades * (-square * sine * s.deflection + (cosine - B * sine) * s.rate);
  const double wanted = s.mass * (rate - s.rate) / T, possible = std::clamp(wanted, -s.most, s.most);
  // The share of it for which all forces give no more energy than is left: a s^2 + b s + c <= 0.
  const double others = normal.dot(wrenchOf(k, frame.output.torque - k.gravity).head<3>());
  double left = s.energy;
  for (int i = 0; i < delay_; ++i) left -= s.sent[i] * s.moves[i];
  const double a = possible * possible * T * T / (2.0 * s.mass),
               b = possible * s.rate * T + others * possible * T * T / (2.0 * s.mass), c = others * s.rate * T - left;
  double share = 1.0;
  if (a + b + c > 0.0) share = c < 0.0 ? (std::sqrt(b * b - 4.0 * a * c) - b) / (2.0 * a) : 0.0;
  s.force = share * possible;
  const double before = s.rate;
  if (s.force == wanted) {
    s.deflection = deflection;
    s.rate = rate;
  } else {  // the oscillator slips
    s.rate += s.force / s.mass * T;
    s.deflection = -(s.force / s.mass + 2.0 * B * s.rate) / square;
  }
  std::copy_backward(s.moves.begin(), s.moves.end() - 1, s.moves.end());
  s.moves[0] = 0.5 * (before + s.rate) * T;
  s.place += s.moves[0] - B * s.place * T;
  s.elapsed += part;
  const Vec3 force = s.force * normal, arm = contact->point - k.pose.position;
  Vec6 wrench;
  wrench << force, arm.cross(force);
  frame.output.torque += torqueOf(k.jacobian, wrench);
  frame.output.saturated = saturate(frame.output.torque, k.gravity, frame.maxTorque) || frame.output.saturated;
}

void TapTransient::sent(const TickFrame& frame) noexcept {
  State& s = state_;
  const Kinematics& k = frame.kinematics;
  if (s.obstacle < 0.0 || frame.command.size() != k.gravity.size()) return;
  std::copy_backward(s.sent.begin(), s.sent.end() - 1, s.sent.end());
  s.sent[0] = normalOf(s.normal).dot(wrenchOf(k, frame.command - k.gravity).head<3>());
}

void TapTransient::saveState(double* state) const noexcept { std::memcpy(state, &state_, sizeof state_); }

void TapTransient::loadState(const double* state) noexcept {
  std::memcpy(&state_, state, sizeof state_);
  bool isSound = state_.obstacle < 0.0 || (state_.mass > 0.0 && state_.speed > 0.0 && state_.frequency > 0.0);
  for (std::size_t i = 0; i < kNumbers; ++i) isSound = isSound && std::isfinite(state[i]);
  if (!isSound) reset();
}

}  // namespace enamel
