// Hot loops of PushObserver over all modes in parallel. Included once for each SIMD level, in an anonymous namespace.
// No product is fused with a sum, so that all levels give the same bits.
#include "wide.inl"

constexpr double kJumpRate = 1.0;                           // steps of the hand per second
constexpr double kLeastForce = 0.1;                         // share of a step: smallest force for the model error
constexpr double kScaleWander = 0.03;                       // deviation of ln(mass), ln(stiffness) per root second
constexpr double kMostScale = 0.5;                          // limit of both
constexpr double kLargestFriction = 3.0;                    // its deviations
constexpr double kForgotten = 4e-18, kLeastWeight = 1e-26;  // smallest weights: of a hypothesis, of the first one
constexpr double kLeastLogarithm = -200.0;                  // of a likelihood

// Standard deviation of the growth of a push that begins with a step.
inline Wide growthOf(const Wide& step) noexcept { return 0.7 / kGrowthTime * step; }

// Return e^x for x <= 0, accurate to 1e-9, as 2^n times a polynomial.
inline Wide exponentialOf(const Wide& exponent) noexcept {
  constexpr double kRound = 6755399441055744.0, kLn2 = 0.69314718055994531;  // 1.5 2^52 moves n into the last bits
  const Wide x = larger(exponent, -600.0), shifted = x * (1.0 / kLn2) + kRound, f = x - (shifted - kRound) * kLn2;
  const Wide power = each([&](int i) {
    Bits bits;
    std::memcpy(&bits, &shifted.part[i], sizeof bits);
    bits = (bits + 1023u) << 52;
    Part part;
    std::memcpy(&part, &bits, sizeof part);
    return part;
  });
  Wide p = 1.0 + f * (1.0 / 7.0);
  for (const double per : {1.0 / 6.0, 1.0 / 5.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 2.0, 1.0}) p = 1.0 + f * per * p;
  return power * p;
}

// Tail of the normal distribution over its density (Mills' ratio) for t >= 0: a fitted rational function, good to 4e-8.
inline Wide tailOverDensity(const Wide& t) noexcept {
  const Wide above = 92.2835971468 + t * (86.6668246159 + t * (38.2572925158 + t * (9.04015486331 + t)));
  const Wide below =
      73.6316549559 + t * (127.899835069 + t * (95.7568419035 + t * (39.2552261967 + t * (9.04018809296 + t))));
  return above / below;
}

template <int kMech>
struct Steps {
  using Observer = PushObserver<kMech>;
  using Model = typename Observer::Model;
  using State = typename Observer::State;
  using Hypothesis = typename Observer::Hypothesis;
  using Moments = typename Observer::Moments;
  using States = typename Observer::States;
  using Pairs = typename Observer::Pairs;
  using Numbers = ModeNumbers<kMech>;
  static constexpr int kLag = Observer::kLag, kPush = Observer::kPush, kGrowth = Observer::kGrowth,
                       kScale = Observer::kScale, kStates = Observer::kStates, kFree = kMech + 3,
                       kMost = Observer::kMost;
  static constexpr int at(int i, int j) { return Observer::at(i, j); }

  // Derivatives of the mechanical states after a tick by ln(mass), in the modes where it `matters` (1, else 0).
  static void slopes(const Model& m, const Lane& command, const Lane& matters, const States& x,
                     Wide (&slope)[kMech]) noexcept {
    for (int i = 0; i < kMech; ++i) {
      slope[i] = wide(m.slope[Numbers::kCommandAt + i]) * wide(command);
      for (int j = 0; j <= kLag; ++j) slope[i] += wide(m.slope[i * kFree + j]) * wide(x[j]);
      slope[i] *= wide(matters);
    }
  }

