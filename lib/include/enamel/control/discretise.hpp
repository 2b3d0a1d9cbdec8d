// Conversion from continuous to sampled models.
#pragma once

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Return the matrix exponential e^A of a square matrix.
///
/// The method is the Pade approximant of degree 13 with scaling and squaring. The scaling follows from the norms of
/// powers of A (Al-Mohy and Higham 2009, algorithm 5.1). This avoids too much scaling of a matrix that is far from
/// normal. The squaring works on E = e^A - I, with E <- 2 E + E E, so that slow modes keep their digits beside fast
/// modes.
///
/// Throws DesignError: A is not square or not finite; the result overflows. Realtime: no.
Eigen::MatrixXd matrixExponential(const Eigen::MatrixXd& A);

/// Return the zero-order hold of a model ("A Position-Control Based Approach ...", eq. 10): A_d = e^{A Ts},
/// B_d = int_0^Ts e^{A t} dt B.
///
/// Both follow from one block exponential, so A may be singular: exp([A B; 0 0] Ts) = [A_d B_d; 0 I] (Van Loan 1978).
/// Throws DesignError: sizes do not match; `period` (s) is not positive; an entry is not finite. Realtime: no.
StateSpace zeroOrderHold(const StateSpace& continuous, double period);

}  // namespace enamel
