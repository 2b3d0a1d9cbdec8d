#include "program/plugin_folder.hpp"

#include <filesystem>

#include "enamel/core/error.hpp"
#include "program/system.hpp"

namespace enamel::app {

std::string pluginFolder() {
  std::error_code ignored;
  const std::filesystem::path program = std::filesystem::u8path(programFile());
  const auto installed = program.parent_path().parent_path() / ENAMEL_INSTALLED_PLUGINS;
  if (!program.empty() && std::filesystem::is_directory(installed, ignored)) return installed.u8string();
  return ENAMEL_BUILT_PLUGINS;
}

std::map<std::string, std::string> parseParameters(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> parameters;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw Error("--set is \"" + text + "\", must be KEY=VALUE");
    if (!parameters.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
      throw Error("--set gives " + text.substr(0, equals) + " twice");
  }
  return parameters;
}

}  // namespace enamel::app
