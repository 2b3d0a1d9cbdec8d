// Hot loops of PushObserver over all modes in parallel. Included once for each SIMD level, in an anonymous namespace.
// No product is fused with a sum, so that all levels give the same bits.

// Return e^x for x <= 0, accurate to 1e-9, as 2^n times a polynomial.
inline double exponentialOf(double x) noexcept {
  constexpr double kRound = 6755399441055744.0, kLn2 = 0.69314718055994531;  // 1.5 2^52 moves n into the last bits
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

// Tail of the normal distribution over its density (Mills' ratio) for t >= 0: a fitted rational function, good to 4e-8.
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
  using States = typename Observer::States;
  using Pairs = typename Observer::Pairs;
  using Table = ModeTable<kMech>;
  static constexpr int kLag = Observer::kLag, kPush = Observer::kPush, kGrowth = Observer::kGrowth,
                       kScale = Observer::kScale, kStates = Observer::kStates, kFree = kMech + 3;
  static constexpr int at(int i, int j) { return Observer::at(i, j); }

  // Derivatives of the mechanical states after a tick by ln(mass), in the modes where it `matters` (1, else 0).
  static void slopes(const Model& m, const double* command, const double* matters, const States& x,
                     double (&slope)[kMech][kLanes]) noexcept {
    for (int i = 0; i < kMech; ++i) {
      for (int k = 0; k < kLanes; ++k) slope[i][k] = m.slope[Table::kCommandAt + i][k] * command[k];
      for (int j = 0; j <= kLag; ++j)
        for (int k = 0; k < kLanes; ++k) slope[i][k] += m.slope[i * kFree + j][k] * x[j][k];
      for (int k = 0; k < kLanes; ++k) slope[i][k] *= matters[k];
    }
  }

  // States after a tick. Their ln(mass) differs from the model's by x[kScale] - scale.
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

  // x and P after a tick: P becomes G P G^T + Q with the transition G. Its column for ln(mass) is given by the slopes.
  static void predict(const Model& m, const double* command, const double* matters, double scale, const Pairs& Q,
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

  // Weigh a reading that differs from its prediction by `innovation`; the prediction has the variance `expected`. d^2
  // is the variance of all Gaussian parts, and z = (true - expected) / d is within [l, u]. The result has the moments
  // of this truncated Gaussian, computed from the end that is nearer to the Gaussian's mean.
  static void weigh(const double* innovation, const double* expected, const double* variance, const double* largest,
                    Evidence& seen) noexcept {
    constexpr double kNarrow = 0.1, kFar = 30.0, kRootTwoPi = 2.5066282746310002;
    for (int k = 0; k < kLanes; ++k) {
      const double uniform = largest[k] * largest[k] / 12.0, all = expected[k] + variance[k];
      const double gaussian = all - uniform, d = std::sqrt(gaussian), width = largest[k] / d;
      const double centre = std::abs(innovation[k]) / d, l = centre - 0.5 * width, u = centre + 0.5 * width;
      const double atL = exponentialOf(-0.5 * l * l) / kRootTwoPi, ratio = exponentialOf(-centre * width);
      const double tailL = tailOverDensity(std::abs(l)), tailU = ratio * tailOverDensity(std::abs(u));
      const double inside = l > 0.0 ? tailL - tailU : 1.0 - atL * (tailL + tailU);  // share inside / density at l
      const double density = (l > 0.0 ? 1.0 : atL) / inside;
      const double mean = density * (1.0 - ratio), shrinks = mean * mean - density * (l - u * ratio);
      const double as = gaussian / std::min(std::max(shrinks, 1e-9), 1.0);
      const bool cut = width > kNarrow && l < kFar;
      seen.innovation[k] = cut ? std::copysign(mean, innovation[k]) * as / d : innovation[k];
      seen.variance[k] = cut ? as : all;
      seen.square[k] = cut ? (l > 0.0 ? l * l : 0.0) : innovation[k] * innovation[k] / all;
      const double wide = largest[k] / std::sqrt(variance[k]) / inside;
      seen.volume[k] = cut ? (l > 0.0 ? wide : wide / kRootTwoPi) : std::sqrt(all / variance[k]);
    }
  }

  // Gains of a reading of state `read`, its column of P before, and P after. Readings also correct the mass.
  static void correct(const double* variance, int read, Pairs& P, States& column, States& gain) noexcept {
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) {
        column[i][k] = P[at(i, read)][k];
        gain[i][k] = column[i][k] / variance[k];
      }
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < kLanes; ++k) P[at(i, j)][k] -= gain[i][k] * column[j][k];
  }

  // Add to P the share of a hypothesis with states x around the mean, and of its jump along g with size variance v.
  static void gather(const States& x, const States& g, const Lane& v, const States& mean, double share,
                     Pairs& P) noexcept {
    double away[kStates][kLanes], jump[kStates][kLanes];
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) {
        away[i][k] = std::sqrt(share) * (x[i][k] - mean[i][k]);
        jump[i][k] = std::sqrt(share * v[k]) * g[i][k];
      }
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < kLanes; ++k) P[at(i, j)][k] += away[i][k] * away[j][k] + jump[i][k] * jump[j][k];
  }
};

template <int kMech>
constexpr ObserverSteps<kMech> kSteps{Steps<kMech>::carry, Steps<kMech>::predict, Steps<kMech>::weigh,
                                      Steps<kMech>::correct, Steps<kMech>::gather};
