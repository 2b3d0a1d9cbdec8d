// The steps of PushObserver in which the time goes, over all modes side by side. Included once for each SIMD level, in
// an anonymous namespace. No product is fused with a sum: all levels give the same bits.

template <int kMech>
struct Steps {
  using Observer = PushObserver<kMech>;
  using Hypothesis = typename Observer::Hypothesis;
  using Model = typename Observer::Model;
  using Table = ModeTable<kMech>;
  static constexpr int kLag = Observer::kLag, kPush = Observer::kPush, kGrowth = Observer::kGrowth,
                       kScale = Observer::kScale, kStates = Observer::kStates;
  static constexpr int at(int i, int j) { return Observer::at(i, j); }

  // x and P of a hypothesis after a tick: G P G^T + Q with G the transition, its column of ln(mass) by the slopes
  // where it `matters` (1, else 0).
  static void predict(const Model& m, const double* command, const double* matters, double scale,
                      const double (&Q)[Observer::kPairs][kLanes],
                      Hypothesis& h) noexcept {
    constexpr int kFree = kMech + 3;
    const double em = m.lagKept, eg = m.growthKept, cg = m.growthSum;
    double moved[kMech][kLanes], slope[kMech][kLanes], half[kMech][kStates][kLanes];
    for (int i = 0; i < kMech; ++i) {
      for (int k = 0; k < kLanes; ++k) {
        moved[i][k] = m.value[Table::kCommandAt + i][k] * command[k];
        slope[i][k] = m.slope[Table::kCommandAt + i][k] * command[k];
      }
      for (int j = 0; j < kFree; ++j)
        for (int k = 0; k < kLanes; ++k) {
          moved[i][k] += m.value[i * kFree + j][k] * h.x[j][k];
          if (j <= kLag) slope[i][k] += m.slope[i * kFree + j][k] * h.x[j][k];
        }
      for (int k = 0; k < kLanes; ++k) {
        slope[i][k] *= matters[k];
        moved[i][k] += slope[i][k] * (h.x[kScale][k] - scale);
      }
    }
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j < kStates; ++j) {
        for (int k = 0; k < kLanes; ++k) half[i][j][k] = slope[i][k] * h.P[at(kScale, j)][k];
        for (int l = 0; l < kFree; ++l)
          for (int k = 0; k < kLanes; ++k) half[i][j][k] += m.value[i * kFree + l][k] * h.P[at(l, j)][k];
      }
    for (int i = 0; i < kMech; ++i)
      for (int j = 0; j <= i; ++j) {
        double* P = h.P[at(i, j)];
        for (int k = 0; k < kLanes; ++k) P[k] = half[i][kScale][k] * slope[j][k] + Q[at(i, j)][k];
        for (int l = 0; l < kFree; ++l)
          for (int k = 0; k < kLanes; ++k) P[k] += half[i][l][k] * m.value[j * kFree + l][k];
      }
    for (int i = 0; i < kMech; ++i)
      for (int k = 0; k < kLanes; ++k) {
        h.P[at(kLag, i)][k] = em * half[i][kLag][k];
        h.P[at(kPush, i)][k] = half[i][kPush][k] + cg * half[i][kGrowth][k] + Q[at(kPush, i)][k];
        h.P[at(kGrowth, i)][k] = eg * half[i][kGrowth][k] + Q[at(kGrowth, i)][k];
        h.P[at(kScale, i)][k] = half[i][kScale][k];
        h.x[i][k] = moved[i][k];
      }
    for (int k = 0; k < kLanes; ++k) {
      const double ml = h.P[at(kPush, kLag)][k], gl = h.P[at(kGrowth, kLag)][k], pp = h.P[at(kPush, kPush)][k],
                   gp = h.P[at(kGrowth, kPush)][k], gg = h.P[at(kGrowth, kGrowth)][k], sl = h.P[at(kScale, kLag)][k],
                   sp = h.P[at(kScale, kPush)][k], sg = h.P[at(kScale, kGrowth)][k];
      h.P[at(kLag, kLag)][k] *= em * em;
      h.P[at(kPush, kLag)][k] = em * (ml + cg * gl);
      h.P[at(kGrowth, kLag)][k] = em * eg * gl;
      h.P[at(kPush, kPush)][k] = pp + cg * (2.0 * gp + cg * gg) + Q[at(kPush, kPush)][k];
      h.P[at(kGrowth, kPush)][k] = eg * (gp + cg * gg) + Q[at(kGrowth, kPush)][k];
      h.P[at(kGrowth, kGrowth)][k] = eg * eg * gg + Q[at(kGrowth, kGrowth)][k];
      h.P[at(kScale, kLag)][k] = em * sl;
      h.P[at(kScale, kPush)][k] = sp + cg * sg;
      h.P[at(kScale, kGrowth)][k] = eg * sg;
      h.P[at(kScale, kScale)][k] += Q[at(kScale, kScale)][k];
      h.x[kLag][k] = em * h.x[kLag][k] + (1.0 - em) * command[k];
      h.x[kPush][k] += cg * h.x[kGrowth][k];
      h.x[kGrowth][k] *= eg;
    }
  }

  // A reading, with the innovation e and its variance S. `teaches`: of the mass as well.
  static void correct(const double* e, const double* S, int read, bool teaches, Hypothesis& h) noexcept {
    double column[kStates][kLanes], share[kStates][kLanes];
    for (int i = 0; i < kStates; ++i)
      for (int k = 0; k < kLanes; ++k) {
        column[i][k] = h.P[at(i, read)][k];
        share[i][k] = column[i][k] / S[k];
      }
    for (int i = 0; i < kScale + (teaches ? 1 : 0); ++i)
      for (int k = 0; k < kLanes; ++k) h.x[i][k] += share[i][k] * e[k];
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j) {
        if (i == kScale && j == kScale && !teaches) continue;
        for (int k = 0; k < kLanes; ++k) h.P[at(i, j)][k] -= share[i][k] * column[j][k];
      }
  }

  // Adds `weight` of a hypothesis, about the mean x, to P.
  static void gather(const Hypothesis& h, const double (&x)[kStates][kLanes], double weight,
                     double (&P)[Observer::kPairs][kLanes]) noexcept {
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < kLanes; ++k)
          P[at(i, j)][k] += weight * (h.P[at(i, j)][k] + (h.x[i][k] - x[i][k]) * (h.x[j][k] - x[j][k]));
  }
};

template <int kMech>
constexpr ObserverSteps<kMech> kSteps{Steps<kMech>::predict, Steps<kMech>::correct, Steps<kMech>::gather};
