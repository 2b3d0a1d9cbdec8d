// Numerically hard problems with known solutions. The benchmark prints their errors beside the times, and the hard
// tests check the errors.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace enamel::bench {

/// A discrete Riccati equation and its stabilising solution X. All but the last group are from Benner, Laub and
/// Mehrmann, "DAREX".
struct RiccatiCase {
  std::string name;
  Eigen::MatrixXd A, B, Q, R;
  Eigen::MatrixXd X;  ///< exact solution, rounded to double
  double bound;       ///< allowed forward error, relative to the largest entry of X
};

std::vector<RiccatiCase> riccatiCases();

/// A matrix and its exponential.
struct ExponentialCase {
  std::string name;
  Eigen::MatrixXd A, exponential;
  double bound;  ///< allowed error of each entry, relative to the entry
};

std::vector<ExponentialCase> exponentialCases();

/// Return the largest |value - reference| / |reference| over the entries; the absolute error if the reference entry is
/// zero.
double entrywiseError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference);

}  // namespace enamel::bench
