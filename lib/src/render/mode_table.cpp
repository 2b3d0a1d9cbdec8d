#include "render/mode_table.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace enamel {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 10, 10>;

constexpr int kSubsteps = 16;  // of a tick: integrals, and the middles of the bins

// e^A by scaling and squaring of its Taylor series.
Matrix exponential(const Matrix& A) {
  const double size = A.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = std::max(0, static_cast<int>(std::ceil(std::log2(std::max(1e-9, size)))) + 2);
  const Matrix scaled = A * std::ldexp(1.0, -squarings);
  Matrix term = Matrix::Identity(A.rows(), A.cols()), sum = term;
  for (int i = 1; i <= 14; ++i) {
    term = (term * scaled / i).eval();
    sum += term;
  }
  for (int i = 0; i < squarings; ++i) sum = (sum * sum).eval();
  return sum;
}

// x' = A x + B [u, force on the rotor, force on the link] of a mode, with the inputs held as further states.
template <int kMech>
Matrix continuous(const ModeData& d, double inertia) {
  constexpr int lag = kMech, push = kMech + 1, growth = kMech + 2, inputs = kMech + 3;
  Matrix A = Matrix::Zero(kMech + 6, kMech + 6);
  if (kMech == 4) {
    const double J = d.drive.rotorInertia, k = d.drive.stiffness, b = d.drive.damping;
    A(0, 1) = A(2, 3) = 1.0;
    A.row(1).head(4) << -k / J, -b / J, k / J, b / J;
    A.row(3).head(4) << k / inertia, b / inertia, -k / inertia, -b / inertia;
    A(1, lag) = A(1, inputs + 1) = 1.0 / J;
    A(3, push) = A(3, inputs + 2) = 1.0 / inertia;
  } else {
    A(0, 1) = 1.0;
    A(1, lag) = A(1, push) = A(1, inputs + 1) = A(1, inputs + 2) = 1.0 / inertia;
  }
  const double w = lagOf(d.drive);
  A(lag, lag) = -w;
  A(lag, inputs) = w;
  A(push, growth) = 1.0;
  A(growth, growth) = -1.0 / kGrowthTime;
  return A;
}

// Gains by the recursion of the Riccati equation. `cost`: its matrix for a neighbour, from which it has converged soon.
// A command that acts by chance costs more, by the variance of what it does.
template <int kMech>
void designGains(const Matrix& a, const Matrix& b, const Matrix& H, double chance, Matrix& cost, double* gain) {
  constexpr int n = kMech + 1, kMostSteps = 20000;
  if (cost.rows() != n) cost = H.topLeftCorner(n, n);
  for (int i = 0; i < kMostSteps; ++i) {
    const Matrix Xb = cost * b, asked = Xb.transpose() * a + H.block(n, 0, 1, n),
                 k = asked / (H(n, n) + (1.0 + chance) * (b.transpose() * Xb)(0));
    Matrix next = H.topLeftCorner(n, n) + a.transpose() * cost * a - k.transpose() * asked;
    next = (0.5 * (next + next.transpose())).eval();
    const double change = (next - cost).norm();
    cost = next;
    for (int j = 0; j < n; ++j) gain[j] = k(0, j);
    if (change <= 1e-12 * next.norm()) return;
  }
}

template <int kMech>
ModeModel<kMech> modelAt(const ModeData& d, double inertia, Matrix& cost) {
  constexpr int push = kMech + 1, growth = kMech + 2, inputs = kMech + 3, link = kMech - 2;
  const Matrix A = continuous<kMech>(d, inertia), step = exponential(A * (d.period / kSubsteps)),
               middle = exponential(A * (0.5 * d.period / kSubsteps));
  ModeModel<kMech> m = {};
  Matrix power = Matrix::Identity(A.rows(), A.cols());
  // Sums over the substeps of a tick: what is left of the growth's wandering, of an onset, and the link's way.
  Matrix wander = Matrix::Zero(kMech + 3, kMech + 3), H = Matrix::Zero(kMech + 2, kMech + 2);
  const double perSubstep = 2.0 / kGrowthTime * d.period / kSubsteps, perBin = static_cast<double>(kBins) / kSubsteps;
  for (int i = 0; i < kSubsteps; ++i) {
    const auto grown = power.col(growth).head(kMech + 3);
    wander += perSubstep * grown * grown.transpose();
    const Matrix since = power * middle;
    double* onset = m.onset[kBins - 1 - i * kBins / kSubsteps];
    for (int j = 0; j < kMech; ++j) onset[j] += perBin * since(j, push);
    power = (power * step).eval();
    Eigen::Matrix<double, kMech + 2, 1> way;
    way << power.row(link).head(kMech + 1).transpose(), power(link, inputs);
    H += way * way.transpose() / kSubsteps;
  }
  const double reaction = (d.delay + 1) * d.period, whole = inertia + (kMech == 4 ? d.drive.rotorInertia : 0.0);
  const double depth =
      0.5 * d.pushShare / (1.0 - d.pushShare) * reaction * reaction / whole;  // of a unit largest force
  H /= depth * depth;
  H(kMech + 1, kMech + 1) += d.forceCost;
  for (int i = 0; i < kMech; ++i) {
    for (int j = 0; j < kMech + 3; ++j) m.state[i][j] = power(i, j);
    m.command[i] = power(i, inputs);
    m.rotor[i] = power(i, inputs + 1);
    m.link[i] = power(i, inputs + 2);
  }
  const auto place = [](int i) { return i < kMech ? i : i + 1; };  // the lag does not wander
  for (int i = 0, n = 0; i < kMech + 2; ++i)
    for (int j = 0; j <= i; ++j) m.wander[n++] = wander(place(i), place(j));
  const Matrix a = power.topLeftCorner(kMech + 1, kMech + 1), b = power.block(0, inputs, kMech + 1, 1);
  designGains<kMech>(a, b, H, d.chance, cost, m.gain);
  return m;
}

const double kLowest = std::log(1e-7), kStep = 0.05;
constexpr int kEntries = 415;  // to 1e2

}  // namespace

double lagOf(const Drive& drive) noexcept { return 2.0 * M_PI * (drive.bandwidth > 0.0 ? drive.bandwidth : 1e5); }

template <int kMech>
ModeTable<kMech>::ModeTable(const ModeData& data) {
  Matrix cost;
  entries_.reserve(kEntries);
  for (int i = 0; i < kEntries; ++i) entries_.push_back(modelAt<kMech>(data, std::exp(kLowest + i * kStep), cost));
}

template <int kMech>
void ModeTable<kMech>::read(double logInertia, int lane, double (*value)[kLanes],
                            double (*slope)[kLanes]) const noexcept {
  const double place = std::clamp((logInertia - kLowest) / kStep, 0.0, static_cast<double>(entries_.size() - 1));
  const std::size_t i = std::min(static_cast<std::size_t>(place), entries_.size() - 2);
  const double share = place - static_cast<double>(i);
  double a[kNumbers], b[kNumbers];
  std::memcpy(a, &entries_[i], sizeof a);
  std::memcpy(b, &entries_[i + 1], sizeof b);
  for (int n = 0; n < kNumbers; ++n) value[n][lane] = a[n] + share * (b[n] - a[n]);
  for (int n = 0; n < kSlopes; ++n) slope[n][lane] = (b[n] - a[n]) / kStep;
}

template class ModeTable<2>;
template class ModeTable<4>;

}  // namespace enamel
