#include "control/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <string>

#include "enamel/core/error.hpp"

// Complex products and systems are written as real ones: each further kind of decomposition compiles for seconds.
namespace enamel {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

double norm1(const MatrixXd& A) { return A.cwiseAbs().colwise().sum().maxCoeff(); }

MatrixXd product(const MatrixXd& A, const MatrixXd& B) { return A * B; }
MatrixXd solve(const MatrixXd& A, const MatrixXd& B) { return Eigen::PartialPivLU<MatrixXd>(A).solve(B); }

MatrixXcd product(const MatrixXcd& A, const MatrixXcd& B) {
  const MatrixXd a = A.real(), b = A.imag(), c = B.real(), d = B.imag();
  MatrixXcd C(A.rows(), B.cols());
  C.real() = product(a, c) - product(b, d);
  C.imag() = product(a, d) + product(b, c);
  return C;
}

MatrixXcd solve(const MatrixXcd& A, const MatrixXcd& B) {
  const Eigen::Index n = A.rows(), m = B.cols();
  MatrixXd left(2 * n, 2 * n), right(2 * n, m);
  left.topLeftCorner(n, n) = left.bottomRightCorner(n, n) = A.real();
  left.topRightCorner(n, n) = -A.imag();
  left.bottomLeftCorner(n, n) = A.imag();
  right.topRows(n) = B.real();
  right.bottomRows(n) = B.imag();
  const MatrixXd x = solve(left, right);
  MatrixXcd X(n, m);
  X.real() = x.topRows(n);
  X.imag() = x.bottomRows(n);
  return X;
}

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
