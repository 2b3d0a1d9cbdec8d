#include "enamel/control/servo_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/message.hpp"
#include "enamel/control/first_impact.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kMostTicks = 10000000;

int runTicks(double seconds, double period) {
  const double ticks = seconds / period;
  if (!(ticks >= 0.0 && ticks <= kMostTicks))
    throw DesignError("servo simulation: the period is " + formatNumber(period) +
                      " s, must be positive and a run at most 1e7 ticks");
  return static_cast<int>(std::lround(ticks));
}

// K must be n x 3n for a plant with n inputs and 2n states.
void requireGain(const ServoDesign& design) {
  const Index n = design.K.rows();
  if (n == 0 || design.K.cols() != 3 * n)
    throw DesignError("servo simulation: the gain K is " + std::to_string(n) + " x " + std::to_string(design.K.cols()) +
                      ", must be n x 3n");
}

}  // namespace

SampledPlant linearPlant(const ServoDesign& design, const MatrixXd& jacobian) {
  requireGain(design);
  const Index n = design.K.rows(), states = 2 * n;
  if (design.augmented.A.rows() < states || design.augmented.A.cols() < states || design.augmented.B.rows() < states ||
      design.augmented.B.cols() != n || jacobian.rows() != 6 || jacobian.cols() != n)
    throw DesignError("servo simulation: the held model must have 2n states and n inputs, the Jacobian must be 6 x n");
  return
      [A = MatrixXd(design.augmented.A.topLeftCorner(states, states)), B = MatrixXd(design.augmented.B.topRows(states)),
       transposed = MatrixXd(jacobian.transpose())](const VectorXd& y, const VectorXd& torque, const VectorXd& wrench) {
        return VectorXd(A * y + B * (torque + transposed * wrench));
      };
}

ServoTrace simulateServo(const ServoDesign& design, const SampledPlant& plant, const ServoExperiment& experiment) {
  requireGain(design);
  const Index n = design.K.rows();
  const auto isVector = [n](const VectorXd& v) { return v.size() == 0 || v.size() == n; };
  if (experiment.reference.size() != n || !isVector(experiment.encoderStep) || !isVector(experiment.maxTorque) ||
      experiment.wrench.size() != 6 || experiment.delay < 0 || experiment.ticks < 0 || experiment.ticks > kMostTicks)
    throw DesignError(
        "servo simulation: reference, encoder steps and torque limits need one entry a joint, the wrench needs six; "
        "delay and ticks must be at least 0, the ticks at most 1e7");
  ServoTrace trace{MatrixXd::Zero(2 * n, experiment.ticks + 1), MatrixXd::Zero(n, experiment.ticks)};
  VectorXd y = VectorXd::Zero(2 * n), state = VectorXd::Zero(3 * n), previous = VectorXd::Zero(n);
  for (int j = 0; j < experiment.ticks; ++j) {
    VectorXd q = y.tail(n), rate = y.head(n);
    if (experiment.encoderStep.size() > 0) {
      q = experiment.encoderStep.array() * (q.array() / experiment.encoderStep.array()).round();
      rate = (q - previous) / design.period;
      previous = q;
    }
    state.head(n) = rate;
    state.segment(n, n) = q;
    VectorXd torque = -design.K * state;
    if (experiment.maxTorque.size() > 0)
      torque = torque.cwiseMax(-experiment.maxTorque).cwiseMin(experiment.maxTorque).eval();
    trace.torque.col(j) = torque;
    state.tail(n) += design.period * (experiment.reference - q);
    const int acting = j - experiment.delay;
    y = plant(y, acting < 0 ? VectorXd(VectorXd::Zero(n)) : VectorXd(trace.torque.col(acting)), experiment.wrench);
    if (y.size() != 2 * n) throw DesignError("servo simulation: the plant must return 2n numbers");
    trace.y.col(j + 1) = y;
  }
  return trace;
}

double firstImpactStiffness(const ServoTrace& trace, const Eigen::RowVectorXd& normal, double force, double period) {
  const Index n = normal.size();
  if (n == 0 || trace.y.rows() != 2 * n || !(period > 0.0))
    throw DesignError("first impact: the normal needs one entry a joint, the period must be greater than 0 s");
  (void)runTicks(1.0, period);
  ImpactMonitor watch(period);
  ImpactTick tick;
  tick.force = force;
  for (Index j = 0; j < trace.y.cols(); ++j) {
    tick.gap = normal * trace.y.col(j).tail(n);
    tick.rate = normal * trace.y.col(j).head(n);
    watch.push(tick);
  }
  return watch.depth() > 0.0 ? watch.stiffness() : std::numeric_limits<double>::quiet_NaN();
}

