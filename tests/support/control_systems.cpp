#include "support/control_systems.hpp"

#include "support/reference.hpp"

namespace enamel::test {

Eigen::MatrixXd randomMatrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(
      rows, columns, [&random] { return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0; });
}

Eigen::MatrixXd reference(const char* key) { return referenceServo(key); }

StateSpace referencePlant() { return {reference("A"), reference("B")}; }

}  // namespace enamel::test
