#include "enamel/render/tap_transient.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "enamel/render/renderer.hpp"
#include "render/scene_surfaces.hpp"

namespace enamel {
namespace {

constexpr double kTapSpeed = 0.02;   // m/s: slower touches are presses
constexpr double kTapNear = 2e-5;    // m: position control pushes from here on
constexpr double kTapFollow = 0.5;   // filter gain per sample for the twist
constexpr double kNextTap = 2.0;     // a faster touch than this multiple of the vibration is another impact
constexpr double kMostPhase = 0.25;  // periods by which a force may come late at random: later it gives energy
constexpr double kTapGain = 0.5;     // of the cables: below it, an error of the resonance counts more than twice
constexpr double kTapMissed = 1e3, kTapObstacles = 1e6;  // of a saved state
constexpr double kTapDecays = 6.0;                       // times 1 / B: the end of a transient

// Force of the motors that gives a vibration, over the force with rigid cables: 1 - (f / f_c)^2. f_c is the resonance
// of rotors and links along the row.
double cableGain(const ContactRow& row, const JointLimits& limits, double frequency) noexcept {
  const Drive& drive = limits.drive;
  if (!(drive.stiffness > 0.0)) return 1.0;
  double square = 0.0;
  for (const double response : row.response) square += response * response;
  const double rotors = drive.rotorInertia * square * row.mass;  // share of the inertia
  const double w = 2.0 * M_PI * frequency;
  return 1.0 - w * w * drive.rotorInertia * (1.0 - rotors) / drive.stiffness;
}

bool isOn(const Tap& tap) noexcept { return tap.frequency > 0.0; }

// Return the tap of the material at a contact.
Tap tapAt(const Scene& scene, const Contact& contact) noexcept {
  const auto number = static_cast<std::size_t>(contact.obstacle);
  if (number >= scene.obstacles().size()) return {};
  const Obstacle& obstacle = scene.obstacles()[number];
  const auto* const found = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape);
  if (found == nullptr) return obstacle.tap;
  const Solid& solid = **found;
  const Vec3 below = contact.point - (contact.gap + 0.5 * solid.cell()) * contact.normal;
  const Vec3 place = obstacle.pose.rotation.transpose() * (below - obstacle.pose.position);
  return solid.layers()[static_cast<std::size_t>(solid.layerAt(place))].tap;
}

Eigen::Map<const Vec3> tapNormal(const std::array<double, 3>& normal) noexcept {
  return Eigen::Map<const Vec3>(normal.data());
}

}  // namespace

bool hasTaps(const Scene& scene) noexcept {
  return anySurface(scene, [](const Material&, const Tap& tap) { return isOn(tap); });
}

const Contact* TapTransient::contactOf(const TickFrame& frame) const noexcept {
  for (int i = 0; i < frame.contacts.count; ++i)
    if (frame.contacts.contacts[i].obstacle == static_cast<int>(state_.obstacle)) return &frame.contacts.contacts[i];
  return nullptr;
}

// Return the force along a normal of a command, counted from the newest.
double TapTransient::sentAlong(const Vec3& normal, int command) const noexcept {
  return normal.dot(Eigen::Map<const Vec3>(state_.sent[static_cast<std::size_t>(command)].data()));
}

