#include "control/spectrum.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>

#include "enamel/core/error.hpp"

namespace enamel {

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) throw DesignError("the eigenvalues of a matrix do not converge");
  return solver.eigenvalues();
}

Eigen::VectorXd singularValues(const Eigen::MatrixXcd& M) {
  // Rows or columns of zeros make it square: that needs no QR decomposition, which compiles for half a minute.
  const Eigen::Index size = std::max(M.rows(), M.cols());
  Eigen::MatrixXcd square = Eigen::MatrixXcd::Zero(size, size);
  square.topLeftCorner(M.rows(), M.cols()) = M;
  return Eigen::JacobiSVD<Eigen::MatrixXcd, Eigen::NoQRPreconditioner>(square).singularValues().head(
      std::min(M.rows(), M.cols()));
}

}  // namespace enamel
