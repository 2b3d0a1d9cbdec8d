#include "render/push_observer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/observer_steps.hpp"

namespace enamel {
namespace {

constexpr double kJumpRate = 1.0;                           // steps of the hand per second
constexpr double kLeastForce = 0.1;                         // share of a step: smallest force for the model error
constexpr double kScaleWander = 0.03;                       // deviation of ln(mass) per root second
constexpr double kMostScale = 0.5;                          // limit of ln(mass)
constexpr double kRefreshed = 2e-3;                         // change of ln(inertia) that updates the model
constexpr double kForgotten = -40.0, kLeastWeight = -60.0;  // logarithms

// Standard deviation of the growth of a push that begins with a step.
double growthOf(double step) noexcept { return 0.7 / kGrowthTime * step; }

template <int kMech>
const ObserverSteps<kMech>& steps() noexcept {
#ifdef ENAMEL_X86_KERNELS
  static const bool wide = __builtin_cpu_supports("avx2");
  if (wide) {
    if constexpr (kMech == 2)
      return kRigidStepsAvx2;
    else
      return kCableStepsAvx2;
  }
#endif
  if constexpr (kMech == 2)
    return kRigidSteps;
  else
    return kCableSteps;
}

}  // namespace

template <int kMech>
PushObserver<kMech>::PushObserver(const ModeData& data) : data_(data), table_(modeTableOf<kMech>(data)), model_{} {
  (void)steps<kMech>();  // detects the processor now, not in a tick
  model_.lagKept = std::exp(-lagOf(data.drive) * data.period);
  model_.growthKept = std::exp(-data.period / kGrowthTime);
  model_.growthSum = kGrowthTime * (1.0 - model_.growthKept);
}

template <int kMech>
void PushObserver<kMech>::describe(State& s, int k, double inertia, double step, double tremor,
                                   const Rounding& reading) const noexcept {
  s.inertia[k] = inertia;
  s.step[k] = step;
  s.tremor[k] = tremor;
  s.readingVariance[k] = reading.variance;
  s.largestStep[k] = reading.largest;
}

template <int kMech>
void PushObserver<kMech>::start(State& s, int modes, const Lane& reading) noexcept {
  s.modes = modes;
  s.count = 1.0;
  s.scale = 0.0;
  s.scaleVariance = kScalePrior * kScalePrior;
  for (int k = modes; k < kLanes; ++k) {
    s.inertia[k] = s.readingVariance[k] = s.largestStep[k] = 1.0;
    s.step[k] = s.tremor[k] = 0.0;
  }
  for (int k = 0; k < kLanes; ++k) s.used[k] = s.usedScale[k] = 0.0;
  refresh(s);
  s.part[0] = Hypothesis{};
  std::memset(s.P, 0, sizeof s.P);
  for (int k = 0; k < modes; ++k) s.P[at(kScale, kScale)][k] = kScalePrior * kScalePrior;
  believe(s, reading, Lane{});
}

template <int kMech>
void PushObserver<kMech>::believe(State& s, const Lane& reading, const Lane& rate) const noexcept {
  s.count = 1.0;
  s.weight[0] = 1.0;
  Hypothesis& h = s.part[0];
  h.logWeight = h.age = 0.0;
  Pairs P = {};
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    const double growth = kGrowthOfStep * s.step[k], speed = s.step[k] * kGrowthTime / s.inertia[k];
    // The push that would have caused the rate within a tick.
    const double push = (rate[k] - h.x[kMech - 1][k]) * (s.inertia[k] + data_.drive.rotorInertia) / data_.period;
    for (int i = 0; i < kMech; i += 2) {
      h.x[i][k] = reading[k];
      h.x[i + 1][k] = rate[k];
      P[at(i, i)][k] = 12.0 * s.readingVariance[k];
      P[at(i + 1, i + 1)][k] = speed * speed;
    }
    if (kMech == 4) {
      const double stretch = s.step[k] / data_.drive.stiffness;
      P[at(2, 2)][k] += stretch * stretch;
    }
    h.x[kGrowth][k] = 0.0;
    P[at(kPush, kPush)][k] = s.step[k] * s.step[k] + push * push + s.P[at(kPush, kPush)][k];
    P[at(kGrowth, kGrowth)][k] = growth * growth;
    P[at(kScale, kScale)][k] = s.P[at(kScale, kScale)][k];
  }
  std::memcpy(s.P, P, sizeof P);
  std::memcpy(s.mean, h.x, sizeof s.mean);
}

