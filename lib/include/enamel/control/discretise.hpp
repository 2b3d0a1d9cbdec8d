// From continuous to sampled models.
#pragma once

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Matrix exponential e^A of a square matrix.
///
/// Pade approximant of degree 13 with scaling and squaring; the scaling follows from the norms of powers of A
/// (Al-Mohy and Higham 2009, algorithm 5.1), so that A far from normal is not scaled too much. It is e^A - I that
/// is squared, E <- 2 E + E E: slow modes keep their digits beside fast ones.
/// Throws DesignError: not square, not finite, the result overflows. Realtime: no.
Eigen::MatrixXd matrixExponential(const Eigen::MatrixXd& A);

/// Zero-order hold ("A Position-Control Based Approach ...", eq. 10): A_d = e^{A Ts}, B_d = int_0^Ts e^{A t} dt B,
/// both from the block exponential exp([A B; 0 0] Ts) = [A_d B_d; 0 I] (Van Loan 1978): A may be singular.
/// Throws DesignError: sizes, period (s) not positive, entries not finite. Realtime: no.
StateSpace zeroOrderHold(const StateSpace& continuous, double period);

}  // namespace enamel
