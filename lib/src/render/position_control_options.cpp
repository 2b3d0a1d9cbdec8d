#include <cmath>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/render/position_control.hpp"

namespace enamel {

PositionControlOptions positionControlFor(const Mechanism& mechanism, double period, int delayLow, int delayHigh) {
  const JointLimits& limits = mechanism.limits();
  return {period, limits.encoderStep, limits.effort, delayLow, delayHigh, limits.drive, mechanism.scale()};
}

void checkPositionControl(const PositionControlOptions& options) {
  const auto refuse = [](const std::string& what) { throw Error("position control: " + what); };
  const JointVector& step = options.encoderStep;
  if (step.size() < 1 || step.size() > kMaxJoints)
    refuse(std::to_string(step.size()) + " encoder steps, must be 1 to " + std::to_string(kMaxJoints));
  for (Eigen::Index j = 0; j < step.size(); ++j)
    if (!(step[j] > 0.0 && std::isfinite(step[j])))
      refuse("encoder step " + std::to_string(j) + " is " + formatNumber(step[j]) + ", must be positive");
  const JointVector& effort = options.effort;
  if (effort.size() != step.size())
    refuse(std::to_string(effort.size()) + " largest torques, must be one for each encoder step");
  for (Eigen::Index j = 0; j < effort.size(); ++j)
    if (!(effort[j] >= 0.0))
      refuse("largest torque " + std::to_string(j) + " is " + formatNumber(effort[j]) + ", must be 0 or more");
  if (options.delayLow < 0 || options.delayLow > options.delayHigh || options.delayHigh > kMaxLoopDelay)
    refuse("delay is " + std::to_string(options.delayLow) + " to " + std::to_string(options.delayHigh) +
           " ticks, must be within 0 to " + std::to_string(kMaxLoopDelay) + ", the smallest first");
  if (!(options.period >= 1e-5 && options.period <= 0.1))
    refuse("period is " + formatNumber(options.period) + " s, must be in 1e-5 to 0.1 s");
  if (!(options.scale > 0.0 && std::isfinite(options.scale)))
    refuse("scale is " + formatNumber(options.scale) + ", must be positive and finite");
  const Drive& d = options.drive;
  for (const double number : {d.bandwidth, d.rotorInertia, d.stiffness, d.damping, d.disturbance})
    if (!(number >= 0.0 && std::isfinite(number)))
      refuse("a parameter of the drive is " + formatNumber(number) + ", must be zero or positive");
  if (d.stiffness > 0.0 && !(d.rotorInertia > 0.0))
    refuse("a cable stiffness of " + formatNumber(d.stiffness) + " requires a rotor inertia greater than 0");
}

}  // namespace enamel
