// How far a sampled state-feedback loop is from instability.
#pragma once

#include <complex>
#include <vector>

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Margins of one input's loop with all others closed. Factors are of the loop gain.
struct ChannelMargins {
  double gainUp;    ///< smallest factor above 1 at which the loop becomes unstable; infinite where none does
  double gainDown;  ///< largest factor below 1 at which it does; 0 where none does
  double phase;     ///< smallest phase that makes it unstable, rad; infinite where none does
};

/// Margins of the loop u = -K x at the plant's input, L(z) = K (zI - A)^-1 B.
struct Margins {
  double disk = 0.0;           ///< min over frequency of the smallest singular value of I + L
  double diskFrequency = 0.0;  ///< where it is, rad/s
  std::vector<ChannelMargins> channel;
  int toleratedDelay = -1;    ///< largest constant delay, samples, up to which the closed loop is stable; -1: unstable
  double radiusBeyond = 0.0;  ///< spectral radius with one sample more
};

/// Matrix of the closed loop when u = -K x acts `delay` samples late: states [x[j]; u[j-1]; ...; u[j-delay]].
/// These and the functions below throw DesignError: sizes that do not fit; a delay outside 0 to 65; a period that is not
/// positive and finite. Realtime: no.
Eigen::MatrixXd closedLoop(const StateSpace& loop, const Eigen::MatrixXd& K, int delay);

/// Largest modulus of the eigenvalues. Throws DesignError if they do not converge. Realtime: no.
double spectralRadius(const Eigen::MatrixXd& A);

/// Eigenvalues z of a sampled loop as continuous poles s = ln(z) / Ts, rad/s, fastest first. Realtime: no.
std::vector<std::complex<double>> continuousPoles(const Eigen::MatrixXd& closedLoop, double period);

/// Largest constant delay, in samples, up to which the closed loop is stable (every shorter one included), at most 64;
/// -1 where it is unstable without delay. Decided by the eigenvalues of the whole loop. Realtime: no.
int toleratedDelay(const StateSpace& loop, const Eigen::MatrixXd& K);

/// Smallest singular value of I + L over frequency, L with `delay` samples more in the loop: a grid of 20 points an
/// octave, then golden-section search. 0 where that loop is unstable; where it is below `least`, only some number between
/// it and `least`, found sooner. Realtime: no.
double diskMargin(const StateSpace& loop, const Eigen::MatrixXd& K, double period, int delay, double least = 0.0);

/// All margins. Loop at a time, from the return difference: 1 + l_i = 1 / [(I + L)^-1]_ii (crossings of the same grid,
/// bisected). `period` in s. An unstable loop has toleratedDelay -1 and no margins. Realtime: no.
Margins measureMargins(const StateSpace& loop, const Eigen::MatrixXd& K, double period);

}  // namespace enamel
