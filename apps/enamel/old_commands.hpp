// Commands of version 0.2 that are still accepted.
#pragma once

#include <string>
#include <vector>

namespace enamel::app {

/// Return a command line (without the program's name) with the present names: `trials` and `study --judge` become
/// `compare`, --laws becomes --tuned. `warning` says what to write instead; it is empty if nothing was renamed.
std::vector<std::string> presentCommand(std::vector<std::string> arguments, std::string& warning);

}  // namespace enamel::app