double torqueDeviation(const ServoTrace& trace, int ticks) {
  if (ticks < 1 || trace.torque.size() == 0)
    throw DesignError("torque deviation: at least one tick and one joint are required");
  const MatrixXd last = trace.torque.rightCols(std::min<Index>(ticks, trace.torque.cols()));
  const VectorXd mean = last.rowwise().mean();
  return std::sqrt((last.colwise() - mean).rowwise().squaredNorm().maxCoeff() / static_cast<double>(last.cols()));
}

double Requirement::worst() const {
  double worst = 0.0;
  for (const double value : values) worst = std::isfinite(value) ? std::max(worst, value) : HUGE_VAL;
  return worst;
}

namespace {

constexpr double kStep = 0.01;     // rad
constexpr double kForce = 10.0;    // N
constexpr double kMoment = 0.1;    // N m
constexpr double kDuration = 1.0;  // s
constexpr double kRiseLow = 0.1, kRiseHigh = 0.9, kSettled = 0.02;

// Time at which a response (1 = reached) first passes `level`, interpolated between ticks. Infinite if it never does.
double passes(const Eigen::RowVectorXd& response, double level, double period) {
  for (Index j = 1; j < response.size(); ++j)
    if (response[j] >= level)
      return period * (static_cast<double>(j) - (response[j] - level) / (response[j] - response[j - 1]));
  return HUGE_VAL;
}

// Time after which a response stays within +-band of 1. Infinite if it never does.
double settles(const Eigen::RowVectorXd& response, double band, double period) {
  Index j = response.size() - 1;
  if (!(std::abs(response[j] - 1.0) <= band)) return HUGE_VAL;
  while (j > 0 && std::abs(response[j - 1] - 1.0) <= band) --j;
  if (j == 0) return 0.0;
  const double outside = std::abs(response[j - 1] - 1.0), inside = std::abs(response[j] - 1.0);
  return period * (static_cast<double>(j) - (band - inside) / (outside - inside));
}

}  // namespace

std::vector<Requirement> measureRequirements(const ServoDesign& design, const SampledPlant& plant,
                                             const MatrixXd& jacobian) {
  requireGain(design);
  const Index n = design.K.rows();
  if (jacobian.rows() != 6 || jacobian.cols() != n) throw DesignError("Table II: the Jacobian must be 6 x n");
  Requirement overshoot{"step reference: overshoot", "%", 2.0, {}};
  Requirement rise{"step reference: rise time", "s", 0.05, {}};
  Requirement settling{"step reference: settling time", "s", 0.1, {}};
  Requirement joints{"force/torque step: joint deviation", "rad", 0.001, {}};
  Requirement position{"force/torque step: TCP position deviation", "m", 0.001, {}};
  Requirement orientation{"force/torque step: TCP orientation deviation", "rad", 0.001, {}};
  ServoExperiment experiment;
  experiment.ticks = runTicks(kDuration, design.period);
  for (Index joint = 0; joint < n; ++joint) {
    experiment.reference = kStep * VectorXd::Unit(n, joint);
    experiment.wrench = VectorXd::Zero(6);
    const Eigen::RowVectorXd response = simulateServo(design, plant, experiment).y.row(n + joint) / kStep;
    overshoot.values.push_back(100.0 * std::max(0.0, response.maxCoeff() - 1.0));
    rise.values.push_back(passes(response, kRiseHigh, design.period) - passes(response, kRiseLow, design.period));
    settling.values.push_back(settles(response, kSettled, design.period));
  }
  for (Index axis = 0; axis < 6; ++axis) {
    experiment.reference = VectorXd::Zero(n);
    experiment.wrench = (axis < 3 ? kForce : kMoment) * VectorXd::Unit(6, axis);
    const MatrixXd q = simulateServo(design, plant, experiment).y.bottomRows(n), X = jacobian * q;
    joints.values.push_back(q.cwiseAbs().maxCoeff());
    position.values.push_back(X.topRows(3).colwise().norm().maxCoeff());
    orientation.values.push_back(X.bottomRows(3).colwise().norm().maxCoeff());
  }
  return {overshoot, rise, settling, joints, position, orientation};
}

}  // namespace enamel
