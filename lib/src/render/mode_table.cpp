#include "render/mode_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
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

// Gains by iterating the Riccati recursion (Wonham 1967; de Koning 1982). Its states are those of the tick in which a
// command first acts, and the `pending` commands that may act in its place. `cost` starts at the solution for the
// neighbouring inertia, so it converges soon.
template <int n>
struct Design {
  static constexpr int kMost = n + kMostPending;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost + 1, kMost + 1>;
  using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMost + 1>;

  explicit Design(int pending) : last(n + pending), cost(Square::Zero(last, last)) {}

  // b: effect of the command that acts; H: cost of the states and of this command, its last row.
  Row gains(const Matrix<n>& a, const Matrix<n, 1>& b, const Matrix<n + 1>& H) {
    constexpr int kMostSteps = 20000;
    const double chance = 1.0 / (last - n + 1);  // of each command to act
    Square next = Square::Zero(last, last + 1);  // from the states, the pending commands and the new one
    next.template topLeftCorner<n, n>() = a;
    for (int i = n; i < last; ++i) next(i, i == n ? last : i - 1) = 1.0;
    Square fixed = Square::Zero(last + 1, last + 1);
    fixed.template topLeftCorner<n, n>() = H.template topLeftCorner<n, n>();
    Row gain;
    for (int i = 0; i < kMostSteps; ++i) {
      const Row Pb = b.transpose() * cost.template topRows<n>();
      Row act = Pb * next;  // products of the command that acts with all others
      act.template head<n>() += H.template bottomLeftCorner<1, n>();
      Square form = fixed;
      form.noalias() += next.transpose() * (cost * next);
      for (int j = n; j <= last; ++j) {
        form.row(j) += chance * act;
        form.col(j) += chance * act.transpose();
        form(j, j) += chance * (H(n, n) + Pb.template head<n>().dot(b));
      }
      gain = form.row(last).head(last) / form(last, last);
      Square better = form.topLeftCorner(last, last) - gain.transpose() * form.row(last).head(last);
      better = (0.5 * (better + better.transpose())).eval();
      const double change = (better - cost).norm();
      cost = better;
      if (change <= 1e-12 * better.norm()) break;
    }
    return gain;
  }

  int last;     // index of the new command
  Square cost;  // from now on
};

// Divide a tick into substeps. `visit` receives the index of each, the motion until its beginning, that until its end,
// and that over half of it. Returns the motion over the tick.
template <int kMech, class Visit>
Matrix<kMech + 6> overTick(const ModeData& d, double inertia, const Visit& visit) {
  const Matrix<kMech + 6> middle = exponential<kMech + 6>(continuous<kMech>(d.drive, inertia) *
                                                          (0.5 * d.period / kSubsteps)),
                          step = middle.lazyProduct(middle);
  Matrix<kMech + 6> power = Matrix<kMech + 6>::Identity();
  for (int i = 0; i < kSubsteps; ++i) {
    const Matrix<kMech + 6> next = power.lazyProduct(step);
    visit(i, power, next, middle);
    power = next;
  }
  return power;
}

template <int kMech>
ModeModel<kMech> modelAt(const ModeData& d, double inertia) {
  constexpr int push = kMech + 1, growth = kMech + 2, inputs = kMech + 3;
  const double perSubstep = 2.0 / kGrowthTime * d.period / kSubsteps, perBin = static_cast<double>(kBins) / kSubsteps;
  ModeModel<kMech> m = {};
  Matrix<kMech + 3> wander = Matrix<kMech + 3>::Zero();  // remaining growth noise
  const Matrix<kMech + 6> whole =
      overTick<kMech>(d, inertia, [&](int i, const auto& power, const auto&, const auto& middle) {
        const Matrix<kMech + 3, 1> grown = power.col(growth).template head<kMech + 3>();
        wander += perSubstep * grown * grown.transpose();
        double* onset = m.onset[kBins - 1 - i * kBins / kSubsteps];
        for (int j = 0; j < kMech; ++j) onset[j] += perBin * power.row(j).dot(middle.col(push));
      });
  for (int i = 0; i < kMech; ++i) {
    for (int j = 0; j < kMech + 3; ++j) m.state[i][j] = whole(i, j);
    m.command[i] = whole(i, inputs);
    m.rotor[i] = whole(i, inputs + 1);
    m.link[i] = whole(i, inputs + 2);
  }
  const auto place = [](int i) { return i < kMech ? i : i + 1; };  // the lag has no noise
  for (int i = 0, n = 0; i < kMech + 2; ++i)
    for (int j = 0; j <= i; ++j) m.wander[n++] = wander(place(i), place(j));
  return m;
}

template <int kMech>
ModeGains<kMech> gainsAt(const ModeData& d, double unseen, double inertia, Design<kMech + 1>& design) {
  constexpr int inputs = kMech + 3, link = kMech - 2;
  Matrix<kMech + 2> H = Matrix<kMech + 2>::Zero();  // cost of the link's motion
  const Matrix<kMech + 6> whole = overTick<kMech>(d, inertia, [&](int, const auto&, const auto& next, const auto&) {
    Matrix<kMech + 2, 1> way;
    way << next.row(link).template head<kMech + 1>().transpose(), next(link, inputs);
    H += way * way.transpose() / kSubsteps;
  });
  const double reaction = reactionTime(d), mass = inertia + (kMech == 4 ? d.drive.rotorInertia : 0.0);
  // The depth x, per unit largest force: until a command acts, and half an encoder step that no reading shows.
  const double late = 0.5 * d.pushShare / (1.0 - d.pushShare) * reaction * reaction / mass;
  H /= late * late + unseen * unseen;
  H(kMech + 1, kMech + 1) += d.forceCost;
  const auto gains = design.gains(whole.template topLeftCorner<kMech + 1, kMech + 1>(),
                                  whole.col(inputs).template head<kMech + 1>(), H);
  ModeGains<kMech> m = {};
  for (int i = 0; i < gains.size(); ++i) (i <= kMech ? m.gain[i] : m.pending[i - kMech - 1]) = gains[i];
  return m;
}

