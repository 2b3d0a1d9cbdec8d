// The steps of PushObserver in which the time goes, over all modes side by side. Included once for each SIMD level, in
// an anonymous namespace. No product is fused with a sum: all levels give the same bits.

constexpr double kJumpRate = 1.0;                           // steps of the hand a second
constexpr double kLeastForce = 0.1;                         // of a step: the model lacks its share of at least that
constexpr double kScaleWander = 0.03;                       // of ln(mass), in a root second
constexpr double kMostScale = 0.5;                          // of ln(mass)
constexpr double kForgotten = 4e-18, kLeastWeight = 1e-26;  // of hypotheses; of the first

// Deviation of the growth of a push that begins with a step.
inline double growthOf(double step) noexcept { return 0.7 / kGrowthTime * step; }

// e^x for x <= 0, to 1e-9: 2^n and a polynomial.
inline double exponentialOf(double x) noexcept {
  constexpr double kRound = 6755399441055744.0, kLn2 = 0.69314718055994531;  // 1.5 2^52: the last bits become n
  const double shifted = std::max(x, -700.0) * (1.0 / kLn2) + kRound;
  const double f = std::max(x, -700.0) - (shifted - kRound) * kLn2;
  std::int64_t bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  bits = static_cast<std::int64_t>((static_cast<std::uint64_t>(bits) + 1023u) << 52);
  double power;
  std::memcpy(&power, &bits, sizeof power);
  const double p =
      1.0 +
      f * (1.0 + f / 2.0 * (1.0 + f / 3.0 * (1.0 + f / 4.0 * (1.0 + f / 5.0 * (1.0 + f / 6.0 * (1.0 + f / 7.0))))));
  return power * p;
}

