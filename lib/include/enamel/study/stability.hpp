// Stability of position control on a device that differs from its file: the linear closed loop in steady contact.
// Assumptions and results: lib/docs/stability.md.
#pragma once

#include <vector>

#include "enamel/device/device_file.hpp"

namespace enamel {

/// Largest spectral radius of a loop that counts as stable: a deviation falls to a third in 55 ticks.
inline constexpr double kStableRadius = 0.98;

/// Differences between a device and its file.
struct DeviceErrors {
  double mass = 1.0;   ///< mass of the links over the file's; with the rotors if the transmission is rigid
  double cable = 1.0;  ///< stiffness of the cables over the file's
  double delay = 0.0;  ///< delay of a command minus the assumed one, ticks; may be a part of a tick
};

/// Which behaviours of the observer a statement covers.
enum class Scope {
  quiet,  ///< no jump of the push: the behaviour under a steady hand
  all,    ///< and a jump in every tick: the behaviour when readings contradict the prediction
};

/// A state of the loop at which it is linear: a wall, a push that holds the tool on it, and a behaviour of the
/// observer.
struct LinearCase {
  Vec3 normal;
  double push;  ///< N; 0: light, up to a tenth of the hand step F_h
  bool jumps;   ///< the observer assumes that the push jumps in every tick
};

/// The linear closed loops of position control at home, at walls across x, y and z. Each wall has three pushes: light,
/// the hand step F_h, and half of the motors' largest force (at least F_h). Immutable; threads may share it.
class LinearLoop {
 public:
  /// The renderer assumes the device of the file, and `delay` ticks of `period` s. Throws Error as makeMechanism() and
  /// PositionControlRenderer, and if the device cannot rest at home. Realtime: no.
  LinearLoop(const DeviceParameters& device, double period, int delay);
  ~LinearLoop();
  LinearLoop(LinearLoop&&) noexcept;

  int delay() const noexcept { return delay_; }
  const Drive& drive() const noexcept;  ///< as the renderer assumes it
  const std::vector<LinearCase>& cases() const noexcept { return cases_; }

  /// Return the closed-loop matrix over one tick in cases()[index]. It excludes the motion along the wall. Throws
  /// Error if a factor is not positive and finite, the delay is outside 0 to 16 ticks, or the index is too large.
  /// Realtime: no.
  Eigen::MatrixXd matrix(const DeviceErrors& errors, std::size_t index) const;
  /// Return the largest spectral radius of matrix(). Throws as matrix(). Realtime: no.
  double radius(const DeviceErrors& errors, Scope scope) const;
  /// Return whether radius() is at most kStableRadius: faster. Throws as matrix(). Realtime: no.
  bool isStable(const DeviceErrors& errors, Scope scope) const;

 private:
  class Wall;
  int delay_;
  std::vector<LinearCase> cases_;
  std::vector<Wall> walls_;  // one for each normal
};

/// The largest interval around the nominal value in which the loop is stable, if the other errors are nominal. Empty
/// (low > high) if the nominal loop is not stable. The search is within 1/5 to 5 for factors, and up to 2 ticks for a
/// delay. It scans in steps of 5 % or 0.05 ticks, and refines the ends to 0.1 % of these.
struct StableRange {
  double low, high;
};
StableRange stableRange(const LinearLoop& loop, double DeviceErrors::*error, Scope scope);

}  // namespace enamel
