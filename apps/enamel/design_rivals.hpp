// `enamel design --rivals`: searches the controllers that position control is compared with. Each search simulates the
// loop in which the controller runs.
#pragma once

#include <cstdint>
#include <string>

namespace enamel::app {

/// Options of the command.
struct RivalSearchOptions {
  std::string device, plant;                     ///< --plant
  std::string scene;                             ///< scene for additional pushes; empty: none
  double period = 1e-3;                          ///< s
  double halfWidth = 0.025, chatter = 0.0;       ///< m; N m or N (0: 2.5 % of the weakest motor)
  int generations = 60, runs = 24, threads = 0;  ///< threads = 0: all
  std::uint64_t seed = 1;
};

/// Search the parameters of each of rivalSpecs() for delays of 0, 1, 2, 3 and 0..3 ticks. Print their results on new
/// random numbers beside those of position control. Return the text of the parameter file. Throws Error.
std::string designRivals(const RivalSearchOptions& options);

}  // namespace enamel::app
