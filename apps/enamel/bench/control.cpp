#include <algorithm>

#include "bench/control_cases.hpp"
#include "bench/long_matrix.hpp"
#include "bench/measurement.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/control/discretise.hpp"
#include "enamel/control/riccati.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/mechanism.hpp"

namespace enamel::bench {
namespace {

using Eigen::MatrixXd;

constexpr double kRiccatiGoal_us = 250.0;

// Solve the Riccati equation by doubling in 80 bits, without balancing or refinement: a reference for the servo's
// design.
MatrixXd longDoubling(const MatrixXd& A0, const MatrixXd& B0, const MatrixXd& Q, const MatrixXd& R) {
  const LongMatrix B = B0.cast<long double>(), I = LongMatrix::Identity(A0.rows(), A0.rows());
  LongMatrix A = A0.cast<long double>(), H = Q.cast<long double>();
  LongMatrix G = times(B, solved(R.cast<long double>(), B.transpose()));
  for (int i = 0; i < 14; ++i) {
    const LongMatrix W = I + times(G, H), At = A.transpose();
    const LongMatrix WA = solved(W, A), WG = solved(W, G);
    H += times(At, times(H, WA));
    G += times(A, times(WG, At));
    A = times(A, WA);
  }
  return H.cast<double>();
}

// Return e^A from its series in 80 bits, for small A.
MatrixXd longExponential(const MatrixXd& A) {
  const LongMatrix scaled = A.cast<long double>() / 1024.0L;
  LongMatrix term = LongMatrix::Identity(A.rows(), A.cols()), sum = term;
  for (int i = 1; i < 24; ++i) {
    term = times(term, scaled) / static_cast<long double>(i);
    sum += term;
  }
  for (int i = 0; i < 10; ++i) sum = times(sum, sum);
  return sum.cast<double>();
}

}  // namespace

std::vector<Measurement> measureControl(double scale) {
  const int batches = std::max(10, static_cast<int>(60 * scale));
  std::vector<Measurement> rows;
  const auto add = [&](const std::string& name, int calls, double error, const char* errorOf, const auto& body) {
    const Timing t = timeCalls(batches, calls, [&](int, int count) {
      for (int i = 0; i < count; ++i) keep(body());
    });
    rows.push_back({"", name, t.median_us, t.p99_us, error, errorOf});
  };

  const DevicePlant device = devicePlant(std::make_shared<TauMechanism>(nominalDevice()), Pose{});
  const auto linear = [&device] { return linearise(device.f, device.h, device.x0, device.u0); };
  const Linearisation model = linear();
  add("linearise the device, 18 variables", 4, model.error, "relative, its own estimate", linear);

  const StateSpace plant = outputsAsStates(model), augmented = augmentWithIntegrals(plant);
  const ServoDesign design = designServo(plant, 1e-3, ServoWeights{});
  MatrixXd block = MatrixXd::Zero(24, 24);
  block << 1e-3 * augmented.A, 1e-3 * augmented.B, MatrixXd::Zero(6, 24);
  const MatrixXd exponential = longExponential(block);
  add("zero-order hold of the servo, 18 states", 20,
      std::max(relativeError(design.augmented.A, exponential.topLeftCorner(18, 18)),
               relativeError(design.augmented.B, exponential.topRightCorner(18, 6))),
      "relative, against an 80-bit series", [&] { return zeroOrderHold(augmented, 1e-3); });

  Eigen::VectorXd weights(18);
  weights << Eigen::VectorXd::Constant(6, 1.0), Eigen::VectorXd::Constant(6, 1e3), Eigen::VectorXd::Constant(6, 1e7);
  const MatrixXd Q = weights.asDiagonal(), R = MatrixXd::Identity(6, 6);
  const MatrixXd &A = design.augmented.A, &B = design.augmented.B;
  const MatrixXd P = longDoubling(A, B, Q, R);
  add("Riccati of the servo, 18 states", 10, relativeError(solveRiccati(A, B, Q, R).P, P),
      "P, relative, against doubling in 80 bits", [&] { return solveRiccati(A, B, Q, R); });
  rows.back().goal_us = kRiccatiGoal_us;
  for (const RiccatiCase& c : riccatiCases())
    add("Riccati, " + c.name, c.A.rows() > 50 ? 1 : 10, relativeError(solveRiccati(c.A, c.B, c.Q, c.R).P, c.X),
        "P, relative, exact solution", [&c] { return solveRiccati(c.A, c.B, c.Q, c.R); });
  for (const ExponentialCase& c : exponentialCases())
    add("exponential, " + c.name, 50, entrywiseError(matrixExponential(c.A), c.exponential),
        "every entry, relative, exact", [&c] { return matrixExponential(c.A); });
  return rows;
}

}  // namespace enamel::bench