template <int kMech>
void PushObserver<kMech>::refresh(State& s) noexcept {
  const double whole = std::exp(s.scale);
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    const double wanted = s.inertia[k] * whole;
    if (std::abs(wanted - s.used[k]) < kRefreshed * wanted) continue;
    s.used[k] = wanted;
    // A push is known by the acceleration that it causes, so it scales with the mass.
    const double ratio = std::exp(s.scale - s.usedScale[k]);
    s.usedScale[k] = s.scale;
    const auto grows = [&](int i) { return i == kPush || i == kGrowth ? ratio : 1.0; };
    for (int i = 0; i < kStates; ++i) {
      for (int p = 0; p < static_cast<int>(s.count); ++p) {
        s.part[p].x[i][k] *= grows(i);
        s.part[p].g[i][k] *= grows(i);
      }
      for (int j = 0; j <= i; ++j) s.P[at(i, j)][k] *= grows(i) * grows(j);
    }
    table_->read(std::log(wanted), k, model_.value, model_.slope);
  }
}

template <int kMech>
void PushObserver<kMech>::reload(const State& s) noexcept {
  for (int k = 0; k < std::min(static_cast<int>(s.modes), kLanes); ++k)
    if (s.used[k] > 0.0) table_->read(std::log(s.used[k]), k, model_.value, model_.slope);
}

template <int kMech>
void PushObserver<kMech>::rotate(State& s, int i, int j, double cosine, double sine) const noexcept {
  const auto turn = [&](double(&v)[kLanes]) {
    const double before = v[i];
    v[i] = cosine * v[i] - sine * v[j];
    v[j] = sine * before + cosine * v[j];
  };
  const auto turnVariance = [&, c2 = cosine * cosine, s2 = sine * sine](double* v) {
    const double before = v[i];
    v[i] = c2 * v[i] + s2 * v[j];
    v[j] = s2 * before + c2 * v[j];
  };
  for (int p = 0; p < static_cast<int>(s.count); ++p) {
    for (int n = 0; n < kScale; ++n) turn(s.part[p].x[n]);
    turnVariance(s.part[p].v.data());
  }
  for (double(&v)[kLanes] : s.P) turnVariance(v);
  for (int n = 0; n < kScale; ++n) turn(s.mean[n]);
}

