// The wall as a position-control problem ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects"):
// once the tool touches, a servo holds it there, and the contact force is what the servo needs.
#pragma once

#include <array>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Gain of a servo, (K_c | K_i), n x 3n for n joints: [N m s/rad, N m/rad, N m/(rad s)]. Stored in place.
using ServoGain = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, 3 * kMaxJoints>;

/// Parameters of the renderer `hold`.
struct HoldOptions {
  /// Ends the hold when the wall would pull, with the integrators emptied; the next touch takes as its reference the
  /// first penetrating pose moved back to the surface (to first order in the depth). Off: as in the paper, the hold
  /// never ends and the reference is the joint pose at first touch. A deeper touch than kMaxReferenceStep is moved back
  /// by that at once and then at kReferenceSpeed.
  bool release = true;
  double releaseForce = 0.3;  ///< pull along the contact's normal beyond which the hold ends, N
  bool antiWindup = false;    ///< stops the integrators while a motor is saturated; off in the paper
  /// Gain on the servo's torques of the last d <= kMaxHoldDelay ticks, the latest first, n x dn, beside a gain that
  /// foresees their effect: both of servoForDelay(). Empty: none.
  Eigen::MatrixXd commandGain;
};

/// Largest delay that a hold can foresee, ticks.
inline constexpr int kMaxHoldDelay = 4;

/// u = g - (K_c | K_i) [q'; q - q_ref; xi], then xi += Ts (q_ref - q), u cut at +-maxTorque (eq. 11 with the reference
/// held); g is the gravity torque at first touch. With a command gain u has -K_d [u - g of the last ticks] too. Without
/// contact u = g(q). A tool touches when a gap is at most kTouchGap and, where the hold was released inside the wall,
/// when it also moves inwards. The reference moves with the obstacle that was touched. Every motor's torque is cut for
/// itself, as in the paper. On any mechanism with the gain's number of joints.
class HoldRenderer final : public Renderer {
 public:
  /// A gap at which the tool touches, m: above rounding, below anything that can be felt.
  static constexpr double kTouchGap = 1e-9;

  /// How far a reference moves back to the surface at once, m, and how fast it goes the rest of the way, m/s.
  static constexpr double kMaxReferenceStep = 1e-3, kReferenceSpeed = 0.02;

  /// `gain` was designed for ticks of `period` s. Throws Error: a gain that is not n x 3n or not finite; a command gain
  /// that is neither empty nor n x dn and finite; a release force that is negative or not finite; at activate(), a
  /// period other than `period`.
  HoldRenderer(const ServoGain& gain, double period, const HoldOptions& options);

  /// Whether the servo holds, and at which joint coordinates q_ref, rad or m. Realtime: yes.
  bool holding() const noexcept { return state_.phase == kHolding; }
  JointVector reference() const noexcept { return state_.reference.head(joints_); }

 private:
  using Stored = Eigen::Matrix<double, kMaxJoints, 1>;  // zero beyond n
  struct State {
    Stored reference = Stored::Zero();                          // q_ref
    Stored feedForward = Stored::Zero();                        // g
    Stored integral = Stored::Zero();                           // xi
    std::array<double, kMaxHoldDelay * kMaxJoints> commands{};  // u - g, the latest first
    Vec3 normal = Vec3::Zero();                                 // of the contact that is held, W
    double phase = 0.0;      // one of the three below; a double, so that the block has no padding
    double left = 0.0;       // that the reference has still to go back along the normal, m
    double obstacle = -1.0;  // that is held
  };
  static_assert(sizeof(State) == ((3 + kMaxHoldDelay) * kMaxJoints + 6) * sizeof(double),
                "the state is compared byte by byte");
  static constexpr double kFree = 0.0;      // no contact
  static constexpr double kHolding = 1.0;   // the servo holds
  static constexpr double kReleased = 2.0;  // released inside the wall, and not yet out of it

  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  void updatePhase(const TickFrame& frame) noexcept;
  void hold(const TickFrame& frame) noexcept;
  void moveReference(const TickFrame& frame) noexcept;

  static constexpr int kRows = kMaxJoints + 1;         // even: columns of whole SIMD registers
  Eigen::Matrix<double, kRows, 3 * kMaxJoints> gain_;  // zero beyond n x 3n
  Eigen::Matrix<double, kRows, kMaxHoldDelay * kMaxJoints> commandGain_;
  Eigen::Index joints_;
  double period_;
  HoldOptions options_;
  State state_;
};

}  // namespace enamel
