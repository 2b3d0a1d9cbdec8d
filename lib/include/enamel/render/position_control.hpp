// Position control of a tool at a wall: it pushes and never pulls, lets the tool slide, and is as stiff as counts,
// delay and transmission allow. The whole story, with its equations: lib/docs/position-control.md.
//
//   measured joints -> observer of modes and push -> where the hand would take the tool
//                   -> nearest place in the free space -> force towards it
//
// Modes. The eigenvectors of the links' inertia turn the device into independent one-axis systems (mode_table.hpp).
// Observer. A Kalman filter a mode whose noise is the device's data, three hypotheses on when the push last jumped, and
// ln(mass) as one more state (push_observer.hpp). A lost sample is a prediction.
// Controller. Each mode has the linear-quadratic design of its inertia: torque = K (target - w), where w is where the
// hand would take the mode. The target is the point nearest to w, in the metric K, that violates no contact. The force
// is then a sum of contact normals with factors that are not negative, one contact or many (contact_projection.hpp).
// A cap keeps the outward speed below what the push turns back within the depth that no controller avoids.
#pragma once

#include <memory>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Largest delay that can be stated, ticks.
inline constexpr int kMaxLoopDelay = 8;

/// What position control is told of a device. Everything else it computes.
struct PositionControlOptions {
  double period = 1e-3;             ///< of the ticks, s
  JointVector encoderStep;          ///< step of each joint's encoder, rad or m: as many as the device has joints
  int delayLow = 0, delayHigh = 0;  ///< a command acts this many ticks late: constant, or anything between the two
  Drive drive;                      ///< between command and joint
};

/// Options for a device. Realtime: yes.
PositionControlOptions positionControlFor(const Mechanism& mechanism, double period, int delayLow, int delayHigh);

/// What position control has learnt and has not used.
struct PositionControlState {
  double mass = 1.0;       ///< of the links, over the model's
  double deviation = 0.0;  ///< of ln(mass)
  double push = 0.0;       ///< of the hand against the contacts that carry force, N; 0: there is none
  double ignored = 0.0;    ///< samples that no push explains, since reset()
  double merged = 0.0;     ///< contacts of the last tick that others already say
};

/// Position control on any mechanism with as many joints as encoder steps were given.
class PositionControlRenderer final : public Renderer {
 public:
  /// Throws Error: no or more than kMaxJoints encoder steps, one that is not positive; delays outside 0 to
  /// kMaxLoopDelay, low above high; a period outside 1e-5 to 0.1 s; numbers of the drive that are negative or not
  /// finite, a cable without a rotor; at activate(), a period other than `period`.
  explicit PositionControlRenderer(const PositionControlOptions& options);
  ~PositionControlRenderer() override;

  bool needsInertia() const noexcept override { return true; }

  /// Realtime: yes.
  PositionControlState state() const noexcept;

 private:
  class Controller;
  template <int>
  class ControllerOf;

  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override;
  StateBlock stateBlock() noexcept override;
  void stateLoaded() noexcept override;

  double period_;
  std::unique_ptr<Controller> controller_;
};

}  // namespace enamel
