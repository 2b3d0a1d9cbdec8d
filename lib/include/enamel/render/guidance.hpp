// The force of the guides of a scene on the tool.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "enamel/collision/guide.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

/// Add the forces of guides. A guide pulls the TCP towards the nearest point of its shape:
///
///   F = -k (e + 10 T e'), reduced to maxForce
///
/// e is the error of errorOf(), e' its rate, T the period. The velocity for e' is a filtered difference of positions. A
/// region gives no force while e + 10 T e' points inwards: it pushes back, and does not hold. If the sum of all
/// stiffnesses exceeds largestStiffness(), all are reduced by one factor. The loop is then stable at delays of up to 3
/// ticks, and takes energy from motions of the hand below 36 Hz (at T = 1 ms). Guides ramp in over 0.1 s. Equations:
/// lib/docs/guides.md.
class Guidance {
 public:
  /// `period` of the ticks, s. Realtime: no.
  Guidance(const Mechanism& mechanism, double period);

  /// Return the largest sum of stiffnesses that acts, in the units of Guide::stiffness, N/m: 0.01 m / T^2 with the
  /// least effective mass m at home, or less behind cables. Realtime: yes.
  double largestStiffness() const noexcept;

  /// Forget the motion; the force begins again at zero. Realtime: yes.
  void reset() noexcept { state_ = State{}; }

  /// Return the force on the TCP in a tick, W, N, and set TickFrame::guided. A tick without a sample repeats the force.
  /// Realtime: yes.
  Vec3 step(const std::vector<Guide>& guides, TickFrame& frame) noexcept;

  /// Note which share of the force was sent to the motors. Realtime: yes.
  void sent(double share) noexcept { state_.acting = share * state_.ramp; }

  /// Save and load the state as kNumbers numbers. Realtime: yes.
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

 private:
  // Plain numbers.
  struct State {
    double time = 0.0, started = 0.0;              // of the last sample, s; 1: there was one
    std::array<double, 3> position{}, velocity{};  // of the TCP, W
    std::array<double, 3> force{}, elastic{};      // of the last sample; without damping and before the ramp
    double ramp = 0.0, acting = 0.0;               // shares of the force: of the ramp, and that acts
  };

 public:
  static constexpr std::size_t kNumbers = sizeof(State) / sizeof(double);

 private:
  double mass_, frequency_, period_, scale_;  // m, kg; largest sqrt(k / m), 1/s; s; of the mechanism
  State state_;
};

}  // namespace enamel
