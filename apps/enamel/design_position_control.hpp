// `enamel design --surface` and `--rivals`: the contact-space servo and the controllers it is compared with, each found
// by the same simulation of the loop that it runs in.
#pragma once

#include <cstdint>
#include <string>

#include "enamel/sim/virtual_device.hpp"

namespace enamel::app {

/// What the command was asked for.
struct DesignSearchOptions {
  std::string device, plant;  ///< --plant
  std::string scene;          ///< where it is pushed too; empty: nowhere
  double period = 1e-3;       ///< s
  Delay delay;
  double inertiaError = 0.0, halfWidth = 0.025, chatter = 0.0;  ///< share; m; N m or N, 0: 2.5 % of the weakest motor
  int generations = 60, runs = 24, threads = 0;                 ///< 0: all
  std::uint64_t seed = 1;
};

/// Searches, prints the trade-off and how the servo does on new random numbers; returns the servo's file. Throws Error.
std::string designPositionControl(const DesignSearchOptions& options);

/// The same for every rivalSpecs() and delays of 0, 1, 2, 3 and 0..3 ticks (`delay` is not read); returns the file of
/// their values. Throws Error.
std::string designRivals(const DesignSearchOptions& options);

}  // namespace enamel::app
