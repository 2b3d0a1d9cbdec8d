// A file of its own: what it instantiates is compiled once, not for every test.
#include "support/control_systems.hpp"

#include <Eigen/Eigenvalues>

#include "support/reference.hpp"

namespace enamel::test {

Eigen::MatrixXd randomMatrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(
      rows, columns, [&random] { return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0; });
}

double radius(const Eigen::MatrixXd& A) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}

Eigen::MatrixXd reference(const char* key) {
  static const nlohmann::json file = referenceFile("servo-nominal.json");
  return matrixFrom(file.at(key));
}

StateSpace referencePlant() { return {reference("A"), reference("B")}; }

}  // namespace enamel::test
