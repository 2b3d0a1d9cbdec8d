// The paper's wall ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects"). A servo holds the tool
// from the first touch on. The contact force is the force of the servo.
#pragma once

#include <array>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Gain of a servo, (K_c | K_i), n x 3n for n joints: [N m s/rad, N m/rad, N m/(rad s)]. Stored in place.
using ServoGain = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, 3 * kMaxJoints>;

/// Parameters of the renderer `hold`.
struct HoldOptions {
  /// On: the hold ends when the wall would pull, and the integrators are cleared. The next touch sets the reference to
  /// the first penetrating pose, moved back to the surface (to first order in the depth). A touch deeper than
  /// kMaxReferenceStep moves back by that step at once, and then at kReferenceSpeed. Off, as in the paper: the hold
  /// never ends, and the reference is the joint pose at first touch.
  bool release = true;
  double releaseForce = 0.3;  ///< pull along the contact normal above which the hold ends, N
  bool antiWindup = false;    ///< stop the integrators while a motor is saturated; off in the paper
  /// Gain on the servo torques of the last d <= kMaxHoldDelay ticks, newest first, n x dn. It belongs to a gain that
  /// predicts their effect: both come from servoForDelay(). Empty: unused.
  Eigen::MatrixXd commandGain;
};

/// Largest delay that a hold can compensate, ticks.
inline constexpr int kMaxHoldDelay = 4;

/// Hold the joints at a reference by a servo with integral action (eq. 11 with the reference held):
///
///   u = g - (K_c | K_i) [q'; q - q_ref; xi],   xi += Ts (q_ref - q)
///
/// u is limited to +-maxTorque. g is the gravity torque at first touch. With a command gain, u also has the term -K_d
/// [u - g of the last ticks]. Without contact u = g(q).
///
/// A tool touches when a gap is at most kTouchGap. After a release inside the wall it must also move inwards. The
/// reference moves with the touched obstacle. Each motor's torque is limited separately, as in the paper. The mechanism
/// must have as many joints as the gain.
class HoldRenderer final : public Renderer {
 public:
  /// Gap at which the tool touches, m: above rounding errors, below what a person can feel.
  static constexpr double kTouchGap = 1e-9;

  /// Distance that a reference moves back to the surface at once, m, and its speed for the rest, m/s.
  static constexpr double kMaxReferenceStep = 1e-3, kReferenceSpeed = 0.02;

  /// `gain` was designed for ticks of `period` s. Throws Error in these cases:
  ///
  /// - the gain is not n x 3n or not finite;
  /// - the command gain is not empty and not n x dn, or not finite;
  /// - the release force is negative or not finite;
  /// - at activate(): the period differs from `period`.
  HoldRenderer(const ServoGain& gain, double period, const HoldOptions& options);

  /// Return whether the servo holds. reference() returns the joint coordinates q_ref, rad or m. Realtime: yes.
  bool holding() const noexcept { return state_.phase == kHolding; }
  JointVector reference() const noexcept { return state_.reference.head(joints_); }

 private:
  using Stored = Eigen::Matrix<double, kMaxJoints, 1>;  // zero after the first n entries
  struct State {
    Stored reference = Stored::Zero();                          // q_ref
    Stored feedForward = Stored::Zero();                        // g
    Stored integral = Stored::Zero();                           // xi
    std::array<double, kMaxHoldDelay * kMaxJoints> commands{};  // u - g, newest first
    Vec3 normal = Vec3::Zero();                                 // of the held contact, W
    double phase = 0.0;      // one of the three below; a double, so that the block has no padding
    double left = 0.0;       // distance that the reference must still move along the normal, m
    double obstacle = -1.0;  // the held obstacle
  };
  static_assert(sizeof(State) == ((3 + kMaxHoldDelay) * kMaxJoints + 6) * sizeof(double),
                "the state is compared byte by byte");
  static constexpr double kFree = 0.0;      // no contact
  static constexpr double kHolding = 1.0;   // the servo holds
  static constexpr double kReleased = 2.0;  // released inside the wall, not yet outside

  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  void updatePhase(const TickFrame& frame) noexcept;
  void hold(const TickFrame& frame) noexcept;
  void moveReference(const TickFrame& frame) noexcept;

  static constexpr int kRows = kMaxJoints + 1;         // even: columns of whole SIMD registers
  Eigen::Matrix<double, kRows, 3 * kMaxJoints> gain_;  // zero outside n x 3n
  Eigen::Matrix<double, kRows, kMaxHoldDelay * kMaxJoints> commandGain_;
  Eigen::Index joints_;
  double period_;
  HoldOptions options_;
  State state_;
};

}  // namespace enamel
