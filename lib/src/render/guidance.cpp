#include "enamel/render/guidance.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "device/inertia.hpp"

namespace enamel {
namespace {

// With these numbers, the linear loop is stable with 0.6 of the mass or more at delays of up to 3 ticks. It damps
// motions of the hand below 36 Hz at 1 kHz (lib/docs/guides.md, tests/unit/guidance.cpp).
constexpr double kLead = 10.0;       // damping over stiffness, periods
constexpr double kSmoothing = 0.4;   // gain per sample of the filter for the velocity
constexpr double kGuidePhase = 0.1;  // largest sqrt(k / m), 1/periods
// Of the law over its spring, at any frequency: that at half the rate of the ticks, 6.
constexpr double kLargestGain = 1.0 + 2.0 * kLead * kSmoothing / (2.0 - kSmoothing);
constexpr double kGuideRamp = 0.1;  // s
constexpr double kGuideGap = 0.1;   // s: after a longer time between samples the velocity is unknown

Vec3 limitedTo(double most, const Vec3& force) noexcept {
  const double size = force.norm();
  return size > most ? Vec3(most / size * force) : force;
}

// Largest sqrt(k / m), 1/s, at which no mode of rotors and links loses more damping than its cables have, at any delay.
double frequencyWithCables(const Mechanism& mechanism) {
  const Drive& drive = mechanism.limits().drive;
  double square = std::numeric_limits<double>::infinity();
  if (!(drive.stiffness > 0.0)) return square;
  JointMatrix axes;
  for (const double inertia : eigenvaluesOf(mechanism.home().inertia, axes)) {
    const double rotor = drive.rotorInertia, link = inertia - rotor,
                 resonance = std::sqrt(drive.stiffness * inertia / (rotor * link)),
                 coupling =
                     link * (drive.encoderOnLink ? rotor : link) / inertia;  // from motor to encoder, kg m^2 or kg
    square = std::min(square, drive.damping * resonance / (kLargestGain * coupling));
  }
  return std::sqrt(square);
}

}  // namespace

Guidance::Guidance(const Mechanism& mechanism, double period)
    : mass_(1.0 / eigenvaluesOf(inverseInertiaOf(mechanism.home()).topLeftCorner<3, 3>())[2]),
      frequency_(std::min(kGuidePhase / period, frequencyWithCables(mechanism))),
      period_(period),
      scale_(mechanism.scale()) {}

double Guidance::largestStiffness() const noexcept { return scale_ * mass_ * frequency_ * frequency_; }

Vec3 Guidance::step(const std::vector<Guide>& guides, TickFrame& frame) noexcept {
  State& s = state_;
  frame.guided.setZero();
  Eigen::Map<Vec3> position(s.position.data()), velocity(s.velocity.data()), last(s.force.data()),
      elastic(s.elastic.data());
  if (frame.age > 0) return last;
  double sum = 0.0;
  for (const Guide& guide : guides) sum += guide.stiffness;
  const double share = std::min(largestStiffness() / sum, 1.0) / scale_;  // the force at the hand is scale times ours
  const double elapsed = frame.time - s.time;
  const Vec3& now = frame.kinematics.pose.position;
  if (s.started != 0.0 && elapsed > 0.0 && elapsed <= kGuideGap)
    velocity += kSmoothing * ((now - position) / elapsed - velocity);
  else
    velocity.setZero();
  Vec3 force = Vec3::Zero(), still = Vec3::Zero();
  for (const Guide& guide : guides) {
    const double k = share * guide.stiffness, most = guide.maxForce / scale_;
    if (!(k > 0.0)) continue;
    const GuideError error = errorOf(guide, now, velocity);
    const Vec3 wanted = k * (error.offset + kLead * period_ * error.rate);
    still -= limitedTo(most, k * error.offset);
    if (!error.isRegion || wanted.dot(error.offset) > 0.0) force -= limitedTo(most, wanted);
  }
  if (s.started != 0.0) frame.guided = 0.5 * s.acting * (elastic + still);
  s.time = frame.time;
  s.started = 1.0;
  s.ramp = std::min(1.0, s.ramp + period_ / kGuideRamp);
  position = now;
  elastic = still;
  last = s.ramp * force;
  return last;
}

void Guidance::saveState(double* state) const noexcept { std::memcpy(state, &state_, sizeof state_); }

void Guidance::loadState(const double* state) noexcept {
  std::memcpy(static_cast<void*>(&state_), state, sizeof state_);
  bool isSound = state_.ramp >= 0.0 && state_.ramp <= 1.0;
  for (std::size_t i = 0; i < kNumbers; ++i) isSound = isSound && std::isfinite(state[i]);
  if (!isSound) reset();
}

}  // namespace enamel
