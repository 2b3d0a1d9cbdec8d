// Mass matrices: small factors in plain loops, and eigenvalues compiled once. Eigen's decompositions would cost 2 s of
// compile time per file.
#pragma once

#include "enamel/core/cholesky.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Factor the mass matrix. Returns false if it is not positive definite. Realtime: yes.
inline bool factorInertia(const JointMatrix& inertia, Cholesky<kMaxJoints>& factor) noexcept {
  double A[kMaxJoints][kMaxJoints];
  const int n = static_cast<int>(inertia.rows());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) A[i][j] = inertia(i, j);
  return factor.factor(A, n);
}

/// Return J M^-1 J^T, the acceleration of the platform at the TCP by each unit wrench. `kinematics` must contain the
/// inertia of a mechanism. Realtime: yes.
Mat6 inverseInertiaOf(const Kinematics& kinematics) noexcept;

/// Return the eigenvalues of a symmetric matrix in ascending order.
Vec3 eigenvaluesOf(const Mat3& matrix) noexcept;

/// Do the same, and set the columns of `axes` to the eigenvectors. Reads the lower triangle.
JointVector eigenvaluesOf(const JointMatrix& matrix, JointMatrix& axes) noexcept;

}  // namespace enamel
