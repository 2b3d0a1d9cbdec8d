#include "control/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <string>

#include "enamel/core/error.hpp"

namespace enamel {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

MatrixXd product(const MatrixXd& A, const MatrixXd& B) { return A * B; }
MatrixXcd product(const MatrixXcd& A, const MatrixXcd& B) { return A * B; }

MatrixXd solve(const MatrixXd& A, const MatrixXd& B, double* reciprocalCondition) {
  const Eigen::PartialPivLU<MatrixXd> lu(A);
  if (reciprocalCondition != nullptr) *reciprocalCondition = lu.rcond();
  return lu.solve(B);
}

MatrixXcd solve(const MatrixXcd& A, const MatrixXcd& B) { return Eigen::PartialPivLU<MatrixXcd>(A).solve(B); }

Eigen::VectorXcd eigenvalues(const MatrixXd& A) {
  if (A.rows() != A.cols() || A.rows() == 0 || !A.allFinite())
    throw DesignError("eigenvalues: the matrix is " + std::to_string(A.rows()) + " x " + std::to_string(A.cols()) +
                      ", must be square, finite and not empty");
  const Eigen::EigenSolver<MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) throw DesignError("eigenvalues: the iteration does not converge");
  return solver.eigenvalues();
}

Eigen::VectorXd singularValues(const MatrixXcd& M) {
  // Pad with zeros to a square matrix. This avoids a QR decomposition, which compiles for half a minute.
  const Eigen::Index size = std::max(M.rows(), M.cols());
  MatrixXcd square = MatrixXcd::Zero(size, size);
  square.topLeftCorner(M.rows(), M.cols()) = M;
  return Eigen::JacobiSVD<MatrixXcd, Eigen::NoQRPreconditioner>(square).singularValues().head(
      std::min(M.rows(), M.cols()));
}

}  // namespace enamel
