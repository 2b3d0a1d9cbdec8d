// The conventional wall: a spring and a damper along the contact's normal.
#pragma once

#include "enamel/render/friction.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of the impedance wall.
struct ImpedanceOptions {
  double stiffness = 6000.0;  ///< K_r, N/m on the penetration depth
  double damping = 0.0;       ///< B_r, N s/m on the approach speed
};

/// Mechanical damping along the normal that a device must have for the wall to be passive, N s/m: K_r Ts / 2 + |B_r|
/// ("A Position-Control Based Approach ...", eq. 16; Colgate and Brown 1994); a device with more has a stable wall.
/// `period` in s. Says nothing about delay. Realtime: yes.
double requiredDamping(const ImpedanceOptions& options, double period) noexcept;

/// tau = g(q) + J^T sum_k [f_k n_k + t_k; (p_k - p) x (f_k n_k + t_k)], f_k = max(0, K depth_k + B_r approach speed_k)
/// for every contact with a negative gap: the wall pushes and never pulls. K is K_r in series with the obstacle's
/// stiffness; t_k is the friction of FrictionMemory, stuck with K_r and B_r. On any mechanism. A wall that asks for
/// more damping than the device has is rendered all the same: compare requiredDamping() and warn.
class ImpedanceRenderer final : public Renderer {
 public:
  /// Throws Error: a stiffness or damping that is negative or not finite.
  explicit ImpedanceRenderer(const ImpedanceOptions& options);

 private:
  void prepare(double period) override { period_ = period; }
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  struct State {
    std::array<double, kMaxJoints> q{};  // of the last sample
    double sampleTime = 0.0, started = 0.0;
    FrictionMemory friction;
  };

  ImpedanceOptions options_;
  double period_ = 0.0;
  State state_;
};

}  // namespace enamel
