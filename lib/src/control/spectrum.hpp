// Decompositions that compile slowly, in one place.
#pragma once

#include <Eigen/Core>

namespace enamel {

/// Throws DesignError where the iteration does not converge.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

/// From the largest to the smallest.
Eigen::VectorXd singularValues(const Eigen::MatrixXcd& M);

}  // namespace enamel
