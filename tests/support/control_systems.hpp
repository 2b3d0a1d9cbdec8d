// Plants for the tests of the control module.
#pragma once

#include <Eigen/Core>
#include <random>

#include "enamel/control/state_space.hpp"
#include "support/relative_error.hpp"

namespace enamel::test {

/// n x m numbers in [-1, 1), the same bits for a seed everywhere (mt19937_64 is fixed by the standard).
Eigen::MatrixXd randomMatrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns);

/// A matrix of data/reference/servo-nominal.json.
Eigen::MatrixXd reference(const char* key);

StateSpace referencePlant();

}  // namespace enamel::test
