// The wall as a position-control problem ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects"):
// once the tool touches, a servo holds it there, and the contact force is what the servo needs.
#pragma once

#include <Eigen/Core>

#include "enamel/device/tau/model.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Parameters of the position-control renderer, mode `hold`.
struct PositionControlOptions {
  /// Ends the hold when the wall would pull, with the integrators emptied; the next touch takes as its reference the
  /// first penetrating pose projected back to the surface. Off: as in the paper, the hold never ends and the reference
  /// is the joint pose at first touch.
  bool release = true;
  double releaseForce = 0.3;  ///< pull along the contact's normal beyond which the hold ends, N
  bool antiWindup = false;    ///< stops the integrators while a motor is saturated; off in the paper
};

/// u = g(q_ref) - (K_c | K_i) [q'; q - q_ref; xi], then xi += Ts (q_ref - q), u cut at +-maxTorque (eq. 11 with the
/// reference held). Without contact u = g(q). A tool touches when a gap is at most kTouchGap and, where the hold was
/// released inside the wall, when it also moves inwards.
class PositionControlRenderer final : public Renderer {
 public:
  using Gain = Eigen::Matrix<double, 6, 18>;

  /// A gap at which the tool touches, m: above rounding, below anything that can be felt.
  static constexpr double kTouchGap = 1e-9;

  /// `gain` is (K_c | K_i), [N m s/rad, N m/rad, N m/(rad s)], designed for ticks of `period` s.
  /// Throws Error: a gain that is not finite; a release force that is negative or not finite; at activate(), a period
  /// other than `period`.
  PositionControlRenderer(const TauModel& model, const Gain& gain, double period,
                          const PositionControlOptions& options);

  /// Whether the servo holds, and at which joint angles q_ref, rad. Realtime: yes.
  bool holding() const noexcept { return state_.phase == kHolding; }
  const Vec6& reference() const noexcept { return state_.reference; }

 private:
  struct State {
    Vec6 reference = Vec6::Zero();    // q_ref, rad
    Vec6 feedForward = Vec6::Zero();  // g(q_ref), N m
    Vec6 integral = Vec6::Zero();     // xi, rad s
    Vec3 normal = Vec3::Zero();       // of the contact that is held, W
    double phase = 0.0;               // one of the three below; a double, so that the block has no padding
  };
  static_assert(sizeof(State) == 22 * sizeof(double), "the state is compared byte by byte");
  static constexpr double kFree = 0.0;      // no contact
  static constexpr double kHolding = 1.0;   // the servo holds
  static constexpr double kReleased = 2.0;  // released inside the wall, and not yet out of it

  void prepare(double period) override;
  Status render(const TickInput& input, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }

  bool touches(const TickInput& input) noexcept;
  Status hold(const TickInput& input, const TauConfiguration& configuration) noexcept;

  TauModel model_;
  Gain gain_;
  double period_;
  PositionControlOptions options_;
  State state_;
};

}  // namespace enamel
