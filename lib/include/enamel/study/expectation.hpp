// What position control does on a device, from simulated pushes, and which of the device's data limits it.
#pragma once

#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"

namespace enamel {

/// Largest depth of a push that counts as safe, m: the bound of the paper's Table II.
inline constexpr double kSafeDepth = 1e-3;

/// A better device, and what it brings.
struct DeviceChange {
  std::string name;   ///< "half the encoder step"
  double gain = 0.0;  ///< of the mean depth stiffness: 0.6 is 60 % more
};

/// Pushes at home along z at one delay.
struct WallExpectation {
  int delay = 0;           ///< of a command, ticks
  int runs = 0, lost = 0;  ///< lost: left the workspace, stopped by the guard, unstable; not in the numbers below
  double stiffness = 0.0;  ///< K_d, mean, N/m
  double chatter = 0.0;    ///< largest, N m or N
  double bounce = 0.0;     ///< largest, m
  double safePush = 0.0;   ///< largest step of the hand that goes less than kSafeDepth deep and loses no run, N
  std::vector<DeviceChange> changes;  ///< the most helpful first
};

/// Steps of 8 to 15 N after 1 N, less on a weak device (forceShare()), at a random instant inside a tick, with
/// encoders, the hand's noise and the device's [imperfections], at delays of 0 to `largestDelay` ticks of `period` s;
/// then the same with one of the device's data changed. In simulation. The result does not depend on `threads`. Throws
/// Error: as makeMechanism(), positionControlFor() and runPush(). Realtime: no.
std::vector<WallExpectation> expectWall(const DeviceParameters& device, double period, int largestDelay, int threads);

}  // namespace enamel
