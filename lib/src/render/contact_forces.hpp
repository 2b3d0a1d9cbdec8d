// Contact forces under unilateral contacts and motor limits: a small convex quadratic program.
#pragma once

#include "enamel/core/types.hpp"

namespace enamel {

/// Largest number of contacts that carry force at once. The deepest are used.
inline constexpr int kMaxActiveContacts = 6;

/// Minimise 1/2 x^T G x - r^T x over the forces x, N: 0 <= x_k <= most and low_i <= (motor_i)^T x <= high_i.
struct ContactProblem {
  int contacts = 0;
  double most = 1e3;                                 ///< largest force of a contact, N
  double G[kMaxActiveContacts][kMaxActiveContacts];  ///< symmetric, positive definite
  double r[kMaxActiveContacts];
  int motors = 0;
  double motor[kMaxJoints][kMaxActiveContacts];  ///< torque of a motor per unit of each force
  double low[kMaxJoints], high[kMaxJoints];      ///< low <= 0 <= high
};

/// A solution and how it was found.
struct ContactSolution {
  double force[kMaxActiveContacts] = {};
  bool limited = false;  ///< a motor limit is active
  bool exact = true;     ///< false: out of iterations; the forces still keep all bounds
};

/// Solve with the dual active-set method (Goldfarb and Idnani 1983) in at most 60 steps. A single contact has a closed
/// form. Realtime: yes.
ContactSolution solveContacts(const ContactProblem& problem) noexcept;

}  // namespace enamel
