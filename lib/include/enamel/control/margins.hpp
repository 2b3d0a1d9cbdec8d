// Stability margins of a sampled state-feedback loop.
#pragma once

#include <complex>
#include <vector>

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Margins of one input's loop while all other loops are closed. Factors multiply the loop gain.
struct ChannelMargins {
  double gainUp;    ///< smallest factor above 1 that makes the loop unstable; infinite if none does
  double gainDown;  ///< largest factor below 1 that makes the loop unstable; 0 if none does
  double phase;     ///< smallest phase that makes the loop unstable, rad; infinite if none does
};

/// Margins of the loop u = -K x at the plant's input, L(z) = K (zI - A)^-1 B.
struct Margins {
  double disk = 0.0;           ///< disk margin: smallest singular value of I + L over frequency
  double diskFrequency = 0.0;  ///< frequency of the disk margin, rad/s
  std::vector<ChannelMargins> channel;
  int toleratedDelay = -1;    ///< see toleratedDelay(), samples; -1: unstable without delay
  double radiusBeyond = 0.0;  ///< spectral radius with a delay of toleratedDelay + 1 samples
};

/// Return the matrix of the closed loop if u = -K x acts `delay` samples late. Its states are
/// [x[j]; u[j-1]; ...; u[j-delay]]. Realtime: no.
///
/// This function and those below throw DesignError: sizes that do not match; a delay outside 0 to 65; a period that is
/// not positive and finite.
Eigen::MatrixXd closedLoop(const StateSpace& loop, const Eigen::MatrixXd& K, int delay);

/// Return the largest modulus of the eigenvalues. Throws DesignError if they do not converge. Realtime: no.
double spectralRadius(const Eigen::MatrixXd& A);

/// Return the eigenvalues z of a sampled loop as continuous poles s = ln(z) / Ts, rad/s, fastest first. Realtime: no.
std::vector<std::complex<double>> continuousPoles(const Eigen::MatrixXd& closedLoop, double period);

/// Return the largest constant delay, in samples, at which the closed loop is stable; the loop is also stable at every
/// shorter delay. At most 64; -1 if the loop is unstable without delay. The eigenvalues of the whole loop decide.
/// Realtime: no.
int toleratedDelay(const StateSpace& loop, const Eigen::MatrixXd& K);

/// Return the disk margin: the smallest singular value of I + L over frequency, with `delay` more samples in the loop
/// L. The search uses a grid of 20 points an octave, then golden sections. The result is 0 if the loop is unstable. If
/// the margin is below `least`, the search stops early and returns some number between the margin and `least`.
/// Realtime: no.
double diskMargin(const StateSpace& loop, const Eigen::MatrixXd& K, double period, int delay, double least = 0.0);

/// Return all margins. The loop l_i of one input follows from the return difference: 1 + l_i = 1 / [(I + L)^-1]_ii.
/// Its crossings on the same grid are refined by bisection. `period` in s. An unstable loop has toleratedDelay -1 and
/// empty margins. Realtime: no.
Margins measureMargins(const StateSpace& loop, const Eigen::MatrixXd& K, double period);

}  // namespace enamel
