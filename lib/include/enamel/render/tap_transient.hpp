// The force of a tap: when the tool hits a surface, it makes the handle vibrate as a real one does on that material.
#pragma once

#include <array>
#include <cstddef>

#include "enamel/collision/scene.hpp"
#include "enamel/render/frame.hpp"
#include "enamel/render/position_control.hpp"

namespace enamel {

/// Return whether an obstacle of the scene, or a layer of a solid in it, has a Tap. Realtime: yes.
bool hasTaps(const Scene& scene) noexcept;

/// Adds the transient of Obstacle::tap to the torque of any renderer. An impact at the speed v starts a reference
/// motion of the tool, that of a damped oscillator:
///
///   z'' = a(t) = v (B^2 + w^2) / w exp(-B t) sin(w t), |z''| limited by the motors
///
/// The transient is the force m z'' along the normal, with the effective mass m. While it lasts, the renderer sees the
/// surface move with z, so that it only corrects deviations from it.
///
/// A running account has the energy that the commanded forces took from the tool since the impact. It counts the
/// samples, and predicts the commands that have not acted yet. A force that would give more is reduced. So an
/// oscillation never has more energy than the impact. Equations: lib/docs/taps.md.
class TapTransient {
 public:
  /// Forget the impact. Realtime: yes.
  void reset() noexcept { state_ = State{}; }

  /// Detect an impact, and move the surfaces in the frame as the renderer shall see them. `period`: s. The frame must
  /// have its contact rows. A delay that varies by a quarter of a period of the vibration or more starts no transient:
  /// a force that late gives the energy that it should take. Realtime: yes.
  void move(TickFrame& frame, const Scene& scene, const Delay& delay, double period,
            const JointLimits& limits) noexcept;

  /// Put the surfaces back, and add the force to the torque of the output. Realtime: yes.
  void push(TickFrame& frame) noexcept;

  /// Note the command that was sent. Realtime: yes.
  void sent(const TickFrame& frame) noexcept;

  /// Return the force of the last tick along the normal, N. Realtime: yes.
  double force() const noexcept { return state_.force; }
  /// Return the energy that the forces took from the tool since the impact, until the last sample, J. Realtime: yes.
  double energy() const noexcept { return state_.energy; }

  /// Save and load the state as kNumbers numbers. Realtime: yes.
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

 private:
  // Plain numbers.
  struct State {
    std::array<double, 6> twist{};        // filtered, m/s and rad/s
    std::array<double, 3> normal{};       // of the impact, W
    double obstacle = -1.0;               // that was hit; -1: no transient
    double touched = 0.0;                 // the last sample was inside a surface with a tap
    double elapsed = 0.0, speed = 0.0;    // since the impact, s; at the impact, m/s
    double frequency = 0.0, decay = 0.0;  // Hz, 1/s
    double mass = 0.0, most = 0.0;        // kg; largest force, N
    double gain = 1.0, compliance = 0.0;  // of the cables at the frequency: force per force of a rigid drive; m/N
    double deflection = 0.0, rate = 0.0;  // of the oscillator when the next command acts, m, m/s
    double place = 0.0;                   // of the surface that the renderer sees then, m
    double energy = 0.0, doubt = 0.0;     // J; doubt: its uncertainty, half an encoder step times `most`
    double gap = 0.0, missed = 0.0;       // at the last sample, m; samples lost since then
    double force = 0.0;                   // N
    double joints = 0.0;                  // of `added`; 0: nothing was added
    JointRow added{};                     // to the renderer's last torque, N m or N
    std::array<std::array<double, 3>, kMaxLoopDelay + 1> sent{};  // commanded forces at the TCP, W, newest first, N
    std::array<double, kMaxLoopDelay + 1> moves{};                // motion of the tool while they act, m
  };

 public:
  static constexpr std::size_t kNumbers = sizeof(State) / sizeof(double);

 private:
  void detect(const TickFrame& frame, const Scene& scene, const JointLimits& limits) noexcept;
  double sentAlong(const Vec3& normal, int command) const noexcept;
  const Contact* contactOf(const TickFrame& frame) const noexcept;

  State state_;
  // Of the present tick.
  int delay_ = 0, spread_ = 0;  // least, ticks; by how much it varies at random
  double period_ = 1e-3;        // s
  JointVector rendered_;        // the renderer's torque
  std::array<Contact, kMaxContacts> seen_;
};

}  // namespace enamel