  // States after a tick. Their ln(mass) differs from the model's by x[kScale] - scale.
  static void carry(const Model& m, const Lane& command, const Lane& matters, double scale, States& x) noexcept {
    Wide slope[kMech];
    slopes(m, command, matters, x, slope);
    move(m, command, slope, scale, x);
  }
  static void move(const Model& m, const Lane& command, const Wide (&slope)[kMech], double scale, States& x) noexcept {
    Wide forced[kMech];
    for (int i = 0; i < kMech; ++i)
      forced[i] = wide(m.value[Numbers::kCommandAt + i]) * wide(command) + slope[i] * (wide(x[kScale]) - scale);
    const Wide lag = (1.0 - m.lagKept) * wide(command);
    advance(m, x);
    for (int i = 0; i < kMech; ++i) wide(x[i]) += forced[i];
    wide(x[kLag]) += lag;
  }
  // The same without a command, at the model's mass.
  static void advance(const Model& m, States& x) noexcept {
    Wide moved[kMech];
    for (int i = 0; i < kMech; ++i) {
      moved[i] = wide(m.value[i * kFree]) * wide(x[0]);
      for (int j = 1; j < kFree; ++j) moved[i] += wide(m.value[i * kFree + j]) * wide(x[j]);
    }
    for (int i = 0; i < kMech; ++i) wide(x[i]) = moved[i];
    wide(x[kLag]) *= m.lagKept;
    wide(x[kPush]) += m.growthSum * wide(x[kGrowth]);
    wide(x[kGrowth]) *= m.growthKept;
  }

  // The derivative d of states x by ln(mass), after a tick. Its push scales too.
  static void advanceSensitivity(const Model& m, const Lane& command, const States& x, States& d) noexcept {
    advance(m, d);
    for (int i = 0; i < kMech; ++i) {
      wide(d[i]) += wide(m.slope[Numbers::kCommandAt + i]) * wide(command);
      for (int j = 0; j < kFree; ++j) wide(d[i]) += wide(m.slope[i * kFree + j]) * wide(x[j]);
    }
  }

