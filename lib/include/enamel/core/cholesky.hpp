// Cholesky factorisation of small positive definite matrices in plain loops. The order of the sums does not depend on
// vectorisation by the compiler or on the address of a matrix.
#pragma once

#include <cmath>

namespace enamel {

/// The factor L of A = L L^T for an n x n matrix, n <= N.
template <int N>
class Cholesky {
 public:
  /// Factor A and return true, or false if A is not positive definite. Reads the lower triangle. Realtime: yes.
  bool factor(const double (&A)[N][N], int n) noexcept {
    n_ = n;
    for (int j = 0; j < n; ++j) {
      double d = A[j][j];
      for (int k = 0; k < j; ++k) d -= L_[j][k] * L_[j][k];
      if (!(d > 0.0)) return false;
      const double root = std::sqrt(d);
      inverse_[j] = 1.0 / root;
      for (int i = j + 1; i < n; ++i) {
        double s = A[i][j];
        for (int k = 0; k < j; ++k) s -= L_[i][k] * L_[j][k];
        L_[i][j] = s * inverse_[j];
      }
    }
    return true;
  }

  /// Replace x by A^-1 x. Realtime: yes.
  void solve(double* x) const noexcept {
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= L_[i][k] * x[k];
      x[i] *= inverse_[i];
    }
    for (int i = n_ - 1; i >= 0; --i) {
      for (int k = i + 1; k < n_; ++k) x[i] -= L_[k][i] * x[k];
      x[i] *= inverse_[i];
    }
  }

 private:
  double L_[N][N] = {};     // the part below the diagonal
  double inverse_[N] = {};  // inverse of the diagonal
  int n_ = 0;
};

}  // namespace enamel
