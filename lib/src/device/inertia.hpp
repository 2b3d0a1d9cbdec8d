// Mass matrices. Eigen's decompositions compile for 2 s a file: small factors in plain loops, eigenvalues compiled
// once.
#pragma once

#include "enamel/core/cholesky.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// False where the mass matrix is not positive definite. Realtime: yes.
inline bool factorInertia(const JointMatrix& inertia, Cholesky<kMaxJoints>& factor) noexcept {
  double A[kMaxJoints][kMaxJoints];
  const int n = static_cast<int>(inertia.rows());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) A[i][j] = inertia(i, j);
  return factor.factor(A, n);
}

/// Of a symmetric matrix, ascending.
Vec3 eigenvaluesOf(const Mat3& matrix) noexcept;

}  // namespace enamel
