// Plants for the tests of the control module.
#pragma once

#include <Eigen/Core>
#include <random>

#include "enamel/control/state_space.hpp"
#include "support/relative_error.hpp"

namespace enamel::test {

/// Return n x m numbers in [-1, 1), with the same bits for a seed on every machine (the standard defines mt19937_64).
Eigen::MatrixXd randomMatrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns);

/// Return a matrix of data/reference/servo-nominal.json.
Eigen::MatrixXd reference(const char* key);

StateSpace referencePlant();

}  // namespace enamel::test
