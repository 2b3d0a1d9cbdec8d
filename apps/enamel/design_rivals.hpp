// `enamel design --rivals`: the controllers that position control is compared with, each found by a simulation of the
// loop that it runs in.
#pragma once

#include <cstdint>
#include <string>

namespace enamel::app {

/// What the command was asked for.
struct RivalSearchOptions {
  std::string device, plant;                     ///< --plant
  std::string scene;                             ///< where it is pushed too; empty: nowhere
  double period = 1e-3;                          ///< s
  double halfWidth = 0.025, chatter = 0.0;       ///< m; N m or N, 0: 2.5 % of the weakest motor
  int generations = 60, runs = 24, threads = 0;  ///< 0: all
  std::uint64_t seed = 1;
};

/// Search the numbers of each of rivalSpecs() for delays of 0, 1, 2, 3 and 0..3 ticks, and print how they do on new
/// random numbers beside position control. Return the file of their values. Throws Error.
std::string designRivals(const RivalSearchOptions& options);

}  // namespace enamel::app
