// Position control of a tool at a wall. The wall pushes and never pulls, and the tool can slide. Encoder counts, delay
// and transmission limit its stiffness. Explanation with equations: lib/docs/position-control.md.
//
//   measured joints -> observer of modes and push -> where the hand would take the tool
//                   -> nearest place in the free space -> force towards it
//
// Modes: the eigenvectors of the links' inertia decouple the device into independent one-axis systems (mode_table.hpp).
//
// Observer: each mode has a Kalman filter. Its noise follows from the device's data. Further hypotheses cover the time
// of the push's last jump. ln(mass) is one more state (push_observer.hpp). After a lost sample the filter only
// predicts.
//
// Controller: each mode has a linear-quadratic design for its inertia, torque = K (target - w). Here w is where the
// hand would take the mode. The target is the point nearest to w, in the metric K, that violates no contact. The torque
// is then a sum of contact normals with non-negative factors, for one contact or many (contact_projection.hpp).
//
// Cap: it limits the outward speed that a force may cause. The push must turn the tool back within the depth that no
// controller can avoid.
#pragma once

#include <memory>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Largest delay of PositionControlOptions, ticks.
inline constexpr int kMaxLoopDelay = 8;

/// Data of a device for position control. The renderer computes all other numbers.
struct PositionControlOptions {
  double period = 1e-3;             ///< of the ticks, s
  JointVector encoderStep;          ///< step of each joint's encoder, rad or m; one per joint of the device
  JointVector effort;               ///< largest torque or force of each joint, N m or N; 0: no motor
  int delayLow = 0, delayHigh = 0;  ///< stated delay of a command, ticks: constant if equal, else random in between
  Drive drive;                      ///< transmission between command and joint
  double scale = 1.0;               ///< Mechanism::scale()
};

/// Return options for a device. Realtime: yes.
PositionControlOptions positionControlFor(const Mechanism& mechanism, double period, int delayLow, int delayHigh);

/// Check options. Throws Error in these cases:
///
/// - the number of encoder steps is outside 1 to kMaxJoints, or a step is not positive and finite;
/// - the number of efforts differs from it, or one is negative;
/// - a delay is outside 0 to kMaxLoopDelay, or delayLow is above delayHigh;
/// - the period is outside 1e-5 to 0.1 s, or the scale is not positive and finite;
/// - a number of the drive is negative or not finite, or a cable has no rotor.
///
/// Realtime: no.
void checkPositionControl(const PositionControlOptions& options);

/// Estimates and counters of position control.
struct PositionControlState {
  double mass = 1.0;            ///< estimated mass of the links over the model's
  double deviation = 0.0;       ///< standard deviation of ln(mass)
  double cable = 1.0;           ///< estimated stiffness of the cables over the model's; 1 without cables
  double cableDeviation = 0.0;  ///< standard deviation of ln(cable)
  double push = 0.0;            ///< estimated push of the hand against the loaded contacts, N; 0: no push
  double ignored = 0.0;         ///< samples ignored since reset() because no push explains them
  double merged = 0.0;          ///< redundant contacts of the last tick: others already hold the tool
  /// Likeliest delay of a command, ticks: learnt from contact, at first as in the options. Random in between if they
  /// differ.
  int delayLow = 0, delayHigh = 0;
};

/// The renderer of position control. The mechanism must have as many joints as there are encoder steps.
class PositionControlRenderer final : public Renderer {
 public:
  /// Throws Error as checkPositionControl(), and activate() if its period differs from `period`.
  explicit PositionControlRenderer(const PositionControlOptions& options);
  ~PositionControlRenderer() override;

  bool needsInertia() const noexcept override { return true; }
  Delay delay() const noexcept override;

  /// Return the estimates of the last tick. Realtime: yes.
  PositionControlState state() const noexcept;

 private:
  class Controller;
  template <int>
  class ControllerOf;
  friend struct ControlledModes modesOf(const PositionControlRenderer& renderer) noexcept;  // for study/stability.cpp

  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override;
  StateBlock stateBlock() noexcept override;
  void stateLoaded() noexcept override;

  double period_;
  std::unique_ptr<Controller> controller_;
};

}  // namespace enamel