// Start a transient if the tool will touch a surface before the end of the tick in which the next command acts.
void TapTransient::detect(const TickFrame& frame, const Scene& scene, const JointLimits& limits) noexcept {
  State& s = state_;
  const Kinematics& k = frame.kinematics;
  const Drive& drive = limits.drive;
  const double T = period_;
  const Eigen::Map<const Vec6> twist(s.twist.data());
  bool isTouching = false;
  for (int i = 0; i < frame.contacts.count; ++i) {
    const Contact& c = frame.contacts.contacts[i];
    const bool isMovable = frame.yield.isAny && frame.yield.inverse[i][i] > 0.0;
    const Tap tap = tapAt(scene, c);
    if (!isOn(tap) || isMovable) continue;  // a movable obstacle answers by itself
    if (spread_ * T * tap.frequency >= kMostPhase) continue;
    isTouching = isTouching || c.gap <= 0.0;
    const double speed = -c.normal.dot(translationAt(twist, c.point - k.pose.position) - c.obstacleVelocity);
    const ContactRow& row = frame.rows.row[i];
    double step = 0.0;  // of the encoders along the normal, m
    for (int j = 0; j < k.jacobian.cols(); ++j)
      step = std::hypot(step, row.normal[static_cast<std::size_t>(j)] * limits.encoderStep[j]);
    const double vibrates = s.obstacle < 0.0 ? 0.0 : s.speed * std::exp(-s.decay * s.elapsed);
    if (s.touched != 0.0 || !(speed > std::max(kTapSpeed + kTapFollow * step / T, kNextTap * vibrates)) ||
        c.gap > speed * (delay_ + frame.age + 1) * T + kTapNear)
      continue;
    const double mass = row.mass, most = std::min(largestForce(k, frame.maxTorque, c.point, c.normal),
                                                  largestForce(k, frame.maxTorque, c.point, -c.normal));
    if (!(mass > 0.0 && most > 0.0 && std::isfinite(mass + most))) continue;
    double place = c.gap - speed * frame.age * T, rate = -speed;
    std::array<double, kMaxLoopDelay + 1> moves{};
    for (int pending = delay_ - 1; pending >= 0; --pending) {
      const double change = sentAlong(c.normal, pending) * T / mass;
      moves[static_cast<std::size_t>(pending)] = (rate + 0.5 * change) * T;
      place += (rate + 0.5 * change) * T;
      rate += change;
    }
    if (!(rate < 0.0) || place + rate * T > kTapNear) continue;
    const double gain = cableGain(row, limits, tap.frequency);
    if (gain < kTapGain) continue;
    State event;
    event.twist = s.twist;
    event.sent = s.sent;
    event.added = s.added;
    event.joints = s.joints;
    event.moves = moves;
    Eigen::Map<Vec3>(event.normal.data()) = c.normal;
    event.obstacle = c.obstacle;
    event.speed = -rate;
    event.frequency = tap.frequency;
    event.decay = tap.decay;
    event.mass = mass;
    event.most = most;
    const double w = 2.0 * M_PI * event.frequency;
    event.deflection = 2.0 * event.decay * event.speed / (event.decay * event.decay + w * w);  // no acceleration yet
    event.rate = rate;
    event.place = place;
    event.gain = gain;
    for (int j = 0; drive.stiffness > 0.0 && !drive.encoderOnLink && j < k.jacobian.cols(); ++j)
      event.compliance +=
          row.normal[static_cast<std::size_t>(j)] * row.normal[static_cast<std::size_t>(j)] / drive.stiffness;
    event.doubt = 0.5 * step * most;
    event.gap = c.gap;
    event.missed = frame.age;
    s = event;
    break;
  }
  if (frame.age == 0) s.touched = isTouching ? 1.0 : 0.0;
}

void TapTransient::move(TickFrame& frame, const Scene& scene, const Delay& delay, double period,
                        const JointLimits& limits) noexcept {
  State& s = state_;
  delay_ = std::clamp(delay.low, 0, kMaxLoopDelay);
  spread_ = delay.high - delay.low;
  period_ = period;
  // A rate after a lost sample may be a difference over more than a tick.
  for (int i = 0; i < 6 && frame.age == 0 && s.missed == 0.0; ++i)
    s.twist[i] += kTapFollow * (frame.kinematics.twist[i] - s.twist[i]);
  if (const Contact* contact = contactOf(frame); contact != nullptr && frame.age == 0) {
    double acted = 0.0;  // mean force since the last sample
    const int ticks = 1 + static_cast<int>(s.missed);
    for (int i = 0; i < ticks; ++i)
      acted += sentAlong(tapNormal(s.normal), std::min(delay_ + i, kMaxLoopDelay)) / ticks;
    const double gap = contact->gap - s.compliance * acted;  // of the link, if the encoders are on the rotors
    s.energy -= acted * (gap - s.gap);
    s.gap = gap;
    if (s.energy < -s.doubt) s.rate = s.deflection = 0.0;  // the device does not move as predicted: vibrate no more
  }
  s.missed = frame.age;
  frame.added = Eigen::Map<const JointVector>(s.added.data(), static_cast<Eigen::Index>(s.joints));
  detect(frame, scene, limits);
  if (s.obstacle < 0.0) return;
  seen_ = frame.contacts.contacts;
  // Before the impact, the surface recedes before the tool.
  const bool isBefore = s.elapsed == 0.0 && s.place > 0.0;
  const double speed = isBefore ? s.rate : s.rate - s.decay * s.place,
               place = (isBefore ? 0.0 : s.place) - speed * (delay_ + frame.age) * period_;
  const auto normal = tapNormal(s.normal);
  for (int i = 0; i < frame.contacts.count; ++i) {
    Contact& c = frame.contacts.contacts[i];
    if (c.obstacle != static_cast<int>(s.obstacle)) continue;
    c.gap -= place * normal.dot(c.normal);
    c.obstacleVelocity += speed * normal;
  }
}