// The normal distribution's tail over its density (Mills' ratio) for t >= 0, to 4e-8: a rational function fitted to it.
inline double tailOverDensity(double t) noexcept {
  const double above = 92.2835971468 + t * (86.6668246159 + t * (38.2572925158 + t * (9.04015486331 + t)));
  const double below =
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
  using Table = ModeTable<kMech>;
  static constexpr int kLag = Observer::kLag, kPush = Observer::kPush, kGrowth = Observer::kGrowth,
                       kScale = Observer::kScale, kStates = Observer::kStates, kFree = kMech + 3,
                       kMost = Observer::kMost;
  static constexpr int at(int i, int j) { return Observer::at(i, j); }

  // How the mechanical states after a tick change with ln(mass), where it `matters` (1, else 0).
  static void slopes(const Model& m, const double* command, const double* matters, const States& x,
                     double (&slope)[kMech][kLanes]) noexcept {
    for (int i = 0; i < kMech; ++i) {
      for (int k = 0; k < kLanes; ++k) slope[i][k] = m.slope[Table::kCommandAt + i][k] * command[k];
      for (int j = 0; j <= kLag; ++j)
        for (int k = 0; k < kLanes; ++k) slope[i][k] += m.slope[i * kFree + j][k] * x[j][k];
      for (int k = 0; k < kLanes; ++k) slope[i][k] *= matters[k];
    }
  }

  // States after a tick, ln(mass) off the model's by x[kScale] - scale.
  static void carry(const Model& m, const double* command, const double* matters, double scale, States& x) noexcept {
    double slope[kMech][kLanes];
    slopes(m, command, matters, x, slope);
    move(m, command, slope, scale, x);
  }
  static void move(const Model& m, const double* command, const double (&slope)[kMech][kLanes], double scale,
                   States& x) noexcept {
    double moved[kMech][kLanes];
    for (int i = 0; i < kMech; ++i) {
      for (int k = 0; k < kLanes; ++k)
        moved[i][k] = m.value[Table::kCommandAt + i][k] * command[k] + slope[i][k] * (x[kScale][k] - scale);
      for (int j = 0; j < kFree; ++j)
        for (int k = 0; k < kLanes; ++k) moved[i][k] += m.value[i * kFree + j][k] * x[j][k];
    }
    for (int i = 0; i < kMech; ++i)
      for (int k = 0; k < kLanes; ++k) x[i][k] = moved[i][k];
    for (int k = 0; k < kLanes; ++k) {
      x[kLag][k] = m.lagKept * x[kLag][k] + (1.0 - m.lagKept) * command[k];
      x[kPush][k] += m.growthSum * x[kGrowth][k];
      x[kGrowth][k] *= m.growthKept;
    }
  }

  // x and P after a tick: P is G P G^T + Q with G the transition, its column of ln(mass) by the slopes.
  static void propagate(const Model& m, const double* command, const double* matters, double scale, const Pairs& Q,
                        States& x, Pairs& P) noexcept {
    const double em = m.lagKept, eg = m.growthKept, cg = m.growthSum;
    double slope[kMech][kLanes], half[kMech][kStates][kLanes];
    slopes(m, command, matters, x, slope);
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j < kStates; ++j) {
        for (int k = 0; k < kLanes; ++k) half[i][j][k] = slope[i][k] * P[at(kScale, j)][k];
        for (int l = 0; l < kFree; ++l)
          for (int k = 0; k < kLanes; ++k) half[i][j][k] += m.value[i * kFree + l][k] * P[at(l, j)][k];
      }
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j <= i; ++j) {
        double* p = P[at(i, j)];
        for (int k = 0; k < kLanes; ++k) p[k] = half[i][kScale][k] * slope[j][k] + Q[at(i, j)][k];
        for (int l = 0; l < kFree; ++l)
          for (int k = 0; k < kLanes; ++k) p[k] += half[i][l][k] * m.value[j * kFree + l][k];
      }
    for (int i = 0; i < kMech; ++i)
      for (int k = 0; k < kLanes; ++k) {
        P[at(kLag, i)][k] = em * half[i][kLag][k];
        P[at(kPush, i)][k] = half[i][kPush][k] + cg * half[i][kGrowth][k] + Q[at(kPush, i)][k];
        P[at(kGrowth, i)][k] = eg * half[i][kGrowth][k] + Q[at(kGrowth, i)][k];
        P[at(kScale, i)][k] = half[i][kScale][k];
      }
    for (int k = 0; k < kLanes; ++k) {
      const double ml = P[at(kPush, kLag)][k], gl = P[at(kGrowth, kLag)][k], pp = P[at(kPush, kPush)][k],
                   gp = P[at(kGrowth, kPush)][k], gg = P[at(kGrowth, kGrowth)][k], sl = P[at(kScale, kLag)][k],
                   sp = P[at(kScale, kPush)][k], sg = P[at(kScale, kGrowth)][k];
      P[at(kLag, kLag)][k] *= em * em;
      P[at(kPush, kLag)][k] = em * (ml + cg * gl);
      P[at(kGrowth, kLag)][k] = em * eg * gl;
      P[at(kPush, kPush)][k] = pp + cg * (2.0 * gp + cg * gg) + Q[at(kPush, kPush)][k];
      P[at(kGrowth, kPush)][k] = eg * (gp + cg * gg) + Q[at(kGrowth, kPush)][k];
      P[at(kGrowth, kGrowth)][k] = eg * eg * gg + Q[at(kGrowth, kGrowth)][k];
      P[at(kScale, kLag)][k] = em * sl;
      P[at(kScale, kPush)][k] = sp + cg * sg;
      P[at(kScale, kGrowth)][k] = eg * sg;
      P[at(kScale, kScale)][k] += Q[at(kScale, kScale)][k];
    }
    move(m, command, slope, scale, x);
  }

  // What a reading says that differs by `innovation` from what was expected with the variance `expected`. With
  // z = (true - expected) / d, d^2 the variance of all that is Gaussian, z is within [l, u]: the moments of a truncated
  // Gaussian, from the side on which its mean is. `precision`: 1 / the root of the reading's variance.
  static void weigh(const double* innovation, const double* expected, const double* variance, const double* precision,
                    const double* largest, Evidence& seen) noexcept {
    constexpr double kNarrow = 0.1, kFar = 30.0, kPerRootTwoPi = 0.3989422804014327, kUniform = 1.0 / 12.0;
    for (int k = 0; k < kLanes; ++k) {
      const double all = expected[k] + variance[k], gaussian = all - kUniform * largest[k] * largest[k];
      const double perD = 1.0 / std::sqrt(gaussian), width = largest[k] * perD;
      const double centre = std::abs(innovation[k]) * perD, l = centre - 0.5 * width, u = centre + 0.5 * width;
      const double atL = exponentialOf(-0.5 * l * l) * kPerRootTwoPi, ratio = exponentialOf(-centre * width);
      const double tailL = tailOverDensity(std::abs(l)), tailU = ratio * tailOverDensity(std::abs(u));
      const double inside = l > 0.0 ? tailL - tailU : 1.0 - atL * (tailL + tailU);  // its share, over the density at l
      const double perInside = 1.0 / inside, density = (l > 0.0 ? 1.0 : atL) * perInside;
      const double mean = density * (1.0 - ratio), shrinks = mean * mean - density * (l - u * ratio);
      const double as = gaussian / std::min(std::max(shrinks, 1e-9), 1.0);
      const bool cut = width > kNarrow && l < kFar;
      seen.innovation[k] = cut ? std::copysign(mean, innovation[k]) * as * perD : innovation[k];
      seen.variance[k] = cut ? as : all;
      seen.square[k] = cut ? (l > 0.0 ? l * l : 0.0) : innovation[k] * innovation[k] / all;
      const double wide = largest[k] * precision[k] * perInside;
      seen.volume[k] = cut ? (l > 0.0 ? wide : wide * kPerRootTwoPi) : std::sqrt(all) * precision[k];
    }
  }

  // The gains of a reading of state `read` by 1 / its variance, its column of P before, and P after. They teach of the
  // mass as well.
  static void correctCovariance(const Lane& inverse, int read, Pairs& P, States& column, States& gain) noexcept {
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) {
        column[i][k] = P[at(i, read)][k];
        gain[i][k] = column[i][k] * inverse[k];
      }
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < kLanes; ++k) P[at(i, j)][k] -= gain[i][k] * column[j][k];
  }

  // Adds to P the share of a hypothesis with states x about the mean, and a jump along g whose size has the variance v.
  static void gather(const States& x, const States& g, const Lane& v, const States& mean, double share,
                     Pairs& P) noexcept {
    double away[kStates][kLanes], jump[kStates][kLanes], size[kLanes];
    const double root = std::sqrt(share);
    for (int k = 0; k < kLanes; ++k) size[k] = std::sqrt(share * v[k]);
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) {
        away[i][k] = root * (x[i][k] - mean[i][k]);
        jump[i][k] = size[k] * g[i][k];
      }
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < kLanes; ++k) P[at(i, j)][k] += away[i][k] * away[j][k] + jump[i][k] * jump[j][k];
  }

  // A tick under a command, with the hypotheses that branch off in it.
  static void predict(const ModeData& data, const Model& m, const Lane& command, State& s) noexcept {
    const auto& value = m.value;
    const int modes = static_cast<int>(s.modes), count = static_cast<int>(s.count);
    // Process noise. What the model lacks scales with what accelerates the device; where it also stretches cables, with
    // the force itself: that keeps the margin of the controller to a wrong resonance (loop transfer recovery).
    Lane rotor{}, link{}, growth{}, matters{};
    for (int k = 0; k < modes; ++k) {
      const double push = s.mean[kPush][k], net = std::abs(command[k] + push);
      double force = std::max(net, kLeastForce * s.step[k]);
      // The rounding of encoders is not a noise that many readings average out: where what is not known of the mass
      // moves a mode by less than the rounding in a tick, the mass is taken as known.
      const double moves = 0.5 * net * data.period * data.period / (s.used[k] + data.drive.rotorInertia);
      matters[k] = moves * moves * s.scaleVariance > s.readingVariance[k] ? 1.0 : 0.0;
      if (kMech == 4) force = std::max(force, std::max(std::abs(command[k]), std::abs(push)));
      const double lacks = data.modelError * force, disturbance = data.drive.disturbance;
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
    for (int k = 0; k < kLanes; ++k) Q[at(kScale, kScale)][k] = kScaleWander * kScaleWander * data.period;

    propagate(m, command.data(), matters.data(), s.scale, Q, s.part[0].x, s.P);
    for (int p = 1; p < count; ++p) {
      Hypothesis& h = s.part[p];
      carry(m, command.data(), matters.data(), s.scale, h.x);
      carry(m, Lane{}.data(), Lane{}.data(), 0.0, h.g);
      h.age += 1.0;
    }
    for (int b = 0; b < kBins; ++b) {
      Hypothesis& h = s.part[count + b];
      h = s.part[0];
      h.weight *= kJumpRate * 1e-3 / kBins;
      std::memcpy(h.g, value + Table::kOnsetAt + b * kMech, kMech * sizeof h.g[0]);
      for (int k = 0; k < kLanes; ++k) {
        h.g[kPush][k] = 1.0;
        h.v[k] = s.step[k] * s.step[k];
      }
    }
    s.part[0].weight *= 1.0 - kJumpRate * 1e-3;
    s.count = count + kBins;
  }

  // Every hypothesis and its weight by a reading of state `read`.
  static void correct(int read, const Lane& reading, State& s) noexcept {
    const int modes = static_cast<int>(s.modes), count = static_cast<int>(s.count);
    States column, gain;
    double square[kMost], volume[kMost], least = 1e300;
    for (int p = 0; p < count; ++p) {
      Hypothesis& h = s.part[p];
      Lane e{}, expected, jumped;
      for (int k = 0; k < kLanes; ++k) {
        jumped[k] = h.v[k] * h.g[read][k];  // none of the first
        expected[k] = (p == 0 ? s.P[at(read, read)][k] : column[read][k]) + jumped[k] * h.g[read][k];
      }
      for (int k = 0; k < modes; ++k) e[k] = reading[k] - h.x[read][k];
      Evidence seen;
      weigh(e.data(), expected.data(), s.readingVariance.data(), s.readingPrecision.data(), s.largestStep.data(), seen);
      square[p] = 0.0;
      volume[p] = 1.0;
      for (int k = 0; k < modes; ++k) {
        square[p] += seen.square[k];
        volume[p] *= seen.volume[k];
      }
      least = std::min(least, square[p]);
      Lane inverse;
      for (int k = 0; k < kLanes; ++k) inverse[k] = 1.0 / seen.variance[k];
      if (p == 0) {
        correctCovariance(inverse, read, s.P, column, gain);
        for (int i = 0; i < kStates; ++i)
          for (int k = 0; k < kLanes; ++k) h.x[i][k] += gain[i][k] * seen.innovation[k];
        for (int k = 0; k < kLanes; ++k) h.x[kScale][k] = std::min(std::max(h.x[kScale][k], -kMostScale), kMostScale);
        continue;
      }
      double per[kLanes], seenJump[kLanes];
      for (int k = 0; k < kLanes; ++k) {
        per[k] = seen.innovation[k] * inverse[k];
        h.v[k] -= jumped[k] * jumped[k] * inverse[k];
        seenJump[k] = h.g[read][k];
      }
      for (int i = 0; i < kScale; ++i)
        for (int k = 0; k < kLanes; ++k) {
          h.x[i][k] += (column[i][k] + jumped[k] * h.g[i][k]) * per[k];
          h.g[i][k] -= gain[i][k] * seenJump[k];
        }
    }
    double sum = 0.0;
    for (int p = 0; p < count; ++p) {
      s.part[p].weight *= exponentialOf(0.5 * (least - square[p])) / volume[p];
      sum += s.part[p].weight;
    }
    for (int p = 0; p < count; ++p) s.part[p].weight /= sum;
  }

  // Ends hypotheses that are old, and sums up: mean, weights, scale.
  static void merge(State& s) noexcept {
    const int count = static_cast<int>(s.count);
    const auto ends = [&](int p) { return p == 0 || s.part[p].age >= 1.0; };
    double total = 0.0;
    int ending = 0;
    for (int p = 0; p < count; ++p) {
      if (!ends(p)) continue;
      total += s.part[p].weight;
      ++ending;
    }
    if (ending > 1 && total > 0.0) {
      States x = {};
      for (int p = 0; p < count; ++p) {
        const double share = s.part[p].weight / total;
        for (int i = 0; ends(p) && i < kStates; ++i)
          for (int k = 0; k < kLanes; ++k) x[i][k] += share * s.part[p].x[i][k];
      }
      for (int p = 0; p < count; ++p) {
        if (!ends(p)) continue;
        const double share = s.part[p].weight / total, jumped = p > 0 ? share : 0.0;
        gather(s.part[p].x, s.part[p].g, s.part[p].v, x, share, s.P);
        for (int k = 0; k < kLanes; ++k)
          s.P[at(kGrowth, kGrowth)][k] += jumped * growthOf(s.step[k]) * growthOf(s.step[k]);
      }
      std::memcpy(s.part[0].x, x, sizeof x);
    }
    s.part[0].weight = std::max(total, kLeastWeight);
    int kept = 1;
    for (int p = 1; p < count; ++p) {
      if (ends(p) || !(s.part[p].weight > kForgotten)) continue;
      if (p != kept) s.part[kept] = s.part[p];
      ++kept;
    }
    s.count = kept;
    std::memset(s.mean, 0, sizeof s.mean);
    for (int p = 0; p < kept; ++p)
      for (int i = 0; i < kStates; ++i)
        for (int k = 0; k < kLanes; ++k) s.mean[i][k] += s.part[p].weight * s.part[p].x[i][k];
    // One mass for all modes, by what each knows of it beyond the prior. The same unknown force of the hand disturbs
    // all of them, so they are not independent: their information is averaged (Julier and Uhlmann 1997).
    constexpr double kPrior = 1.0 / (Observer::kScalePrior * Observer::kScalePrior);
    double sum = 0.0, squares = 0.0, weighted = 0.0;
    for (int k = 0; k < static_cast<int>(s.modes); ++k) {
      double variance = 0.0;
      for (int p = 0; p < kept; ++p) {
        const double e = s.part[p].x[kScale][k] - s.mean[kScale][k];
        variance += s.part[p].weight * (s.P[at(kScale, kScale)][k] + e * e);
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

  // Mean and deviation of a linear function of the states.
  static Moments moments(const State& s, const States& row) noexcept {
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
      first += s.part[p].weight * m;
      second += s.part[p].weight * (v + m * m);
    }
    return {first, std::sqrt(std::max(0.0, second - first * first))};
  }
};

template <int kMech>
constexpr ObserverSteps<kMech> kSteps{Steps<kMech>::carry,   Steps<kMech>::predict, Steps<kMech>::weigh,
                                      Steps<kMech>::correct, Steps<kMech>::merge,   Steps<kMech>::moments};
