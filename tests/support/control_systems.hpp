// Plants for the tests of the control module.
#pragma once

#include <Eigen/Eigenvalues>
#include <random>

#include "enamel/control/state_space.hpp"
#include "support/reference.hpp"

namespace enamel::test {

/// n x m numbers in [-1, 1), the same bits for a seed everywhere (mt19937_64 is fixed by the standard).
inline Eigen::MatrixXd randomMatrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(
      rows, columns, [&random] { return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0; });
}

inline double radius(const Eigen::MatrixXd& A) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}

/// A matrix of data/reference/servo-nominal.json.
inline Eigen::MatrixXd reference(const char* key) {
  static const nlohmann::json file = referenceFile("servo-nominal.json");
  return matrixFrom(file.at(key));
}

inline StateSpace referencePlant() { return {reference("A"), reference("B")}; }

}  // namespace enamel::test