  // A linear function of the states after a tick, as one of the present states.
  static void pullBack(const Model& m, States& row) noexcept {
    Wide before[kFree] = {};
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j < kFree; ++j) before[j] += wide(m.value[i * kFree + j]) * wide(row[i]);
    before[kLag] += m.lagKept * wide(row[kLag]);
    before[kPush] += wide(row[kPush]);
    before[kGrowth] += m.growthSum * wide(row[kPush]) + m.growthKept * wide(row[kGrowth]);
    for (int i = 0; i < kFree; ++i) wide(row[i]) = before[i];
    std::memset(row[kScale], 0, sizeof row[kScale]);
  }

  // x and P after a tick: P becomes G P G^T + Q with the transition G. Its column for ln(mass) is given by the slopes.
  static void propagate(const Model& m, const Lane& command, const Wide (&slope)[kMech], double scale,
                        const Wide (&Q)[Observer::kPairs], States& x, Pairs& P) noexcept {
    const double em = m.lagKept, eg = m.growthKept, cg = m.growthSum;
    const auto p = [&P](int i, int j) { return wide(P[at(i, j)]); };
    Wide half[kMech][kStates];
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j < kStates; ++j) {
        half[i][j] = slope[i] * p(kScale, j);
        for (int l = 0; l < kFree; ++l) half[i][j] += wide(m.value[i * kFree + l]) * p(l, j);
      }
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j <= i; ++j) {
        Wide sum = half[i][kScale] * slope[j] + Q[at(i, j)];
        for (int l = 0; l < kFree; ++l) sum += half[i][l] * wide(m.value[j * kFree + l]);
        p(i, j) = sum;
      }
    for (int i = 0; i < kMech; ++i) {
      p(kLag, i) = em * half[i][kLag];
      p(kPush, i) = half[i][kPush] + cg * half[i][kGrowth] + Q[at(kPush, i)];
      p(kGrowth, i) = eg * half[i][kGrowth] + Q[at(kGrowth, i)];
      p(kScale, i) = half[i][kScale];
    }
    const Wide gl = p(kGrowth, kLag), gp = p(kGrowth, kPush), gg = p(kGrowth, kGrowth), sg = p(kScale, kGrowth);
    p(kLag, kLag) *= em * em;
    p(kPush, kLag) = em * (p(kPush, kLag) + cg * gl);
    p(kGrowth, kLag) = em * eg * gl;
    p(kPush, kPush) += cg * (2.0 * gp + cg * gg) + Q[at(kPush, kPush)];
    p(kGrowth, kPush) = eg * (gp + cg * gg) + Q[at(kGrowth, kPush)];
    p(kGrowth, kGrowth) = eg * eg * gg + Q[at(kGrowth, kGrowth)];
    p(kScale, kLag) *= em;
    p(kScale, kPush) += cg * sg;
    p(kScale, kGrowth) *= eg;
    p(kScale, kScale) += Q[at(kScale, kScale)];
    move(m, command, slope, scale, x);
  }

  // Weigh a reading that differs from its prediction by `innovation`; the prediction has the variance `expected`. d^2
  // is the variance of all Gaussian parts, and z = (true - expected) / d is within [l, u]. The result has the moments
  // of this truncated Gaussian, computed from the end that is nearer to the Gaussian's mean. `precision` is 1 / the
  // reading's standard deviation: with it, products of volumes over the modes stay near 1.
  static void weigh(const Lane& innovation, const Lane& expected, const Lane& variance, const Lane& precision,
                    const Lane& largest, Evidence& seen) noexcept {
    constexpr double kNarrow = 0.1, kFar = 30.0, kPerRootTwoPi = 0.3989422804014327, kUniform = 1.0 / 12.0;
    const Wide e = wide(innovation), step = wide(largest), all = wide(expected) + wide(variance);
    const Wide gaussian = all - kUniform * step * step, perD = 1.0 / rootOf(gaussian), width = step * perD;
    const Wide centre = magnitudeOf(e) * perD, l = centre - 0.5 * width, u = centre + 0.5 * width;
    const Wide atL = exponentialOf(-0.5 * l * l) * kPerRootTwoPi, ratio = exponentialOf(-centre * width);
    const Wide tailL = tailOverDensity(magnitudeOf(l)), tailU = ratio * tailOverDensity(magnitudeOf(u));
    const Mask isOutside = l > 0.0;
    // Share inside / density at l.
    const Wide inside = select(isOutside, tailL - tailU, 1.0 - atL * (tailL + tailU)), perInside = 1.0 / inside;
    const Wide density = select(isOutside, 1.0, atL) * perInside, mean = density * (1.0 - ratio);
    const Wide shrinks = mean * mean - density * (l - u * ratio);
    const Wide as = gaussian / smaller(larger(shrinks, 1e-9), 1.0), volume = step * wide(precision) * perInside;
    const Mask cut = (width > kNarrow) & (l < kFar);
    wide(seen.innovation) = select(cut, select(e < 0.0, -mean, mean) * as * perD, e);
    wide(seen.variance) = select(cut, as, all);
    wide(seen.square) = select(cut, select(isOutside, l * l, 0.0), e * e / all);
    wide(seen.volume) = select(cut, select(isOutside, volume, volume * kPerRootTwoPi), rootOf(all) * wide(precision));
  }

  // Gains of a reading of state `read` by 1 / its variance, its column of P before, and P after. Readings also correct
  // the mass.
  static void correctCovariance(const Wide& inverse, int read, Pairs& P, Wide (&column)[kStates],
                                Wide (&gain)[kStates]) noexcept {
    for (int i = 0; i < kStates; ++i) {
      column[i] = wide(P[at(i, read)]);
      gain[i] = column[i] * inverse;
    }
    for (int i = 0, n = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j, ++n) wide(P[n]) -= gain[i] * column[j];
  }

  // The derivative of the states by ln(stiffness) after a tick. Its part for ln(mass) moves the modes by `slope`.
  static void moveByCable(const Model& m, const Lane& command, const Wide (&slope)[kMech], State& s) noexcept {
    Wide forced[kMech];
    for (int i = 0; i < kMech; ++i) {
      forced[i] = wide(m.byCable[Numbers::kCommandAt + i]) * wide(command) + slope[i] * wide(s.byCable[kScale]);
      for (int j = 0; j < kFree; ++j) forced[i] += wide(m.byCable[i * kFree + j]) * wide(s.mean[j]);
    }
    advance(m, s.byCable);
    for (int i = 0; i < kMech; ++i) wide(s.byCable[i]) += forced[i];
  }

  // Correct ln(stiffness), and all states with it, by what the hypotheses saw. `gain`: of the states. Averaging
  // readings does not remove the rounding of encoders, nor friction. So a mode counts only if the uncertainty of the
  // stiffness changes its reading by more than these. Modes are not independent: their information is averaged.
  static void correctCable(const ModeData& data, const Model& m, int read, const Evidence* seen,
                           const Wide (&gain)[kStates], State& s) noexcept {
    const int count = static_cast<int>(s.count), modes = static_cast<int>(s.modes);
    const double largest = kLargestFriction * data.drive.disturbance;
    const Wide effect = wide(s.byCable[read]), friction = largest * wide(m.value[Numbers::kRotorAt + read]),
               excess = effect * effect * s.cableVariance - friction * friction - wide(s.readingVariance);
    for (int i = 0; i < kStates; ++i) wide(s.byCable[i]) = wide(s.byCable[i]) - gain[i] * effect;
    double most = 0.0;
    for (int k = 0; k < modes; ++k) most = std::max(most, excess[k]);
    if (!(most > 0.0)) return;
    Wide score = {}, information = {};
    for (int p = 0; p < count; ++p) {
      const Wide per = s.weight[p] * effect / wide(seen[p].variance);
      score += per * wide(seen[p].innovation);
      information += per * effect;
    }
    double sum = 0.0, squares = 0.0, scores = 0.0;
    for (int k = 0; k < modes; ++k) {
      if (!(excess[k] > 0.0)) continue;
      sum += information[k];
      squares += information[k] * information[k];
      scores += score[k];
    }
    if (!(sum > 0.0)) return;
    const double share = squares / (sum * sum);
    s.cableVariance = 1.0 / (1.0 / s.cableVariance + share * sum);
    const double cable = std::min(std::max(s.cable + s.cableVariance * share * scores, -kMostScale), kMostScale),
                 change = cable - s.cable;
    s.cable = cable;
    for (int p = 0; p < count; ++p)
      for (int i = 0; i < kStates; ++i) wide(s.part[p].x[i]) += change * wide(s.byCable[i]);
  }

  // A tick under a command of some variance, and new hypotheses of a jump within it.
  static void predict(const ModeData& data, const Model& m, const Lane& command, const Lane& variance,
                      State& s) noexcept {
    const int count = static_cast<int>(s.count);
    // Process noise. The model error scales with the force that accelerates the device. With cables it also scales with
    // the force itself, which keeps the controller's margin to a wrong resonance (loop transfer recovery).
    const Wide push = wide(s.mean[kPush]), step = wide(s.step), net = magnitudeOf(wide(command) + push);
    Wide force = larger(net, kLeastForce * step);
    // A mode teaches the mass in a tick in two cases; else the mass counts as known. In the first, its uncertainty
    // moves the mode by more than the rounding of encoders, which averaging does not remove. In the second, the mode
    // moves by more than a count, so that the rounding is independent from tick to tick. The uncertainty then must
    // surely change the force by more than the hand's tremor. Commands follow the tremor, and the model of the push
    // does not contain it.
    const double T = data.period, deviation = std::sqrt(s.scaleVariance);
    const Wide sure = net - 2.0 * rootOf(wide(s.P[at(kPush, kPush)])),
               travel = T * magnitudeOf(wide(s.mean[kMech - 1]));
    const Wide moved = 0.5 * T * T * deviation * net / (wide(s.used) + data.drive.rotorInertia);
    Lane matters;
    wide(matters) = larger(select(moved * moved > wide(s.readingVariance), 1.0, 0.0),
                           select((travel > wide(s.largestStep)) & (deviation * sure > wide(s.tremor)), 1.0, 0.0));
    if (kMech == 4) force = larger(force, larger(magnitudeOf(wide(command)), magnitudeOf(push)));
    const double lack2 = data.modelError * data.modelError, disturbance = data.drive.disturbance;
    const Wide lacks = lack2 * force * force, rotor = lacks + disturbance * disturbance + wide(variance);
    const Wide tremor = wide(s.tremor) * wide(s.tremor), link = kMech == 4 ? tremor + lacks : tremor;
    // A hand can take away half of its push in the time of a step's growth.
    const Wide growth = kGrowthOfStep * kGrowthOfStep * larger(step * step, 0.25 * push * push);
    Wide Q[Observer::kPairs] = {};
    for (int i = 0, n = 0; i < kMech + 2; ++i)
      for (int j = 0; j <= i; ++j, ++n)
        Q[at(i < kMech ? i : i + 1, j < kMech ? j : j + 1)] = growth * wide(m.value[Numbers::kWanderAt + n]);
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j <= i; ++j)
        Q[at(i, j)] += rotor * wide(m.value[Numbers::kRotorAt + i]) * wide(m.value[Numbers::kRotorAt + j]) +
                       link * wide(m.value[Numbers::kLinkAt + i]) * wide(m.value[Numbers::kLinkAt + j]);
    Q[at(kScale, kScale)] += kScaleWander * kScaleWander * data.period;

    Wide slope[kMech];
    slopes(m, command, matters, s.part[0].x, slope);
    if constexpr (kMech == 4) {
      moveByCable(m, command, slope, s);
      s.cableVariance = std::min(s.cableVariance + kScaleWander * kScaleWander * data.period,
                                 Observer::kCablePrior * Observer::kCablePrior);
    }
    propagate(m, command, slope, s.scale, Q, s.part[0].x, s.P);
    for (int p = 1; p < count; ++p) {
      carry(m, command, matters, s.scale, s.part[p].x);
      advance(m, s.part[p].g);
      s.age[p] += 1.0;
    }
    const double jumps = kJumpRate * data.period;
    for (int b = 0; b < kBins; ++b) {
      Hypothesis& h = s.part[count + b];
      std::memcpy(h.x, s.part[0].x, sizeof h.x);
      std::memset(h.g, 0, sizeof h.g);
      std::memcpy(h.g, m.value + Numbers::kOnsetAt + b * kMech, kMech * sizeof h.g[0]);
      wide(h.g[kPush]) = 1.0;
      wide(h.v) = step * step;
      s.weight[count + b] = jumps / kBins * s.weight[0];
      s.age[count + b] = 0.0;
    }
    s.weight[0] *= 1.0 - jumps;
    s.count = count + kBins;
  }

  // A part of a tick, to the second order: Phi = I + t A + t^2 A^2 / 2 for positions, I + t A for speeds.
  static void shift(const Drive& drive, double stiffness, double seconds, State& s) noexcept {
    constexpr int link = kMech - 2;
    Model m = {};
    m.lagKept = m.growthKept = 1.0;
    const Wide perLink = 1.0 / wide(s.used);
    for (int i = 0; i < kMech; i += 2) {
      Wide acceleration[kFree] = {};
      if (kMech == 4) {
        const Wide perMass = i == 0 ? Wide(-1.0 / drive.rotorInertia) : perLink;
        acceleration[0] = stiffness * perMass;
        acceleration[1] = drive.damping * perMass;
        acceleration[link] = -acceleration[0];
        acceleration[link + 1] = -acceleration[1];
        if (i == 0) acceleration[kLag] = 1.0 / drive.rotorInertia;
      } else {
        acceleration[kLag] = perLink;
      }
      if (i == link) acceleration[kPush] = perLink;
      for (int j = 0; j < kFree; ++j) {
        wide(m.value[i * kFree + j]) = 0.5 * seconds * seconds * acceleration[j];
        wide(m.value[(i + 1) * kFree + j]) = seconds * acceleration[j];
      }
      wide(m.value[i * kFree + i]) += 1.0;
      wide(m.value[i * kFree + i + 1]) += seconds;
      wide(m.value[(i + 1) * kFree + i + 1]) += 1.0;
    }
    const Wide none[kMech] = {}, quiet[Observer::kPairs] = {};
    const Lane command{};
    if constexpr (kMech == 4) {
      const Wide stretch = wide(s.part[0].x[0]) - wide(s.part[0].x[link]);
      advance(m, s.byCable);
      for (int i = 0; i < kMech; ++i) wide(s.byCable[i]) += (wide(m.value[i * kFree]) - (i == 0 ? 1.0 : 0.0)) * stretch;
    }
    propagate(m, command, none, 0.0, quiet, s.part[0].x, s.P);
    for (int d = 0; d < static_cast<int>(s.delays); ++d) advance(m, s.byDelay[d]);
    for (int p = 1; p < static_cast<int>(s.count); ++p) advance(m, s.part[p].x);
    for (int p = 1; p < static_cast<int>(s.count); ++p) advance(m, s.part[p].g);
  }

  // Variance of the predicted state `read` because the stiffness of the cables is uncertain.
  static Wide ofCable(int read, const State& s) noexcept {
    return s.cableVariance * wide(s.byCable[read]) * wide(s.byCable[read]);
  }

  // Difference of a reading of state `read` from its prediction by all hypotheses, and the variance of this difference.
  static void innovation(int read, const Lane& reading, const State& s, Lane& difference, Lane& variance) noexcept {
    Wide mean = {}, square = {};  // relative to the first hypothesis
    for (int p = 0; p < static_cast<int>(s.count); ++p) {
      const Hypothesis& h = s.part[p];
      const Wide away = wide(h.x[read]) - wide(s.part[0].x[read]), g = wide(h.g[read]);
      mean += s.weight[p] * away;
      square += s.weight[p] * (away * away + g * g * wide(h.v));
    }
    wide(difference) = wide(reading) - wide(s.part[0].x[read]) - mean;
    wide(variance) = wide(s.P[at(read, read)]) + ofCable(read, s) + square - mean * mean + wide(s.readingVariance);
  }

  // Correct every hypothesis and its weight by a reading of state `read`.
  static void correct(const ModeData& data, const Model& m, int read, const Lane& reading, State& s) noexcept {
    static_assert(kMost <= kLanes, "one number for each hypothesis fits into a lane");
    const int modes = static_cast<int>(s.modes), count = static_cast<int>(s.count);
    // Weigh all readings first, so that the processor can overlap them.
    Evidence seen[kMost];
    Lane precision;
    wide(precision) = 1.0 / rootOf(wide(s.readingVariance));
    const Wide unknown = ofCable(read, s);
    double square[kLanes] = {}, volume[kLanes], least = 1e300;
    wide(volume) = 1.0;
    for (int p = 0; p < count; ++p) {
      const Hypothesis& h = s.part[p];
      Lane e{}, expected;
      for (int k = 0; k < modes; ++k) e[k] = reading[k] - h.x[read][k];
      wide(expected) = wide(s.P[at(read, read)]) + unknown + wide(h.v) * wide(h.g[read]) * wide(h.g[read]);
      weigh(e, expected, s.readingVariance, precision, s.largestStep, seen[p]);
      for (int k = 0; k < modes; ++k) {
        square[p] += seen[p].square[k];
        volume[p] *= seen[p].volume[k];
      }
      least = std::min(least, square[p]);
    }
    Wide column[kStates], gain[kStates];
    for (int p = 0; p < count; ++p) {
      Hypothesis& h = s.part[p];
      const Wide inverse = 1.0 / wide(seen[p].variance), innovation = wide(seen[p].innovation);
      if (p == 0) {
        correctCovariance(inverse, read, s.P, column, gain);
        for (int i = 0; i < kStates; ++i) wide(h.x[i]) += gain[i] * innovation;
        wide(h.x[kScale]) = smaller(larger(wide(h.x[kScale]), -kMostScale), kMostScale);
        continue;
      }
      const Wide seenJump = wide(h.g[read]), jumped = wide(h.v) * seenJump, per = innovation * inverse;
      wide(h.v) -= jumped * jumped * inverse;
      for (int i = 0; i < kScale; ++i) {
        wide(h.x[i]) += (column[i] + jumped * wide(h.g[i])) * per;
        wide(h.g[i]) -= gain[i] * seenJump;
      }
    }
    const Wide likelihood = exponentialOf(larger(0.5 * (least - wide(square)), kLeastLogarithm)) / wide(volume);
    double sum = 0.0;
    for (int p = 0; p < count; ++p) sum += s.weight[p] *= likelihood[p];
    for (int p = 0; p < count; ++p) s.weight[p] /= sum;
    for (int d = 0; d < static_cast<int>(s.delays); ++d) {
      States& by = s.byDelay[d];
      const Wide effect = wide(by[read]);
      for (int i = 0; i < kScale; ++i) wide(by[i]) = wide(by[i]) - gain[i] * effect;
    }
    if constexpr (kMech == 4) correctCable(data, m, read, seen, gain, s);
  }

  // End old hypotheses, and sum up: mean, weights, scale.
  static void merge(State& s) noexcept {
    const int count = static_cast<int>(s.count);
    int old = 1;  // the first hypothesis, and those after it that have seen two samples
    while (old < count && s.age[old] >= 1.0) ++old;
    double total = 0.0;
    for (int p = 0; p < old; ++p) total += s.weight[p];
    if (old > 1 && total > 0.0) {
      // P of the mixture: each state's distance from the mean, and its jump.
      Wide mean[kStates] = {}, away[kMost][kStates], size[kMost], jumped = {};
      double share[kMost];
      for (int p = 0; p < old; ++p) {
        share[p] = s.weight[p] / total;
        size[p] = share[p] * wide(s.part[p].v);
        if (p > 0) jumped += share[p];
        for (int i = 0; i < kStates; ++i) mean[i] += share[p] * wide(s.part[p].x[i]);
      }
      for (int p = 0; p < old; ++p)
        for (int i = 0; i < kStates; ++i) away[p][i] = wide(s.part[p].x[i]) - mean[i];
      for (int i = 0, n = 0; i < kStates; ++i)
        for (int j = 0; j <= i; ++j, ++n) {
          Wide sum = wide(s.P[n]) + share[0] * away[0][i] * away[0][j];
          for (int p = 1; p < old; ++p)
            sum += share[p] * away[p][i] * away[p][j] + size[p] * wide(s.part[p].g[i]) * wide(s.part[p].g[j]);
          wide(s.P[n]) = sum;
        }
      const Wide growth = growthOf(wide(s.step));
      wide(s.P[at(kGrowth, kGrowth)]) += jumped * growth * growth;
      for (int i = 0; i < kStates; ++i) wide(s.part[0].x[i]) = mean[i];
    }
    s.weight[0] = std::max(total, kLeastWeight);
    int kept = 1;
    for (int p = old; p < count; ++p) {
      if (!(s.weight[p] > kForgotten)) continue;
      s.part[kept] = s.part[p];
      s.weight[kept] = s.weight[p];
      s.age[kept] = s.age[p];
      ++kept;
    }
    s.count = kept;
    Wide mean[kStates] = {};
    for (int p = 0; p < kept; ++p)
      for (int i = 0; i < kStates; ++i) mean[i] += s.weight[p] * wide(s.part[p].x[i]);
    for (int i = 0; i < kStates; ++i) wide(s.mean[i]) = mean[i];
    // One mass for all modes, weighted by the information that each gained over the prior. The same unknown force of
    // the hand disturbs all modes. So they are not independent, and their information is averaged (Julier and Uhlmann
    // 1997).
    constexpr double kPrior = 1.0 / (Observer::kScalePrior * Observer::kScalePrior);
    Wide variance = {};
    for (int p = 0; p < kept; ++p) {
      const Wide e = wide(s.part[p].x[kScale]) - mean[kScale];
      variance += s.weight[p] * (wide(s.P[at(kScale, kScale)]) + e * e);
    }
    if constexpr (kMech == 4) variance += s.cableVariance * wide(s.byCable[kScale]) * wide(s.byCable[kScale]);
    const Wide information = 1.0 / variance - kPrior;
    double sum = 0.0, squares = 0.0, weighted = 0.0;
    for (int k = 0; k < static_cast<int>(s.modes); ++k) {
      const double gained = std::max(0.0, information[k]);
      sum += gained;
      squares += gained * gained;
      weighted += gained * s.mean[kScale][k];
    }
    const double gained = sum > 0.0 ? squares / sum : 0.0;
    s.scaleVariance = 1.0 / (kPrior + gained);
    s.scale = sum > 0.0 ? weighted / sum * gained * s.scaleVariance : 0.0;
    s.scale = std::min(std::max(s.scale, -kMostScale), kMostScale);
  }

  // Mean and standard deviation of a linear function of the states.
  static Moments moments(const State& s, const States& row) noexcept {
    Wide common = {};
    for (int i = 0; i < kScale; ++i) {
      Wide sum = 0.5 * wide(row[i]) * wide(s.P[at(i, i)]);
      for (int j = 0; j < i; ++j) sum += wide(row[j]) * wide(s.P[at(i, j)]);
      common += 2.0 * wide(row[i]) * sum;
    }
    double first = 0.0, second = 0.0;
    for (int p = 0; p < static_cast<int>(s.count); ++p) {
      const Hypothesis& h = s.part[p];
      Wide mean = {}, jump = {};
      for (int i = 0; i < kScale; ++i) {
        mean += wide(row[i]) * wide(h.x[i]);
        jump += wide(row[i]) * wide(h.g[i]);
      }
      const Wide variance = common + jump * jump * wide(h.v);
      double m = 0.0, v = 0.0;
      for (int k = 0; k < static_cast<int>(s.modes); ++k) {
        m += mean[k];
        v += variance[k];
      }
      first += s.weight[p] * m;
      second += s.weight[p] * (v + m * m);
    }
    if constexpr (kMech == 4) {
      Wide sum = {};
      for (int i = 0; i < kScale; ++i) sum += wide(row[i]) * wide(s.byCable[i]);
      double byCable = 0.0;
      for (int k = 0; k < static_cast<int>(s.modes); ++k) byCable += sum[k];
      second += byCable * byCable * s.cableVariance;
    }
    return {first, std::sqrt(std::max(0.0, second - first * first))};
  }
};

template <int kMech>
constexpr ObserverSteps<kMech> kSteps{Steps<kMech>::carry,      Steps<kMech>::advanceSensitivity,
                                      Steps<kMech>::pullBack,   Steps<kMech>::predict,
                                      Steps<kMech>::shift,      Steps<kMech>::weigh,
                                      Steps<kMech>::innovation, Steps<kMech>::correct,
                                      Steps<kMech>::merge,      Steps<kMech>::moments};
