// The conventional wall: a spring and a damper along the contact normal.
#pragma once

#include "enamel/render/friction.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of the impedance wall.
struct ImpedanceOptions {
  double stiffness = 6000.0;  ///< K_r on the penetration depth, N/m
  double damping = 0.0;       ///< B_r on the approach speed, N s/m
};

/// Return the mechanical damping along the normal above which the wall is passive, N s/m:
///
///   b > K_r Ts / 2 + |B_r|
///
/// Source: Colgate and Brown 1994; "A Position-Control Based Approach ...", eq. 16. `period` is Ts, s. Realtime: yes.
///
/// The bound assumes exact positions and torques without delay. Under these assumptions a device with more damping has
/// a stable wall. The bound is not a stability guarantee on a real device:
///
/// - It ignores quantisation by encoders, which can cause limit cycles even above the bound. Conditions with
///   quantisation and Coulomb friction: Diolaiti, Niemeyer, Barbagli and Salisbury 2006.
/// - It ignores delay, which raises the required damping. Boundaries with delay: Hulin, Albu-Schäffer and Hirzinger
///   2014.
///
/// Enamel implements neither of these conditions. Its simulations include both effects: evaluateWall()
/// (study/wall_design.hpp) and runWallTrials() (study/wall_trials.hpp) round encoders and delay commands. They test a
/// spring and prove nothing.
double requiredDamping(const ImpedanceOptions& options, double period) noexcept;

/// Render each contact with a negative gap as a spring and a damper, on any mechanism:
///
///   tau = g(q) + J^T sum_k [f_k n_k + t_k; (p_k - p) x (f_k n_k + t_k)]
///   f_k = max(0, K depth_k + B_r approach speed_k)
///
/// The wall pushes and never pulls. K is K_r in series with the obstacle's stiffness. t_k is the friction of
/// FrictionMemory; it sticks with K_r and B_r. The renderer does not compare requiredDamping() with the damping of the
/// device. Compare them before use and warn the user.
class ImpedanceRenderer final : public Renderer {
 public:
  /// Throws Error if stiffness or damping is negative or not finite.
  explicit ImpedanceRenderer(const ImpedanceOptions& options);

 private:
  void prepare(double period) override { period_ = period; }
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  struct State {
    std::array<double, kMaxJoints> q{};  // at the last sample
    double sampleTime = 0.0, started = 0.0;
    FrictionMemory friction;
  };

  ImpedanceOptions options_;
  double period_ = 0.0;
  State state_;
};

}  // namespace enamel