template <int kMech>
void PushObserver<kMech>::predict(State& s, const Lane& command) const noexcept {
  using Table = ModeTable<kMech>;
  const auto& value = model_.value;
  const int modes = static_cast<int>(s.modes), count = static_cast<int>(s.count);
  // Process noise. The model error scales with the force that accelerates the device. With cables it also scales with
  // the force itself, which keeps the controller's margin to a wrong resonance (loop transfer recovery).
  Lane rotor{}, link{}, growth{}, matters{};
  for (int k = 0; k < modes; ++k) {
    const double push = s.mean[kPush][k], net = std::abs(command[k] + push);
    double force = std::max(net, kLeastForce * s.step[k]);
    // Averaging readings does not remove the rounding of encoders. So the mass counts as known if its uncertainty moves
    // the mode by less than the rounding in a tick.
    const double moves = 0.5 * net * data_.period * data_.period / (s.used[k] + data_.drive.rotorInertia);
    matters[k] = moves * moves * s.scaleVariance > s.readingVariance[k] ? 1.0 : 0.0;
    if (kMech == 4) force = std::max({force, std::abs(command[k]), std::abs(push)});
    const double lacks = data_.modelError * force, disturbance = data_.drive.disturbance;
    rotor[k] = lacks * lacks + disturbance * disturbance;
    link[k] = s.tremor[k] * s.tremor[k] + (kMech == 4 ? lacks * lacks : 0.0);
    // A hand can take away half of its push in the time of a step's growth.
    growth[k] = kGrowthOfStep * kGrowthOfStep * std::max(s.step[k] * s.step[k], 0.25 * push * push);
  }
  Pairs Q = {};
  for (int i = 0, n = 0; i < kMech + 2; ++i)
    for (int j = 0; j <= i; ++j, ++n)
      for (int k = 0; k < kLanes; ++k)
        Q[at(i < kMech ? i : i + 1, j < kMech ? j : j + 1)][k] = growth[k] * value[Table::kWanderAt + n][k];
  for (int i = 0; i < kMech; ++i)
    for (int j = 0; j <= i; ++j)
      for (int k = 0; k < kLanes; ++k)
        Q[at(i, j)][k] += rotor[k] * value[Table::kRotorAt + i][k] * value[Table::kRotorAt + j][k] +
                          link[k] * value[Table::kLinkAt + i][k] * value[Table::kLinkAt + j][k];
  for (int k = 0; k < kLanes; ++k) Q[at(kScale, kScale)][k] = kScaleWander * kScaleWander * data_.period;

  steps<kMech>().predict(model_, command.data(), matters.data(), s.scale, Q, s.part[0].x, s.P);
  for (int p = 1; p < count; ++p) {
    Hypothesis& h = s.part[p];
    steps<kMech>().carry(model_, command.data(), matters.data(), s.scale, h.x);
    advance(Lane{}, h.g);
    h.age += 1.0;
  }
  static const double kLogEach = std::log(kJumpRate * 1e-3 / kBins), kLogNone = std::log1p(-kJumpRate * 1e-3);
  for (int b = 0; b < kBins; ++b) {
    Hypothesis& h = s.part[count + b];
    h = s.part[0];
    h.logWeight += kLogEach;
    std::memcpy(h.g, value + Table::kOnsetAt + b * kMech, kMech * sizeof h.g[0]);
    for (int k = 0; k < kLanes; ++k) {
      h.g[kPush][k] = 1.0;
      h.v[k] = s.step[k] * s.step[k];
    }
  }
  s.part[0].logWeight += kLogNone;
  s.count = count + kBins;
}

template <int kMech>
void PushObserver<kMech>::shift(State& s, double seconds) const noexcept {
  for (int p = 0; p < static_cast<int>(s.count); ++p)
    for (int i = 0; i < kMech; i += 2)
      for (int k = 0; k < kLanes; ++k) s.part[p].x[i][k] += seconds * s.part[p].x[i + 1][k];
}

template <int kMech>
double PushObserver<kMech>::surprise(const State& s, const Lane& reading) const noexcept {
  const int read = kMech == 4 && data_.drive.encoderOnLink ? 2 : 0;
  double least = 1e300;
  for (int p = 0; p < static_cast<int>(s.count); ++p) {
    double largest = 0.0;
    for (int k = 0; k < static_cast<int>(s.modes); ++k) {
      const Hypothesis& h = s.part[p];
      const double e = reading[k] - h.x[read][k];
      const double expected = s.P[at(read, read)][k] + h.v[k] * h.g[read][k] * h.g[read][k];
      largest = std::max(largest, e * e / (expected + s.readingVariance[k]));
    }
    least = std::min(least, largest);
  }
  return std::sqrt(least);
}