const double kLowest = std::log(1e-7), kStep = 0.05;
constexpr int kEntries = 415;  // up to 1e2

template <class At>
auto atAllInertias(const At& at) {
  std::vector<decltype(at(1.0))> entries;
  entries.reserve(kEntries);
  for (int i = 0; i < kEntries; ++i) entries.push_back(at(std::exp(kLowest + i * kStep)));
  return entries;
}

template <int kMech>
std::vector<ModeModel<kMech>> modelsOf(const ModeData& data) {
  return atAllInertias([&](double inertia) { return modelAt<kMech>(data, inertia); });
}

template <int kMech>
std::vector<ModeGains<kMech>> gainsOf(const ModeData& data, double unseen) {
  Design<kMech + 1> design(data.delayHigh - data.delayLow);
  return atAllInertias([&](double inertia) { return gainsAt<kMech>(data, unseen, inertia, design); });
}

// Return the cached table of these numbers, or make it.
template <class Entry, std::size_t n>
std::shared_ptr<const InertiaTable<Entry>> shared(const std::array<double, n>& key,
                                                  const std::function<std::vector<Entry>()>& make) {
  constexpr std::size_t kKept = 64;
  static std::mutex mutex;
  // Most recently used last. The key contains everything that determines a table.
  static std::vector<std::pair<std::array<double, n>, std::shared_ptr<const InertiaTable<Entry>>>> kept;
  const std::lock_guard lock(mutex);
  const auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& entry) { return entry.first == key; });
  if (found != kept.end()) {
    std::rotate(found, found + 1, kept.end());
  } else {
    if (kept.size() == kKept) kept.erase(kept.begin());
    kept.emplace_back(key, std::make_shared<const InertiaTable<Entry>>(make()));
  }
  return kept.back().second;
}

}  // namespace

double reactionTime(const ModeData& data) noexcept {
  const int choices = data.delayHigh - data.delayLow + 1;
  double square = 0.0, none = 1.0;  // none: probability that no such command has acted
  for (int i = 1; i <= choices; ++i) {
    const double acts = none * i / choices, ticks = data.delayLow + i;
    square += acts * ticks * ticks;
    none -= acts;
  }
  return std::sqrt(square) * data.period;
}

JointVector unseenOf(const JointVector& encoderStep, const JointVector& effort) {
  JointVector unseen = JointVector::Zero(encoderStep.size());
  for (Eigen::Index j = 0; j < unseen.size(); ++j)
    if (effort[j] > 0.0) unseen[j] = 0.5 * encoderStep[j] / effort[j];
  return unseen;
}

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

template <class Entry>
void InertiaTable<Entry>::read(double logInertia, int lane, double (*value)[kLanes], double (*slope)[kLanes],
                               int slopes) const noexcept {
  const double last = static_cast<double>(entries_.size() - 1);
  const double place = std::max(0.0, std::min((logInertia - kLowest) / kStep, last));  // NaN becomes 0
  const std::size_t i = std::min(static_cast<std::size_t>(place), entries_.size() - 2);
  const double share = place - static_cast<double>(i);
  double a[kNumbers], b[kNumbers];
  std::memcpy(a, &entries_[i], sizeof a);
  std::memcpy(b, &entries_[i + 1], sizeof b);
  for (int n = 0; n < kNumbers; ++n) value[n][lane] = a[n] + share * (b[n] - a[n]);
  for (int n = 0; n < slopes; ++n) slope[n][lane] = (b[n] - a[n]) / kStep;
}

template <int kMech>
std::shared_ptr<const InertiaTable<ModeModel<kMech>>> modelTableOf(const ModeData& data) {
  const Drive& drive = data.drive;
  const std::array key = {data.period, drive.bandwidth, drive.rotorInertia, drive.stiffness, drive.damping};
  return shared<ModeModel<kMech>>(key, [&] { return modelsOf<kMech>(data); });
}

template <int kMech>
std::shared_ptr<const InertiaTable<ModeGains<kMech>>> gainTableOf(const ModeData& data, double unseen) {
  const Drive& drive = data.drive;
  const std::array key = {data.period,
                          static_cast<double>(data.delayLow),
                          static_cast<double>(data.delayHigh),
                          drive.bandwidth,
                          drive.rotorInertia,
                          drive.stiffness,
                          drive.damping,
                          data.pushShare,
                          data.forceCost,
                          unseen};
  return shared<ModeGains<kMech>>(key, [&] { return gainsOf<kMech>(data, unseen); });
}

template ModeMotion<2> modeMotion<2>(const Drive& drive, double inertia, double seconds);
template ModeMotion<4> modeMotion<4>(const Drive& drive, double inertia, double seconds);
template class InertiaTable<ModeModel<2>>;
template class InertiaTable<ModeModel<4>>;
template class InertiaTable<ModeGains<2>>;
template class InertiaTable<ModeGains<4>>;
template std::shared_ptr<const InertiaTable<ModeModel<2>>> modelTableOf<2>(const ModeData& data);
template std::shared_ptr<const InertiaTable<ModeModel<4>>> modelTableOf<4>(const ModeData& data);
template std::shared_ptr<const InertiaTable<ModeGains<2>>> gainTableOf<2>(const ModeData& data, double unseen);
template std::shared_ptr<const InertiaTable<ModeGains<4>>> gainTableOf<4>(const ModeData& data, double unseen);

}  // namespace enamel
