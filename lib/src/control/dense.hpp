// Dense linear algebra, compiled once: Eigen's templates take a second of compiler for every shape of expression.
#pragma once

#include <Eigen/Core>

namespace enamel {

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::MatrixXcd product(const Eigen::MatrixXcd& A, const Eigen::MatrixXcd& B);

/// A^-1 B by LU with partial pivoting, and 1 / cond(A) in the norm of column sums, estimated.
Eigen::MatrixXd solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double* reciprocalCondition = nullptr);
Eigen::MatrixXcd solve(const Eigen::MatrixXcd& A, const Eigen::MatrixXcd& B);

/// Throws DesignError where the iteration does not converge.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

/// From the largest to the smallest.
Eigen::VectorXd singularValues(const Eigen::MatrixXcd& M);

}  // namespace enamel
