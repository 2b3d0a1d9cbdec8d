#include "enamel/control/tuning.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "control/servo_design.hpp"
#include "core/message.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kImpactSeconds = 0.2;   // the first impact is over much earlier
constexpr double kChatterSeconds = 1.5;  // only the last second counts

using LogWeights = std::array<double, 3>;  // log10 of velocity, position, integral

ServoWeights weightsOf(const LogWeights& w) {
  return {std::pow(10.0, w[0]), std::pow(10.0, w[1]), std::pow(10.0, w[2]), 1.0};
}

int ticksOf(double seconds, double period) { return static_cast<int>(std::lround(seconds / period)); }

bool keepsTo(const TuneProblem& problem, const TuneRequirements& requirements, const TunedServo& servo) {
  if (!(servo.chatter <= requirements.chatter)) return false;
  if (!requirements.stepResponse) return true;
  const auto rows = measureRequirements(servo.design, linearPlant(servo.design, problem.jacobian), problem.jacobian);
  return std::all_of(rows.begin(), rows.begin() + 3, [](const Requirement& row) { return row.met(); });
}

// As evaluateServo(). Also empty if the stiffness is not above `toBeat`, or the disk margin is below `leastMargin`.
// Both are known long before the rest.
std::optional<TunedServo> evaluate(const TuneProblem& problem, const ServoDesign& models, int delay,
                                   const ServoWeights& weights, double toBeat, double leastMargin) {
  TunedServo servo;
  try {
    servo.design = designServo(models, weights);
  } catch (const DesignError&) {
    return std::nullopt;  // these weights have no stabilising solution
  }
  const SampledPlant plant = linearPlant(servo.design, problem.jacobian);
  ServoExperiment experiment;
  experiment.reference = Eigen::VectorXd::Zero(servo.design.K.rows());
  experiment.wrench = -problem.push * Eigen::VectorXd::Unit(6, 2);
  experiment.delay = delay;
  experiment.maxTorque = problem.maxTorque;
  experiment.ticks = ticksOf(kImpactSeconds, problem.period);
  servo.stiffness = firstImpactStiffness(simulateServo(servo.design, plant, experiment), problem.jacobian.row(2),
                                         problem.push, problem.period);
  if (!(servo.stiffness > toBeat)) return std::nullopt;
  const StateSpace loop = runningLoop(servo.design);
  servo.toleratedDelay = toleratedDelay(loop, servo.design.K);
  if (servo.toleratedDelay < delay) return std::nullopt;
  servo.diskMargin = diskMargin(loop, servo.design.K, problem.period, delay, leastMargin);
  if (servo.diskMargin < leastMargin) return std::nullopt;
  experiment.ticks = ticksOf(kChatterSeconds, problem.period);
  experiment.encoderStep = problem.encoderStep;
  servo.chatter = torqueDeviation(simulateServo(servo.design, plant, experiment), ticksOf(1.0, problem.period));
  return servo;
}

}  // namespace

std::optional<TunedServo> evaluateServo(const TuneProblem& problem, int delay, const ServoWeights& weights) {
  requirePeriod(problem.period, "servo: ");
  return evaluate(problem, servoModels(problem.plant, problem.period), delay, weights, 0.0, 0.0);
}

std::optional<TunedServo> tuneServo(const TuneProblem& problem, const TuneRequirements& requirements) {
  requirePeriod(problem.period, "servo: ");
  const ServoDesign models = servoModels(problem.plant, problem.period);
  std::optional<TunedServo> best;
  LogWeights at{};
  const auto improve = [&](const LogWeights& candidate) {
    const double toBeat = best ? best->stiffness : 0.0;
    std::optional<TunedServo> servo =
        evaluate(problem, models, requirements.delay, weightsOf(candidate), toBeat, requirements.diskMargin);
    if (!servo || !keepsTo(problem, requirements, *servo)) return false;
    best = std::move(servo);
    at = candidate;
    return true;
  };
  for (double velocity = -4.0; velocity <= 3.0; velocity += 1.0)
    for (double position = 0.0; position <= 7.0; position += 0.5)
      for (double integral = 0.0; integral <= 12.0; integral += 0.5) improve({velocity, position, integral});
  if (!best) return best;
  for (double step = 0.5; step > 0.02; step *= 0.5) {
    bool improved = true;
    while (improved) {
      improved = false;
      for (int direction = 0; direction < 27; ++direction) {  // diagonals too: the best servos lie on ridges
        const int x = direction % 3 - 1, y = direction / 3 % 3 - 1, z = direction / 9 - 1;
        improved = improve({at[0] + step * x, at[1] + step * y, at[2] + step * z}) || improved;
      }
    }
  }
  return best;
}

double firstImpactLimit(double mass, double period, int delay, double force, double largestForce,
                        double preload) noexcept {
  if (!(largestForce > std::max(force, preload)) || delay < 0 || !(period > 0.0)) return 0.0;
  const double reaction = (delay + 1) * period;
  return 2.0 * mass * (largestForce - force) / (largestForce - preload) / (reaction * reaction);
}

}  // namespace enamel
