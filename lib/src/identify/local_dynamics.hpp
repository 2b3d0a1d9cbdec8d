// The dynamics of a mechanism near a place. Private to identify.
//
// The equations of motion near a place q0 with rates v0 are
//
//   M q'' = torque - b,  M = M0 + sum_k dM/dq_k d_k,  b = b0 + dg/dq d + C(q') - C(v0),  d = q - q0,
//   C_i(v) = sum_jk (dM_ij/dq_k - 1/2 dM_jk/dq_i) v_j v_k  (Lagrange),
//
// with the torque b0 that balances gravity and velocities at the place.
#pragma once

#include <vector>

#include "enamel/device/mechanism.hpp"

namespace enamel::identify {

/// M, b and their derivatives at a place.
struct LocalDynamics {
  JointVector place, rates;  ///< q0 and v0
  JointVector balance;       ///< b0, N m or N
  JointMatrix mobility;      ///< M^-1
};

/// Derivatives of M and g: dM/dq_k for each joint, and dg/dq.
struct DynamicsSlopes {
  std::vector<Eigen::MatrixXd> inertia;
  Eigen::MatrixXd gravity;
};

/// Compute the dynamics at a place. `kinematics` is a state near it, and becomes that of the place.
Status dynamicsAt(const Mechanism& mechanism, const JointVector& place, const JointVector& rates,
                  Kinematics& kinematics, LocalDynamics& dynamics);

/// Compute the derivatives at a place, by differences. They are zero along joints that cannot move.
DynamicsSlopes slopesAt(const Mechanism& mechanism, const Kinematics& here);

}  // namespace enamel::identify
