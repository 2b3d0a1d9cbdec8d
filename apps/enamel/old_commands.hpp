// Commands of version 0.2, which this one still takes.
#pragma once

#include <string>
#include <vector>

namespace enamel::app {

/// Return a command line (without the program's name) with the present names: `trials` and `study --judge` are
/// `compare`, --laws is --tuned. `warning` says what to write instead; it is empty where nothing was renamed.
std::vector<std::string> presentCommand(std::vector<std::string> arguments, std::string& warning);

}  // namespace enamel::app
