// Stability of position control on a device that differs from its file: the spectral radius of the linear closed loop.
#pragma once

#include <memory>
#include <vector>

#include "enamel/device/device_file.hpp"

namespace enamel {

/// Largest spectral radius of a loop that counts as stable: an error falls to a third in 50 ticks.
inline constexpr double kStableRadius = 0.98;

/// Differences between a device and its file.
struct DeviceErrors {
  double mass = 1.0;   ///< mass of the links over the file's, with the rotors if the transmission is rigid
  double cable = 1.0;  ///< stiffness of the cables over the file's
  double delay = 0.0;  ///< delay of a command minus the assumed one, ticks; may be a part of a tick
};

/// The linear closed loop of position control, in steady contact of the TCP with a wall at home. lib/docs/stability.md
/// has the assumptions. Immutable; threads may share it.
class LinearLoop {
 public:
  /// The renderer assumes the device of the file, and `delay` ticks of `period` s. `normal` is that of the wall, a unit
  /// vector. Throws Error as makeMechanism() and PositionControlRenderer. Realtime: no.
  LinearLoop(const DeviceParameters& device, double period, int delay, const Vec3& normal);
  ~LinearLoop();
  LinearLoop(LinearLoop&&) noexcept;

  /// Return the pushes of radius(), N: none, the hand step, and half the largest force of the motors.
  const std::vector<double>& pushes() const noexcept;
  /// Return the closed-loop matrix over one tick under pushes()[push]. It does not contain the motion along the wall.
  /// Throws Error if an error is not finite, a factor is not positive, or the whole delay is negative. Realtime: no.
  Eigen::MatrixXd matrix(const DeviceErrors& errors, std::size_t push) const;
  /// Return its largest spectral radius over all pushes. Throws as matrix(). Realtime: no.
  double radius(const DeviceErrors& errors) const;

 private:
  class Loop;
  template <int>
  class LoopOf;
  std::unique_ptr<const Loop> loop_;
};

}  // namespace enamel
