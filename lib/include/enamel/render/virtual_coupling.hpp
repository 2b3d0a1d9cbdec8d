// The virtual coupling: a tool of the program's own touches the wall, and a spring and a damper tie the device to it.
#pragma once

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of a virtual coupling.
struct VirtualCouplingOptions {
  double stiffness = 3000.0;  ///< K of the coupling, N/m
  double damping = 2.0;       ///< B of the coupling, N s/m
  double mass = 0.02;         ///< m of the virtual tool, kg
};

/// J. E. Colgate, M. C. Stanley, J. M. Brown 1995, "Issues in the haptic display of tool use": the device is tied to a
/// virtual tool, and only that touches what is simulated, by constraints as stiff as one likes: what the device feels
/// is K and B at most. The virtual tool is the device's tool moved by an offset e, W. From tick to tick, implicitly:
///   m (v+ - v) / T = -K e+ - B (v+ - v_device) + sum_k n_k f_k,   f_k >= 0, g_k + n_k . e+ + f_k / k_material >= 0,
/// one of the two zero, and the device gets K e+ + B (v+ - v_device) at the TCP with the contacts' moments. No
/// friction; at most the six deepest contacts; obstacles that move push by where they are. Device damping beyond
/// requiredDamping() of K and B makes it passive, whatever the obstacles.
class VirtualCouplingRenderer final : public Renderer {
 public:
  /// Throws Error: a stiffness or mass that is not positive or not finite; a damping that is negative or not finite.
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
