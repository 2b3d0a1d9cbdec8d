// Contact forces under unilateral contacts and motor limits: a small convex quadratic program.
#pragma once

#include "enamel/core/types.hpp"

namespace enamel {

/// Most contacts that carry force at once (the deepest).
inline constexpr int kMaxActiveContacts = 6;

/// min 1/2 x^T G x - r^T x over the forces x, N, subject to 0 <= x_k <= most and low_i <= (motor_i)^T x <= high_i.
struct ContactProblem {
  int contacts = 0;
  double most = 1e3;                                 ///< largest force of a contact, N
  double G[kMaxActiveContacts][kMaxActiveContacts];  ///< symmetric, positive definite
  double r[kMaxActiveContacts];
  int motors = 0;
  double motor[kMaxJoints][kMaxActiveContacts];  ///< torque of a motor for a unit of each force
  double low[kMaxJoints], high[kMaxJoints];      ///< low <= 0 <= high
};

/// How a solution was found.
struct ContactSolution {
  double force[kMaxActiveContacts] = {};
  bool limited = false;  ///< a motor's limit is active
  bool exact = true;     ///< false: out of iterations; the forces keep to all bounds all the same
};

/// The dual active-set method (Goldfarb and Idnani 1983), at most 60 steps; one contact in closed form. Realtime: yes.
ContactSolution solveContacts(const ContactProblem& problem) noexcept;

}  // namespace enamel
