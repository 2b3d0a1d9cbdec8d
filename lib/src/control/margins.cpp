#include "enamel/control/margins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "control/dense.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

constexpr int kMaxDelay = 64;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void requirePositive(double period) {
  if (!(period > 0.0 && std::isfinite(period)))
    throw DesignError("loop: the period must be greater than 0 s and finite");
}

// The loop at the plant's input as a function of frequency.
class FrequencyResponse {
 public:
  FrequencyResponse(const StateSpace& loop, const MatrixXd& K, double period, int delay)
      : A_(loop.A.cast<Complex>()), B_(loop.B.cast<Complex>()), K_(K.cast<Complex>()), period_(period), delay_(delay) {
    requirePositive(period);
  }

  // I + L at the angular frequency w, rad/s.
  MatrixXcd returnDifference(double w) const {
    const Complex z = std::polar(1.0, w * period_);
    MatrixXcd pencil = -A_;
    pencil.diagonal().array() += z;
    MatrixXcd M = product(std::polar(1.0, -w * period_ * delay_) * K_, solve(pencil, B_));
    M.diagonal().array() += 1.0;
    return M;
  }
  double smallestSingularValue(double w) const {
    const Eigen::VectorXd values = singularValues(returnDifference(w));
    return values[values.size() - 1];
  }
  // The loop of each input with the others closed.
  VectorXcd loops(double w) const {
    const MatrixXcd M = returnDifference(w);
    return solve(M, MatrixXcd::Identity(M.rows(), M.cols())).diagonal().cwiseInverse().array() - 1.0;
  }

  // From 2^-20 of the Nyquist frequency up to it, 20 points per octave.
  std::vector<double> frequencies() const {
    std::vector<double> w;
    for (int i = 20 * 20; i >= 0; --i) w.push_back(M_PI / period_ * std::exp2(-i / 20.0));
    return w;
  }

 private:
  MatrixXcd A_, B_, K_;
  double period_;
  int delay_;
};

// Minimum of a function over the grid, refined by golden section between the neighbours of the best point. The grid is
// searched downwards, because loops peak near the Nyquist frequency. The first value below `enough` ends the search.
template <typename Function>
std::pair<double, double> minimise(const Function& f, const std::vector<double>& grid, double enough = -kInfinity) {
  std::vector<double> values(grid.size());
  for (std::size_t k = grid.size(); k-- > 0;) {
    values[k] = f(grid[k]);
    if (values[k] < enough) return {grid[k], values[k]};
  }
  const std::size_t best = std::min_element(values.begin(), values.end()) - values.begin();
  double low = grid[best > 0 ? best - 1 : 0], high = grid[std::min(best + 1, grid.size() - 1)];
  constexpr double kGolden = 0.6180339887498949;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low), fa = f(a), fb = f(b);
  for (int i = 0; i < 30; ++i) {
    if (fa < fb) {
      high = b, b = a, fb = fa, a = high - kGolden * (high - low), fa = f(a);
    } else {
      low = a, a = b, fa = fb, b = low + kGolden * (high - low), fb = f(b);
    }
  }
  const std::pair<double, double> refined = fa < fb ? std::pair{a, fa} : std::pair{b, fb};
  return refined.second < values[best] ? refined : std::pair{grid[best], values[best]};
}

