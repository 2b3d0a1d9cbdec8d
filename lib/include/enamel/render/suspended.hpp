// The motion of an obstacle in its suspension (Suspension): M v' = w - B v - K x, along and about six axes.
//
// A step of T s is implicit Euler: v+ = (M v + T (w - K x)) / (M + T B + T^2 K), x+ = x + T v+. Without springs and
// dampers it keeps the momentum. It never adds energy, whatever the stiffness, so a suspension may be far faster than
// the ticks.
#pragma once

#include "enamel/collision/scene.hpp"

namespace enamel {

/// State of a suspended obstacle, in the axes of its frame at rest. Plain numbers.
struct SuspendedState {
  Vec6 offset = Vec6::Zero();    ///< of the centre from its place at rest, m, and rotation vector, rad
  Vec6 velocity = Vec6::Zero();  ///< m/s and rad/s
  Vec6 wrench = Vec6::Zero();    ///< of the contacts at the centre, N and N m
  Vec6 impulse = Vec6::Zero();   ///< from the tools of other devices, not given yet, N s and N m s
};

/// An impulse of another device's tool acts with this decay time, s. The loops of two devices know each other's forces
/// a tick late. If they acted at once, two tools on a light tooth would throw each other off.
inline constexpr double kImpulseTime = 0.02;

/// Return the inverse of the inertia over a step of `period` s: 1 / (M + T B + T^2 K), and 0 where M is 0. Realtime:
/// yes.
Vec6 inverseInertia(const Suspension& suspension, double period) noexcept;

/// Return the velocity after a step of `period` s without a contact force of this tool. Realtime: yes.
Vec6 freeVelocity(const Suspension& suspension, const SuspendedState& state, double period) noexcept;

/// Advance by a step of `elapsed` s under the wrench of the contacts and the impulse. Realtime: yes.
void advance(const Suspension& suspension, double elapsed, SuspendedState& state) noexcept;

}  // namespace enamel
