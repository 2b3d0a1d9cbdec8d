#include "render/push_observer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "render/observer_steps.hpp"

namespace enamel {
namespace {

constexpr double kRefreshed = 2e-3, kStiffer = 1e-2;  // changes of ln(inertia), ln(stiffness) that update the model

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
PushObserver<kMech>::PushObserver(const std::vector<ModeData>& designs, const JointVector& unseen)
    : designs_(designs), data_(designs.front()), gains_(designs.size()), model_{} {
  for (std::size_t i = 0; i < designs.size(); ++i)
    for (Eigen::Index j = 0; j < unseen.size(); ++j)
      gains_[i][static_cast<std::size_t>(j)] = gainTableOf<kMech>(designs[i], unseen[j]);
  for (int c = 0; c < kCables; ++c) {
    ModeData data = data_;
    data.drive.stiffness *= std::exp(kCableStep * (c - kCables / 2));
    models_[static_cast<std::size_t>(c)] = modelTableOf<kMech>(data);
  }
  (void)steps<kMech>();  // detects the processor now, not in a tick
  // Zero if it is negligible: its products with covariances would be denormal numbers, which take a third of a tick.
  const double kept = std::exp(-lagOf(data_.drive) * data_.period);
  model_.lagKept = kept > std::numeric_limits<double>::epsilon() ? kept : 0.0;
  model_.growthKept = std::exp(-data_.period / kGrowthTime);
  model_.stiffness = data_.drive.stiffness;
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
  const auto* before = &gainsOf(s, k);
  s.joint[k] = reading.joint;
  if (&gainsOf(s, k) != before) s.used[k] = 0.0;  // refresh() reads the other table
}

template <int kMech>
void PushObserver<kMech>::forget(State& s) const noexcept {
  s.scale = s.cable = 0.0;
  s.scaleVariance = kScalePrior * kScalePrior;
  s.cableVariance = kMech == 4 ? kCablePrior * kCablePrior : 0.0;
  std::memset(s.byCable, 0, sizeof s.byCable);
}

template <int kMech>
void PushObserver<kMech>::start(State& s, int modes, const Lane& reading) noexcept {
  s.modes = modes;
  s.count = 1.0;
  forget(s);
  for (int k = modes; k < kLanes; ++k) {
    s.inertia[k] = s.readingVariance[k] = s.largestStep[k] = 1.0;
    s.step[k] = s.tremor[k] = s.joint[k] = 0.0;
  }
  for (int k = 0; k < kLanes; ++k) s.used[k] = k < modes ? 0.0 : 1.0;
  s.usedScale = Lane{};
  refresh(s);
  s.part[0] = Hypothesis{};
  std::memset(s.P, 0, sizeof s.P);
  for (int k = 0; k < modes; ++k) s.P[at(kScale, kScale)][k] = kScalePrior * kScalePrior;
  believe(s, reading, Lane{});
}

template <int kMech>
void PushObserver<kMech>::believe(State& s, const Lane& reading, const Lane& rate) const noexcept {
  s.count = 1.0;
  std::memset(s.byCable, 0, sizeof s.byCable);
  std::memset(s.byDelay, 0, sizeof s.byDelay);
  Hypothesis& h = s.part[0];
  s.weight = s.age = Lane{};
  s.weight[0] = 1.0;
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
      const double stretch = s.step[k] / model_.stiffness;
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
void PushObserver<kMech>::use(State& s, int design) const noexcept {
  s.design = design;
  forget(s);
  const auto shift = [](const States& by, States& x) {
    for (int i = 0; i < kScale; ++i)
      for (int k = 0; k < kLanes; ++k) x[i][k] += by[i][k];
  };
  for (int p = 0; p < static_cast<int>(s.count); ++p) shift(s.byDelay[design], s.part[p].x);
  States back;
  for (int i = 0; i < kStates; ++i)
    for (int k = 0; k < kLanes; ++k) back[i][k] = -s.byDelay[design][i][k];
  for (int d = 0; d < static_cast<int>(s.delays); ++d) shift(back, s.byDelay[d]);
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    for (int p = 0; p < static_cast<int>(s.count); ++p) s.part[p].x[kScale][k] = 0.0;
    for (int i = 0; i < kScale; ++i) s.P[at(kScale, i)][k] = 0.0;
    s.P[at(kScale, kScale)][k] = s.scaleVariance;
    s.used[k] = 0.0;  // refresh() reads the other tables
  }
}

template <int kMech>
void PushObserver<kMech>::refresh(State& s) noexcept {
  const double whole = std::exp(s.scale);
  const bool isStiffer = std::abs(s.cable - s.usedCable) > kStiffer;
  if (isStiffer) {
    s.usedCable = s.cable;
    stiffen(s);
  }
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    const double wanted = s.inertia[k] * whole;
    if (!isStiffer && std::abs(wanted - s.used[k]) < kRefreshed * wanted) continue;
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
      s.byCable[i][k] *= grows(i);
      for (int d = 0; d < static_cast<int>(s.delays); ++d) s.byDelay[d][i][k] *= grows(i);
    }
    read(s, k);
  }
}

