#include "render/contact_projection.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

constexpr int kMostRows = 10;  // independent rows; no device has more joints

// Cholesky factors of the passive rows of G, in the order of insertion.
struct Passive {
  int count = 0;
  int row[kMostRows];
  double L[kMostRows][kMostRows];

  // Returns false if row k depends on the other rows.
  bool add(const double (&G)[kMaxWalls][kMaxWalls], int k) noexcept {
    if (count == kMostRows) return false;
    double left = G[k][k];
    for (int i = 0; i < count; ++i) {
      double v = G[k][row[i]];
      for (int j = 0; j < i; ++j) v -= L[count][j] * L[i][j];
      L[count][i] = v / L[i][i];
      left -= L[count][i] * L[count][i];
    }
    if (!(left > 1e-9 * G[k][k])) return false;
    L[count][count] = std::sqrt(left);
    row[count++] = k;
    return true;
  }
  void solve(const double* h, double* z) const noexcept {
    for (int i = 0; i < count; ++i) {
      z[i] = h[row[i]];
      for (int j = 0; j < i; ++j) z[i] -= L[i][j] * z[j];
      z[i] /= L[i][i];
    }
    for (int i = count - 1; i >= 0; --i) {
      for (int j = i + 1; j < count; ++j) z[i] -= L[j][i] * z[j];
      z[i] /= L[i][i];
    }
  }
};

}  // namespace

bool solveNonNegative(const double (&G)[kMaxWalls][kMaxWalls], const double* h, int n, double* l) noexcept {
  std::fill_n(l, n, 0.0);
  bool isPassive[kMaxWalls] = {}, barred[kMaxWalls] = {};
  Passive passive;
  for (int step = 0; step < 3 * kMaxWalls; ++step) {
    int best = -1;
    double steepest = 0.0;
    for (int k = 0; k < n; ++k) {
      if (isPassive[k] || barred[k] || !(G[k][k] > 0.0)) continue;
      double slope = h[k];
      for (int i = 0; i < passive.count; ++i) slope -= G[k][passive.row[i]] * l[passive.row[i]];
      const double size = std::sqrt(G[k][k]);
      if (slope > 1e-12 * std::abs(h[k]) && slope / size > steepest) {
        steepest = slope / size;
        best = k;
      }
    }
    if (best < 0) return true;
    double z[kMostRows];
    if (!passive.add(G, best)) {
      barred[best] = true;
      continue;
    }
    passive.solve(h, z);
    if (!(z[passive.count - 1] > 0.0)) {  // rounding error
      --passive.count;
      barred[best] = true;
      continue;
    }
    isPassive[best] = true;
    for (int inner = 0; inner < kMostRows; ++inner) {
      double way = 1.0;
      for (int i = 0; i < passive.count; ++i)
        if (!(z[i] > 0.0)) way = std::min(way, l[passive.row[i]] / (l[passive.row[i]] - z[i]));
      for (int i = 0; i < passive.count; ++i) l[passive.row[i]] += way * (z[i] - l[passive.row[i]]);
      if (way == 1.0) break;
      const Passive before = passive;
      passive.count = 0;
      for (int i = 0; i < before.count; ++i) {
        const int k = before.row[i];
        if (z[i] > 0.0 || l[k] > 1e-15 * std::abs(z[i])) {
          if (passive.add(G, k)) continue;
        }
        l[k] = 0.0;
        isPassive[k] = false;
      }
      passive.solve(h, z);
    }
    std::fill_n(barred, n, false);
  }
  return false;
}

}  // namespace enamel
