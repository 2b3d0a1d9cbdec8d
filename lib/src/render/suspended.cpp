#include "enamel/render/suspended.hpp"

#include <algorithm>

namespace enamel {

Vec6 inverseInertia(const Suspension& s, double period) noexcept {
  const Vec6 whole = s.inertia + period * s.damping + period * period * s.stiffness;
  return (s.inertia.array() > 0.0).select(whole.cwiseInverse(), 0.0);
}

Vec6 freeVelocity(const Suspension& s, const SuspendedState& state, double period) noexcept {
  const Vec6 momentum = s.inertia.cwiseProduct(state.velocity) + std::min(1.0, period / kImpulseTime) * state.impulse -
                        period * s.stiffness.cwiseProduct(state.offset);
  return inverseInertia(s, period).cwiseProduct(momentum);
}

void advance(const Suspension& s, double elapsed, SuspendedState& state) noexcept {
  state.velocity = freeVelocity(s, state, elapsed) + elapsed * inverseInertia(s, elapsed).cwiseProduct(state.wrench);
  state.impulse *= 1.0 - std::min(1.0, elapsed / kImpulseTime);
  state.offset.head<3>() += elapsed * state.velocity.head<3>();
  state.offset.tail<3>() = rotationVector(rotationFromVector(elapsed * state.velocity.tail<3>()) *
                                          rotationFromVector(state.offset.tail<3>()));
}

}  // namespace enamel
