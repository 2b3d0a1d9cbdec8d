#include "control/servo_design.hpp"

#include <cmath>
#include <string>

#include "enamel/control/discretise.hpp"
#include "enamel/control/riccati.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

StateSpace augmentWithIntegrals(const StateSpace& plant) {
  const Index n = plant.B.cols();
  if (n == 0 || plant.A.rows() != 2 * n || plant.A.cols() != 2 * n || plant.B.rows() != 2 * n)
    throw DesignError("servo design: for " + std::to_string(n) + " inputs the plant must have " +
                      std::to_string(2 * n) + " states [q'; q]; A is " + std::to_string(plant.A.rows()) + " x " +
                      std::to_string(plant.A.cols()));
  StateSpace augmented{MatrixXd::Zero(3 * n, 3 * n), MatrixXd::Zero(3 * n, n)};
  augmented.A.topLeftCorner(2 * n, 2 * n) = plant.A;
  augmented.A.block(2 * n, n, n, n) = -MatrixXd::Identity(n, n);
  augmented.B.topRows(2 * n) = plant.B;
  return augmented;
}

ServoDesign servoModels(const StateSpace& plant, double period) {
  return {period, {}, plant, zeroOrderHold(augmentWithIntegrals(plant), period), {}, {}};
}

ServoDesign designServo(const StateSpace& plant, double period, const ServoWeights& weights) {
  return designServo(servoModels(plant, period), weights);
}

ServoDesign designServo(const ServoDesign& models, const ServoWeights& weights) {
  const Index n = models.plant.B.cols();
  for (const double weight : {weights.velocity, weights.position, weights.integral})
    if (!(weight >= 0.0 && std::isfinite(weight)))
      throw DesignError("servo design: a weight is negative or not finite");
  if (!(weights.torque > 0.0 && std::isfinite(weights.torque)))
    throw DesignError("servo design: the weight of the torque must be positive");
  ServoDesign design = models;
  design.weights = weights;
  VectorXd q(3 * n);
  q << VectorXd::Constant(n, weights.velocity), VectorXd::Constant(n, weights.position),
      VectorXd::Constant(n, weights.integral);
  RiccatiSolution solution =
      solveRiccati(design.augmented.A, design.augmented.B, q.asDiagonal(), weights.torque * MatrixXd::Identity(n, n));
  design.P = std::move(solution.P);
  design.K = std::move(solution.K);
  return design;
}

DelayedServo servoForDelay(const ServoDesign& design, int delay) {
  if (delay < 0 || delay > 100)
    throw DesignError("servo design: the delay is " + std::to_string(delay) + " samples, must be in 0 to 100");
  const Index n = design.K.rows();
  DelayedServo servo{design.K, MatrixXd(n, n * delay)};
  for (Index i = 0; i < delay; ++i) {
    servo.commandGain.middleCols(n * i, n) = servo.K * design.augmented.B;
    servo.K = (servo.K * design.augmented.A).eval();
  }
  return servo;
}

StateSpace runningLoop(const ServoDesign& design) {
  const Index n = design.K.rows();
  if (n == 0 || design.K.cols() != 3 * n || design.augmented.A.rows() != 3 * n || design.augmented.A.cols() != 3 * n ||
      design.augmented.B.rows() != 3 * n || design.augmented.B.cols() != n)
    throw DesignError("servo design: the augmented model must have 3n states and n inputs, as the gain has");
  StateSpace loop = design.augmented;  // the integrators feed nothing back, so the plant's own block is exact
  loop.A.bottomRows(n).setZero();
  loop.A.bottomRightCorner(n, n).setIdentity();
  loop.A.block(2 * n, n, n, n) = -design.period * MatrixXd::Identity(n, n);
  loop.B.bottomRows(n).setZero();
  return loop;
}

}  // namespace enamel
