// Numerically hard problems with known solutions: the benchmark shows error beside time, the hard tests check the
// error.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace enamel::bench {

/// A discrete Riccati equation and its stabilising solution X. All but the last group: Benner, Laub and Mehrmann,
/// "DAREX".
struct RiccatiCase {
  std::string name;
  Eigen::MatrixXd A, B, Q, R;
  Eigen::MatrixXd X;  ///< exact, as rounded
  double bound;       ///< forward error allowed, relative to the largest entry of X
};

std::vector<RiccatiCase> riccatiCases();

/// A matrix and its exponential.
struct ExponentialCase {
  std::string name;
  Eigen::MatrixXd A, exponential;
  double bound;  ///< error allowed, entry by entry, relative to the entry
};

std::vector<ExponentialCase> exponentialCases();

/// Largest |value - reference| / |reference| over the entries; an entry that must be zero counts absolutely.
double entrywiseError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference);

}  // namespace enamel::bench
