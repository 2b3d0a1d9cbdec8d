// Virtual coupling: a virtual tool touches the wall, and a spring and a damper connect the device to it.
#pragma once

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of a virtual coupling.
struct VirtualCouplingOptions {
  double stiffness = 3000.0;  ///< K of the coupling, N/m
  double damping = 2.0;       ///< B of the coupling, N s/m
  double mass = 0.02;         ///< m of the virtual tool, kg
};

/// Connect the device to a virtual tool by a spring and a damper (J. E. Colgate, M. C. Stanley, J. M. Brown 1995,
/// "Issues in the haptic display of tool use"). Only the virtual tool touches the obstacles. Its contacts may be
/// arbitrarily stiff, because the device feels at most K and B. The virtual tool is the device's tool, displaced by e
/// in W. Each tick solves one implicit step:
///
///   m (v+ - v) / T = -K e+ - B (v+ - v_device) + sum_k n_k f_k
///   f_k >= 0,   g_k + n_k . e+ + f_k / k_material >= 0,   one of the two is zero
///
/// The device receives the force K e+ + B (v+ - v_device) at the TCP, and the moments of the contacts. The coupling
/// renders no friction. At most the six deepest contacts count. A moving obstacle acts by its position, not by its
/// velocity. The wall is passive if the damping of the device exceeds requiredDamping() of K and B, for any obstacles.
/// The limits of that bound (impedance.hpp) apply.
class VirtualCouplingRenderer final : public Renderer {
 public:
  /// Throws Error if the stiffness or the mass is not positive and finite, or the damping is negative or not finite.
  explicit VirtualCouplingRenderer(const VirtualCouplingOptions& options);

 private:
  void prepare(double period) override { period_ = period; }
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  struct State {
    std::array<double, 3> position{}, velocity{};  // of the virtual tool's centre point, W
    double started = 0.0;
  };

  VirtualCouplingOptions options_;
  double period_ = 0.0;
  State state_;
};

}  // namespace enamel
