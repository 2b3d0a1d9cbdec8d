// Dense linear algebra, compiled once: each shape of expression costs a second of compile time in Eigen.
#pragma once

#include <Eigen/Core>

namespace enamel {

double norm1(const Eigen::MatrixXd& A);  ///< largest sum of absolute values in a column

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::MatrixXcd product(const Eigen::MatrixXcd& A, const Eigen::MatrixXcd& B);

/// Return A^-1 B by LU with partial pivoting. It is not finite if A is singular.
Eigen::MatrixXd solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::MatrixXcd solve(const Eigen::MatrixXcd& A, const Eigen::MatrixXcd& B);

/// Return the eigenvalues. Throws DesignError if the iteration does not converge.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

/// Return the singular values from the largest to the smallest.
Eigen::VectorXd singularValues(const Eigen::MatrixXcd& M);

}  // namespace enamel
