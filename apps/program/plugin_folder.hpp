// Where plugins are, and their parameters on a command line.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace enamel::app {

/// The folder of the plugins that came with this program: installed beside it, or of its build tree.
std::string pluginFolder();

/// KEY=VALUE, ... as a map. Throws Error: a text without '=', or a key given twice.
std::map<std::string, std::string> parseParameters(const std::vector<std::string>& texts);

}  // namespace enamel::app
