// Location of plugins, and their parameters on a command line.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace enamel::app {

/// Return the folder of the plugins of this program: installed beside it, or in its build tree.
std::string pluginFolder();

/// Convert KEY=VALUE, ... to a map. Throws Error: a text without '=', or a key given twice.
std::map<std::string, std::string> parseParameters(const std::vector<std::string>& texts);

}  // namespace enamel::app