// Read the model of mode k at the inertia and the stiffness in use, and its derivatives.
template <int kMech>
void PushObserver<kMech>::read(const State& s, int k) noexcept {
  const double inertia = std::log(s.used[k]);
  gainsOf(s, k).read(inertia, k, model_.value + Numbers::kGainAt);
  if constexpr (kMech == 2) {
    models_[0]->read(inertia, k, model_.value, model_.slope, Numbers::kSlopes);
  } else {
    const double place = std::max(0.0, std::min(s.usedCable / kCableStep + kCables / 2, kCables - 1.0));
    const auto i = static_cast<std::size_t>(std::min(place, kCables - 2.0));
    const double share = place - static_cast<double>(i);
    double other[Numbers::kGainAt][kLanes], slope[Numbers::kSlopes][kLanes];
    models_[i]->read(inertia, k, model_.value, model_.slope, Numbers::kSlopes);
    models_[i + 1]->read(inertia, k, other, slope, Numbers::kSlopes);
    for (int n = 0; n < Numbers::kGainAt; ++n) {
      const double more = other[n][k] - model_.value[n][k];
      if (n < Numbers::kSlopes) {
        model_.byCable[n][k] = more / kCableStep;
        model_.slope[n][k] += share * (slope[n][k] - model_.slope[n][k]);
      }
      model_.value[n][k] += share * more;
    }
  }
}

template <int kMech>
bool PushObserver<kMech>::accepts(const State& s, int modes) const noexcept {
  bool isSound = s.design >= 0.0 && s.design < static_cast<double>(designs_.size()) && s.modes == modes &&
                 s.count >= 1 && s.count <= kMost - kBins;
  for (int p = 0; isSound && p < static_cast<int>(s.count); ++p) isSound = s.weight[p] > 0.0 && s.age[p] == 0.0;
  for (int k = 0; isSound && k < modes; ++k) isSound = s.joint[k] >= 0.0 && s.joint[k] < modes;
  return isSound;
}

template <int kMech>
void PushObserver<kMech>::reload(const State& s) noexcept {
  for (int k = 0; k < std::min(static_cast<int>(s.modes), kLanes); ++k)
    if (s.used[k] > 0.0) read(s, k);
  stiffen(s);
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
  for (int n = 0; n < kScale; ++n) {
    turn(s.mean[n]);
    turn(s.byCable[n]);
    for (int d = 0; d < static_cast<int>(s.delays); ++d) turn(s.byDelay[d][n]);
  }
}

template <int kMech>
void PushObserver<kMech>::predict(State& s, const Lane& command, const Lane& variance) const noexcept {
  steps<kMech>().predict(data_, model_, command, variance, s);
}

template <int kMech>
void PushObserver<kMech>::shift(State& s, double seconds) const noexcept {
  steps<kMech>().shift(data_.drive, model_.stiffness, seconds, s);
}

template <int kMech>
double PushObserver<kMech>::surprise(const State& s, const Lane& reading) const noexcept {
  const int read = readState();
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
void PushObserver<kMech>::innovation(const State& s, const Lane& reading, Lane& difference,
                                     Lane& variance) const noexcept {
  steps<kMech>().innovation(readState(), reading, s, difference, variance);
}

template <int kMech>
void PushObserver<kMech>::correct(State& s, const Lane& reading) const noexcept {
  steps<kMech>().correct(data_, model_, readState(), reading, s);
}

template <int kMech>
void PushObserver<kMech>::merge(State& s) const noexcept {
  steps<kMech>().merge(s);
}

template <int kMech>
void PushObserver<kMech>::advance(const Lane& command, States& x) const noexcept {
  steps<kMech>().carry(model_, command, Lane{}, 0.0, x);
}

template <int kMech>
void PushObserver<kMech>::advanceSensitivity(const Lane& command, const States& x, States& d) const noexcept {
  steps<kMech>().advanceSensitivity(model_, command, x, d);
}

template <int kMech>
void PushObserver<kMech>::law(const State& s, const States& x, const Lane* pending, ControlLaw& law) const noexcept {
  const int older = data(s).delayHigh - data(s).delayLow;
  const double compliance = kMech == 4 ? 1.0 / model_.stiffness : 0.0;
  law.stiffness.fill(1.0);
  law.lead.fill(0.0);
  law.wouldBe.fill(0.0);
  for (int k = 0; k < static_cast<int>(s.modes); ++k) {
    const auto g = [&](int i) { return gain(i)[k]; };
    const double p = x[kPush][k] + 0.5 * data_.period * x[kGrowth][k];
    double asked = p + g(0) * x[0][k] + g(1) * x[1][k] + g(kMech) * (x[kLag][k] + p);
    for (int j = 0; j < older; ++j) asked += model_.value[Numbers::kPendingAt + j][k] * (pending[j][k] + p);
    double damping = g(1);
    law.stiffness[k] = g(0);
    if (kMech == 4) {
      asked += g(0) * p * compliance + g(2) * x[2][k] + g(3) * x[3][k];
      law.stiffness[k] += g(2);
      damping += g(3);
    }
    law.wouldBe[k] = asked / law.stiffness[k];
    law.lead[k] = damping / law.stiffness[k];
  }
}

template <int kMech>
void PushObserver<kMech>::pullBack(States& row) const noexcept {
  steps<kMech>().pullBack(model_, row);
}

template <int kMech>
typename PushObserver<kMech>::Moments PushObserver<kMech>::moments(const State& s, const States& row) const noexcept {
  return steps<kMech>().moments(s, row);
}

template class PushObserver<2>;
template class PushObserver<4>;

}  // namespace enamel