// Frequency between two others at which a function changes its sign.
template <typename Function>
double bisect(const Function& f, double low, double high) {
  const bool rising = f(low) < 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((f(middle) < 0.0) == rising ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Margins of input i. Row k of `loops` holds all loops at grid[k].
ChannelMargins channelMargins(const FrequencyResponse& response, Index i, const std::vector<double>& grid,
                              const MatrixXcd& loops) {
  ChannelMargins margins{kInfinity, 0.0, kInfinity};
  const auto crossAxis = [&margins](const Complex& l) {
    if (!(l.real() < 0.0)) return;
    const double factor = -1.0 / l.real();
    if (factor > 1.0) margins.gainUp = std::min(margins.gainUp, factor);
    if (factor < 1.0) margins.gainDown = std::max(margins.gainDown, factor);
  };
  const auto at = [&](double w) { return response.loops(w)[i]; };
  const auto imaginary = [&](double w) { return at(w).imag(); };
  const auto gain = [&](double w) { return std::abs(at(w)) - 1.0; };
  const Index last = loops.rows() - 1;
  for (Index k = 1; k <= last; ++k) {
    const Complex before = loops(k - 1, i), l = loops(k, i);
    const double low = grid[static_cast<std::size_t>(k) - 1], high = grid[static_cast<std::size_t>(k)];
    if (k < last && (l.imag() < 0.0) != (before.imag() < 0.0)) crossAxis(at(bisect(imaginary, low, high)));
    if ((std::abs(l) < 1.0) != (std::abs(before) < 1.0))
      margins.phase = std::min(margins.phase, M_PI - std::abs(std::arg(at(bisect(gain, low, high)))));
  }
  crossAxis(loops(last, i));  // at the Nyquist frequency the loop is real
  return margins;
}

}  // namespace

MatrixXd closedLoop(const StateSpace& loop, const MatrixXd& K, int delay) {
  const auto size = [](const MatrixXd& M) { return std::to_string(M.rows()) + " x " + std::to_string(M.cols()); };
  if (loop.A.rows() == 0 || loop.A.cols() != loop.A.rows() || loop.B.rows() != loop.A.rows() || loop.B.cols() == 0 ||
      K.rows() != loop.B.cols() || K.cols() != loop.A.rows())
    throw DesignError("loop: sizes do not fit: A " + size(loop.A) + ", B " + size(loop.B) + ", K " + size(K));
  if (delay < 0 || delay > kMaxDelay + 1)
    throw DesignError("loop: the delay is " + std::to_string(delay) + ", must be in 0 to " +
                      std::to_string(kMaxDelay + 1) + " ticks");
  if (delay == 0) return loop.A - product(loop.B, K);
  const Index n = loop.A.rows(), m = loop.B.cols();
  MatrixXd closed = MatrixXd::Zero(n + m * delay, n + m * delay);
  closed.topLeftCorner(n, n) = loop.A;
  closed.topRightCorner(n, m) = loop.B;  // the oldest command acts
  closed.block(n, 0, m, n) = -K;
  closed.bottomRows(m * (delay - 1)).middleCols(n, m * (delay - 1)).setIdentity();
  return closed;
}

double spectralRadius(const MatrixXd& A) { return eigenvalues(A).cwiseAbs().maxCoeff(); }

std::vector<Complex> continuousPoles(const MatrixXd& closed, double period) {
  requirePositive(period);
  std::vector<Complex> poles;
  for (const Complex& z : eigenvalues(closed)) poles.push_back(std::log(z) / period);
  std::sort(poles.begin(), poles.end(), [](const Complex& a, const Complex& b) {
    const double fa = std::abs(a), fb = std::abs(b);
    return fa != fb ? fa > fb : a.imag() > b.imag();
  });
  return poles;
}

int toleratedDelay(const StateSpace& loop, const MatrixXd& K) {
  int delay = 0;
  while (delay <= kMaxDelay && spectralRadius(closedLoop(loop, K, delay)) < 1.0) ++delay;
  return delay - 1;
}

double diskMargin(const StateSpace& loop, const MatrixXd& K, double period, int delay, double least) {
  if (!(spectralRadius(closedLoop(loop, K, delay)) < 1.0)) return 0.0;
  const FrequencyResponse response(loop, K, period, delay);
  return minimise([&](double w) { return response.smallestSingularValue(w); }, response.frequencies(), least).second;
}

Margins measureMargins(const StateSpace& loop, const MatrixXd& K, double period) {
  Margins margins;
  margins.toleratedDelay = toleratedDelay(loop, K);
  margins.radiusBeyond = spectralRadius(closedLoop(loop, K, margins.toleratedDelay + 1));
  if (margins.toleratedDelay < 0) return margins;
  const FrequencyResponse response(loop, K, period, 0);
  const std::vector<double> grid = response.frequencies();
  std::tie(margins.diskFrequency, margins.disk) =
      minimise([&](double w) { return response.smallestSingularValue(w); }, grid);
  MatrixXcd loops(grid.size(), K.rows());
  for (std::size_t k = 0; k < grid.size(); ++k) loops.row(k) = response.loops(grid[k]).transpose();
  for (Index i = 0; i < K.rows(); ++i) margins.channel.push_back(channelMargins(response, i, grid, loops));
  return margins;
}

}  // namespace enamel
