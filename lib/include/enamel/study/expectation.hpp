// Performance of position control on a device, from simulated pushes, and the device data that limit it.
#pragma once

#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/study/monte_carlo.hpp"

namespace enamel {

/// Largest safe depth of a push, m: the bound of the paper's Table II.
inline constexpr double kSafeDepth = 1e-3;

/// A better device, and the gain from it.
struct DeviceChange {
  std::string name;   ///< "half the encoder step"
  double gain = 0.0;  ///< of the mean depth stiffness: 0.6 is 60 % more
};

/// Results of pushes at home along z at one delay.
struct WallExpectation {
  int delay = 0;  ///< delay of a command, ticks
  /// Lost runs left the workspace, were stopped by the guard, or were unstable. The numbers below exclude them.
  int runs = 0, lost = 0;
  Spread stiffness;      ///< K_d, N/m
  double chatter = 0.0;  ///< largest chatter, N m or N
  double bounce = 0.0;   ///< largest bounce, m
  /// Largest step of the hand that stays below kSafeDepth and loses no run, N.
  double safePush = 0.0;
  std::vector<DeviceChange> changes;  ///< most helpful first
  /// Best spring under the same pushes, its K_d (N/m) and lost runs; without runs if it was not searched or found.
  ImpedanceOptions spring;
  Spread springStiffness;
  int springLost = 0;
};

/// Simulate pushes on a device at delays of 0 to `largestDelay` ticks of `period` s. Each push is a step of 8 to 15 N
/// after 1 N, smaller on a weak device (forceShare()), at a random time within a tick. Encoders, the hand's noise and
/// the device's [imperfections] are included. Then repeat with one of the device's data changed. `withSpring` adds
/// findBestSpring(), which takes a minute. The result does not depend on `threads`. Throws Error as makeMechanism(),
/// positionControlFor() and runPush(). Realtime: no.
std::vector<WallExpectation> expectWall(const DeviceParameters& device, double period, int largestDelay, int threads,
                                        bool withSpring = false);

}  // namespace enamel
