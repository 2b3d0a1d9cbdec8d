#pragma once

#include <Eigen/Core>

namespace enamel::test {

/// Return the largest difference, divided by the largest entry of the reference.
double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference);

}  // namespace enamel::test
