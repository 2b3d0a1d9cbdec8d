// The conventional wall: a spring and a damper along the contact's normal.
#pragma once

#include "enamel/device/tau/model.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of the impedance wall.
struct ImpedanceOptions {
  double stiffness = 6000.0;   ///< K_r, N/m on the penetration depth
  double damping = 0.0;        ///< B_r, N s/m on the approach speed
  double deviceDamping = 0.0;  ///< b_m, known mechanical damping of the device along the normal, N s/m
};

/// The stability guideline b_m > K_r Ts / 2 + |B_r| ("A Position-Control Based Approach ...", eq. 16, after Colgate).
struct DampingBound {
  double required;   ///< K_r Ts / 2 + |B_r|, N s/m
  double available;  ///< b_m, N s/m
  bool met;          ///< available > required
};

/// The bound for a wall rendered every `period` s. Realtime: yes.
DampingBound dampingBound(const ImpedanceOptions& options, double period) noexcept;

/// tau = g(q) + J^T sum_k f_k [n_k; (p_k - p) x n_k], f_k = max(0, K_r depth_k + B_r approach speed_k) for every
/// contact with a negative gap: the wall pushes and never pulls. A requested pair that breaks eq. 16 is rendered all
/// the same: ask dampingBound() and warn.
class ImpedanceRenderer final : public Renderer {
 public:
  /// Throws Error: a stiffness, damping or device damping that is negative or not finite.
  ImpedanceRenderer(const TauModel& model, const ImpedanceOptions& options);

 private:
  void prepare(double) override {}
  Status render(const TickInput& input, TickOutput& output) noexcept override;
  void resetState() noexcept override {}
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  TauModel model_;
  ImpedanceOptions options_;
};

}  // namespace enamel