template <int kMech>
void PushObserver<kMech>::correct(State& s, const Lane& reading) const noexcept {
  const int read = kMech == 4 && data_.drive.encoderOnLink ? 2 : 0, modes = static_cast<int>(s.modes),
            count = static_cast<int>(s.count);
  double top = -1e300, sum = 0.0;
  States column, gain;
  for (int p = 0; p < count; ++p) {
    Hypothesis& h = s.part[p];
    Lane e{}, expected, jumped{};
    for (int k = 0; k < kLanes; ++k) {
      jumped[k] = h.v[k] * h.g[read][k];  // zero in the first hypothesis
      expected[k] = (p == 0 ? s.P[at(read, read)][k] : column[read][k]) + jumped[k] * h.g[read][k];
      e[k] = k < modes ? reading[k] - h.x[read][k] : 0.0;
    }
    Evidence seen;
    steps<kMech>().weigh(e.data(), expected.data(), s.readingVariance.data(), s.largestStep.data(), seen);
    double square = 0.0, volume = 1.0;
    for (int k = 0; k < modes; ++k) {
      square += seen.square[k];
      volume *= seen.volume[k];
    }
    h.logWeight -= 0.5 * square + std::log(volume);
    top = std::max(top, h.logWeight);
    if (p == 0) {
      steps<kMech>().correct(seen.variance.data(), read, s.P, column, gain);
      for (int i = 0; i < kStates; ++i)
        for (int k = 0; k < kLanes; ++k) h.x[i][k] += gain[i][k] * seen.innovation[k];
      for (int k = 0; k < kLanes; ++k) h.x[kScale][k] = std::clamp(h.x[kScale][k], -kMostScale, kMostScale);
      continue;
    }
    Lane per;
    for (int k = 0; k < kLanes; ++k) {
      per[k] = seen.innovation[k] / seen.variance[k];
      h.v[k] -= jumped[k] * jumped[k] / seen.variance[k];
    }
    double seenJump[kLanes];
    std::memcpy(seenJump, h.g[read], sizeof seenJump);
    for (int i = 0; i < kScale; ++i)
      for (int k = 0; k < kLanes; ++k) {
        h.x[i][k] += (column[i][k] + jumped[k] * h.g[i][k]) * per[k];
        h.g[i][k] -= gain[i][k] * seenJump[k];
      }
  }
  for (int p = 0; p < count; ++p) sum += std::exp(s.part[p].logWeight - top);
  for (int p = 0; p < count; ++p) s.part[p].logWeight -= top + std::log(sum);
}

template <int kMech>
void PushObserver<kMech>::merge(State& s) const noexcept {
  const int count = static_cast<int>(s.count);
  double share[kMost], total = 0.0;
  const auto ends = [&](int p) { return p == 0 || s.part[p].age >= 1.0; };
  bool any = false;
  for (int p = 0; p < count; ++p) {
    share[p] = std::exp(std::max(s.part[p].logWeight, 2.0 * kForgotten));
    if (!ends(p)) continue;
    total += share[p];
    any = any || p > 0;
  }
  if (any) {
    States x = {};
    for (int p = 0; p < count; ++p)
      for (int i = 0; ends(p) && i < kStates; ++i)
        for (int k = 0; k < kLanes; ++k) x[i][k] += share[p] / total * s.part[p].x[i][k];
    for (int p = 0; p < count; ++p) {
      if (!ends(p)) continue;
      steps<kMech>().gather(s.part[p].x, s.part[p].g, s.part[p].v, x, share[p] / total, s.P);
      const double jumped = p > 0 ? share[p] / total : 0.0;
      for (int k = 0; k < kLanes; ++k)
        s.P[at(kGrowth, kGrowth)][k] += jumped * growthOf(s.step[k]) * growthOf(s.step[k]);
    }
    std::memcpy(s.part[0].x, x, sizeof x);
  }
  s.part[0].logWeight = std::max(std::log(total), kLeastWeight);
  int kept = 1;
  for (int p = 1; p < count; ++p) {
    if (ends(p) || !(s.part[p].logWeight > kForgotten)) continue;
    if (p != kept) s.part[kept] = s.part[p];
    ++kept;
  }
  s.count = kept;
  std::memset(s.mean, 0, sizeof s.mean);
  for (int p = 0; p < kept; ++p) {
    s.weight[p] = std::exp(s.part[p].logWeight);
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) s.mean[i][k] += s.weight[p] * s.part[p].x[i][k];
  }
  // One mass for all modes, weighted by the information that each gained over the prior. The same unknown force of the
  // hand disturbs all modes. So they are not independent, and their information is averaged (Julier and Uhlmann 1997).
  constexpr double kPrior = 1.0 / (kScalePrior * kScalePrior);
  double sum = 0.0, squares = 0.0, weighted = 0.0;
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    double variance = 0.0;
    for (int p = 0; p < kept; ++p) {
      const double e = s.part[p].x[kScale][k] - s.mean[kScale][k];
      variance += s.weight[p] * (s.P[at(kScale, kScale)][k] + e * e);
    }
    const double gained = std::max(0.0, 1.0 / variance - kPrior);
    sum += gained;
    squares += gained * gained;
    weighted += gained * s.mean[kScale][k];
  }
  const double gained = sum > 0.0 ? squares / sum : 0.0;
  s.scaleVariance = 1.0 / (kPrior + gained);
  s.scale = sum > 0.0 ? std::clamp(weighted / sum * gained * s.scaleVariance, -kMostScale, kMostScale) : 0.0;
}

