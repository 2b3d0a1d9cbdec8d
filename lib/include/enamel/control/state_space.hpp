// Linear time-invariant models.
#pragma once

#include <Eigen/Core>

namespace enamel {

/// Linear model with n states and m inputs. Continuous: x' = A x + B u. Sampled: x[j+1] = A x[j] + B u[j].
struct StateSpace {
  Eigen::MatrixXd A;  ///< n x n
  Eigen::MatrixXd B;  ///< n x m
};

}  // namespace enamel
