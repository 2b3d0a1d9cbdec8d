// Linear time-invariant models.
#pragma once

#include <Eigen/Core>

namespace enamel {

/// x' = A x + B u where continuous, x[j+1] = A x[j] + B u[j] where sampled; n states, m inputs.
struct StateSpace {
  Eigen::MatrixXd A;  ///< n x n
  Eigen::MatrixXd B;  ///< n x m
};

}  // namespace enamel