template <int kMech>
void PushObserver<kMech>::advance(const Lane& command, States& x) const noexcept {
  steps<kMech>().carry(model_, command.data(), Lane{}.data(), 0.0, x);
}

template <int kMech>
void PushObserver<kMech>::advanceSensitivity(const Lane& command, const States& x, States& d) const noexcept {
  advance(Lane{}, d);
  for (int i = 0; i < kMech; ++i) {
    for (int k = 0; k < kLanes; ++k) d[i][k] += commandSensitivity(i)[k] * command[k];
    for (int j = 0; j < kMech + 3; ++j)
      for (int k = 0; k < kLanes; ++k) d[i][k] += model_.slope[i * (kMech + 3) + j][k] * x[j][k];
  }
}

template <int kMech>
void PushObserver<kMech>::pullBack(States& row) const noexcept {
  States before = {};
  for (int i = 0; i < kMech; ++i)
    for (int j = 0; j < kMech + 3; ++j)
      for (int k = 0; k < kLanes; ++k) before[j][k] += model_.value[i * (kMech + 3) + j][k] * row[i][k];
  for (int k = 0; k < kLanes; ++k) {
    before[kLag][k] += model_.lagKept * row[kLag][k];
    before[kPush][k] += row[kPush][k];
    before[kGrowth][k] += model_.growthSum * row[kPush][k] + model_.growthKept * row[kGrowth][k];
  }
  std::memcpy(row, before, sizeof before);
}

template <int kMech>
typename PushObserver<kMech>::Moments PushObserver<kMech>::moments(const State& s, const States& row) const noexcept {
  Lane common{};
  for (int i = 0; i < kScale; ++i) {
    for (int k = 0; k < kLanes; ++k) common[k] += row[i][k] * row[i][k] * s.P[at(i, i)][k];
    for (int j = 0; j < i; ++j)
      for (int k = 0; k < kLanes; ++k) common[k] += 2.0 * row[i][k] * row[j][k] * s.P[at(i, j)][k];
  }
  double first = 0.0, second = 0.0;
  for (int p = 0; p < static_cast<int>(s.count); ++p) {
    const Hypothesis& h = s.part[p];
    Lane mean{}, jump{};
    for (int i = 0; i < kScale; ++i)
      for (int k = 0; k < kLanes; ++k) {
        mean[k] += row[i][k] * h.x[i][k];
        jump[k] += row[i][k] * h.g[i][k];
      }
    double m = 0.0, v = 0.0;
    for (int k = 0; k < static_cast<int>(s.modes); ++k) {
      m += mean[k];
      v += common[k] + jump[k] * jump[k] * h.v[k];
    }
    first += s.weight[p] * m;
    second += s.weight[p] * (v + m * m);
  }
  return {first, std::sqrt(std::max(0.0, second - first * first))};
}

template class PushObserver<2>;
template class PushObserver<4>;

}  // namespace enamel
