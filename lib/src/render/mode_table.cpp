#include "render/mode_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

#include "render/exponential.hpp"

namespace enamel {
namespace {

constexpr int kSubsteps = 16;  // of a tick: for integrals and for the middles of the bins

// x' = A x + B [u, force on the rotor, force on the link] of a mode. The held inputs are extra states.
template <int kMech>
Matrix<kMech + 6> continuous(const Drive& drive, double inertia) {
  constexpr int lag = kMech, push = kMech + 1, growth = kMech + 2, inputs = kMech + 3;
  Matrix<kMech + 6> A = Matrix<kMech + 6>::Zero();
  if constexpr (kMech == 4) {
    const double J = drive.rotorInertia, k = drive.stiffness, b = drive.damping;
    A(0, 1) = A(2, 3) = 1.0;
    A.row(1).template head<4>() << -k / J, -b / J, k / J, b / J;
    A.row(3).template head<4>() << k / inertia, b / inertia, -k / inertia, -b / inertia;
    A(1, lag) = A(1, inputs + 1) = 1.0 / J;
    A(3, push) = A(3, inputs + 2) = 1.0 / inertia;
  } else {
    A(0, 1) = 1.0;
    A(1, lag) = A(1, push) = A(1, inputs + 1) = A(1, inputs + 2) = 1.0 / inertia;
  }
  const double w = lagOf(drive);
  A(lag, lag) = -w;
  A(lag, inputs) = w;
  A(push, growth) = 1.0;
  A(growth, growth) = -1.0 / kGrowthTime;
  return A;
}

// Gains by iterating the Riccati recursion. `cost` starts at the solution for the neighbouring inertia, so it converges
// soon. The variance of the number of ticks in which a command acts increases the cost of commands.
template <int n>
void designGains(const Matrix<n>& a, const Matrix<n, 1>& b, const Matrix<n + 1>& H, double chance, Matrix<n>& cost,
                 double* gain) {
  constexpr int kMostSteps = 20000;
  const Matrix<n> states = H.template topLeftCorner<n, n>();
  const Matrix<1, n> mixed = H.template bottomLeftCorner<1, n>();
  for (int i = 0; i < kMostSteps; ++i) {
    const Matrix<n, 1> Xb = cost * b;
    const Matrix<1, n> asked = Xb.transpose() * a + mixed, k = asked / (H(n, n) + (1.0 + chance) * b.dot(Xb));
    Matrix<n> next = states + a.transpose() * cost * a - k.transpose() * asked;
    next = (0.5 * (next + next.transpose())).eval();
    const double change = (next - cost).norm();
    cost = next;
    for (int j = 0; j < n; ++j) gain[j] = k[j];
    if (change <= 1e-12 * next.norm()) return;
  }
}

template <int kMech>
ModeModel<kMech> modelAt(const ModeData& d, double inertia, Matrix<kMech + 1>& cost) {
  constexpr int push = kMech + 1, growth = kMech + 2, inputs = kMech + 3, link = kMech - 2, kAll = kMech + 6;
  const Matrix<kAll> middle = exponential<kAll>(continuous<kMech>(d.drive, inertia) * (0.5 * d.period / kSubsteps)),
                     step = middle.lazyProduct(middle);
  ModeModel<kMech> m = {};
  Matrix<kAll> power = Matrix<kAll>::Identity();
  // Sums over the substeps: remaining growth noise, effect of an onset, cost of the link's motion.
  Matrix<kMech + 3> wander = Matrix<kMech + 3>::Zero();
  Matrix<kMech + 2> H = Matrix<kMech + 2>::Zero();
  const double perSubstep = 2.0 / kGrowthTime * d.period / kSubsteps, perBin = static_cast<double>(kBins) / kSubsteps;
  for (int i = 0; i < kSubsteps; ++i) {
    const Matrix<kMech + 3, 1> grown = power.col(growth).template head<kMech + 3>();
    wander += perSubstep * grown * grown.transpose();
    double* onset = m.onset[kBins - 1 - i * kBins / kSubsteps];
    for (int j = 0; j < kMech; ++j) onset[j] += perBin * power.row(j).dot(middle.col(push));
    power = power.lazyProduct(step).eval();
    Matrix<kMech + 2, 1> way;
    way << power.row(link).template head<kMech + 1>().transpose(), power(link, inputs);
    H += way * way.transpose() / kSubsteps;
  }
  const double reaction = (d.delay + 1) * d.period, whole = inertia + (kMech == 4 ? d.drive.rotorInertia : 0.0);
  // The depth x, per unit largest force: until a command acts, and half an encoder step that no reading shows.
  const double late = 0.5 * d.pushShare / (1.0 - d.pushShare) * reaction * reaction / whole;
  H /= late * late + d.unseen * d.unseen;
  H(kMech + 1, kMech + 1) += d.forceCost;
  for (int i = 0; i < kMech; ++i) {
    for (int j = 0; j < kMech + 3; ++j) m.state[i][j] = power(i, j);
    m.command[i] = power(i, inputs);
    m.rotor[i] = power(i, inputs + 1);
    m.link[i] = power(i, inputs + 2);
  }
  const auto place = [](int i) { return i < kMech ? i : i + 1; };  // the lag has no noise
  for (int i = 0, n = 0; i < kMech + 2; ++i)
    for (int j = 0; j <= i; ++j) m.wander[n++] = wander(place(i), place(j));
  designGains<kMech + 1>(power.template topLeftCorner<kMech + 1, kMech + 1>(),
                         power.col(inputs).template head<kMech + 1>(), H, d.chance, cost, m.gain);
  return m;
}

const double kLowest = std::log(1e-7), kStep = 0.05;
constexpr int kEntries = 415;  // up to 1e2

}  // namespace

double lagOf(const Drive& drive) noexcept { return 2.0 * M_PI * (drive.bandwidth > 0.0 ? drive.bandwidth : 1e5); }

template <int kMech>
ModeMotion<kMech> modeMotion(const Drive& drive, double inertia, double seconds) {
  const Matrix<kMech + 6> whole = exponential<kMech + 6>(continuous<kMech>(drive, inertia) * seconds);
  ModeMotion<kMech> motion;
  for (int i = 0; i <= kMech; ++i) {
    for (int j = 0; j <= kMech; ++j) motion.state[i][j] = whole(i, j);
    motion.command[i] = whole(i, kMech + 3);
    motion.push[i] = whole(i, kMech + 1);
  }
  return motion;
}

template <int kMech>
ModeTable<kMech>::ModeTable(const ModeData& data) {
  Matrix<kMech + 1> cost = Matrix<kMech + 1>::Zero();
  entries_.reserve(kEntries);
  for (int i = 0; i < kEntries; ++i) entries_.push_back(modelAt<kMech>(data, std::exp(kLowest + i * kStep), cost));
}

template <int kMech>
void ModeTable<kMech>::read(double logInertia, int lane, double (*value)[kLanes],
                            double (*slope)[kLanes]) const noexcept {
  const double last = static_cast<double>(entries_.size() - 1);
  const double place = std::max(0.0, std::min((logInertia - kLowest) / kStep, last));  // NaN becomes 0
  const std::size_t i = std::min(static_cast<std::size_t>(place), entries_.size() - 2);
  const double share = place - static_cast<double>(i);
  double a[kNumbers], b[kNumbers];
  std::memcpy(a, &entries_[i], sizeof a);
  std::memcpy(b, &entries_[i + 1], sizeof b);
  for (int n = 0; n < kNumbers; ++n) value[n][lane] = a[n] + share * (b[n] - a[n]);
  for (int n = 0; n < kSlopes; ++n) slope[n][lane] = (b[n] - a[n]) / kStep;
}

template <int kMech>
std::shared_ptr<const ModeTable<kMech>> modeTableOf(const ModeData& data) {
  constexpr std::size_t kKept = 8;
  using Key = std::array<double, 10>;  // everything that determines a table
  static std::mutex mutex;
  static std::vector<std::pair<Key, std::shared_ptr<const ModeTable<kMech>>>> kept;  // most recently used last
  const Drive& drive = data.drive;
  const Key key = {data.period,     static_cast<double>(data.delay),
                   drive.bandwidth, drive.rotorInertia,
                   drive.stiffness, drive.damping,
                   data.pushShare,  data.forceCost,
                   data.chance,     data.unseen};
  const std::lock_guard lock(mutex);
  const auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& entry) { return entry.first == key; });
  if (found != kept.end()) {
    std::rotate(found, found + 1, kept.end());
  } else {
    if (kept.size() == kKept) kept.erase(kept.begin());
    kept.emplace_back(key, std::make_shared<const ModeTable<kMech>>(data));
  }
  return kept.back().second;
}

template ModeMotion<2> modeMotion<2>(const Drive& drive, double inertia, double seconds);
template ModeMotion<4> modeMotion<4>(const Drive& drive, double inertia, double seconds);
template class ModeTable<2>;
template class ModeTable<4>;
template std::shared_ptr<const ModeTable<2>> modeTableOf<2>(const ModeData& data);
template std::shared_ptr<const ModeTable<4>> modeTableOf<4>(const ModeData& data);

}  // namespace enamel