void TapTransient::push(TickFrame& frame) noexcept {
  State& s = state_;
  rendered_ = frame.output.torque;
  s.force = 0.0;
  if (s.obstacle < 0.0) return;
  frame.contacts.contacts = seen_;
  if (frame.output.mode == RenderMode::fault) return;
  const Contact* const contact = contactOf(frame);
  if (contact == nullptr || s.elapsed * s.decay > kTapDecays || s.elapsed > 1.0) {
    s.obstacle = -1.0;
    return;
  }
  const Kinematics& k = frame.kinematics;
  const auto normal = tapNormal(s.normal);
  const double T = period_, w = 2.0 * M_PI * s.frequency, B = s.decay, square = B * B + w * w;
  // Motion of y'' + 2 B y' + (B^2 + w^2) y = 0, in the part of the tick after the impact.
  const double part = s.elapsed == 0.0 ? std::clamp(T - s.place / s.speed, 0.0, T) : T;
  const double fades = std::exp(-B * part), cosine = std::cos(w * part), sine = std::sin(w * part) / w;
  const double deflection = fades * ((cosine + B * sine) * s.deflection + sine * s.rate),
               rate = fades * (-square * sine * s.deflection + (cosine - B * sine) * s.rate);
  double possible = s.gain * s.mass * (rate - s.rate) / T;
  const double wanted = possible;
  if (std::abs(wanted) > s.gain * s.most) {
    // Brake with all force, then vibrate as strongly as the motors can: with the speed of an acceleration `most`.
    possible = std::copysign(s.most, wanted);
    const double out = possible / s.mass / std::sqrt(square), after = s.rate + possible / s.mass * T;
    if (after / out > 1.0) possible = s.mass * (out - s.rate) / T;
  }
  // The share of it for which all forces give no more energy than is left: a s^2 + b s + c <= 0.
  const double others = normal.dot(wrenchOf(k, frame.output.torque - k.gravity).head<3>());
  double left = s.energy;
  for (int i = 0; i < delay_; ++i) left -= sentAlong(normal, i) * s.moves[i];
  const double a = possible * possible * T * T / (2.0 * s.mass),
               b = possible * s.rate * T + others * possible * T * T / (2.0 * s.mass), c = others * s.rate * T - left;
  double share = 1.0;
  if (a + b + c > 0.0) share = c < 0.0 ? (std::sqrt(b * b - 4.0 * a * c) - b) / (2.0 * a) : 0.0;
  s.force = share * possible;
  const double before = s.rate;
  if (s.force == wanted) {
    s.deflection = deflection;
    s.rate = rate;
  } else {  // the oscillator slips: it has the acceleration that is possible
    const double peak = std::min(s.most / s.mass, std::hypot(square * s.deflection, std::sqrt(square) * before));
    s.rate += s.force / s.mass * T;
    const double speed = s.rate * std::sqrt(square),
                 reached = s.rate * possible < 0.0 ? peak : std::sqrt(std::max(0.0, peak * peak - speed * speed));
    s.deflection = -std::copysign(reached, possible) / square;
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
  const bool isSound = frame.command.size() == k.gravity.size() && rendered_.size() == k.gravity.size();
  s.joints = isSound && s.obstacle >= 0.0 ? static_cast<double>(frame.command.size()) : 0.0;
  const bool guided = frame.guide.size() == frame.command.size();  // the renderer knows the guides
  for (int j = 0; j < static_cast<int>(s.joints); ++j)
    s.added[j] = frame.command[j] - rendered_[j] - (guided ? frame.guide[j] : 0.0);
  std::copy_backward(s.sent.begin(), s.sent.end() - 1, s.sent.end());
  Eigen::Map<Vec3> newest(s.sent[0].data());
  newest.setZero();
  if (isSound) newest = wrenchOf(k, frame.command - k.gravity).head<3>();
}

void TapTransient::saveState(double* state) const noexcept { std::memcpy(state, &state_, sizeof state_); }

void TapTransient::loadState(const double* state) noexcept {
  std::memcpy(static_cast<void*>(&state_), state, sizeof state_);
  const State& s = state_;
  bool isSound = s.joints >= 0.0 && s.joints <= kMaxJoints && s.missed >= 0.0 && s.missed <= kTapMissed &&
                 std::abs(s.obstacle) <= kTapObstacles &&
                 (s.obstacle < 0.0 || (s.mass > 0.0 && s.speed > 0.0 && s.frequency > 0.0));
  for (std::size_t i = 0; i < kNumbers; ++i) isSound = isSound && std::isfinite(state[i]);
  if (!isSound) reset();
}

}  // namespace enamel
