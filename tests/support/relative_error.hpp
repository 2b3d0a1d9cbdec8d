#pragma once

#include <Eigen/Core>

namespace enamel::test {

/// Largest difference over the largest entry of the reference.
inline double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference) {
  return (value - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
}

}  // namespace enamel::test
