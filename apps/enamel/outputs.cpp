#include "outputs.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "enamel/core/error.hpp"

namespace enamel::app {

namespace fs = std::filesystem;

void requireFree(const std::string& path, bool overwrite) {
  std::error_code none;
  if (!overwrite && !path.empty() && fs::is_regular_file(path, none) && fs::file_size(path, none) > 0)
    throw Error(path + ": exists; --overwrite replaces it");
}

void removeOld(const std::string& path, bool overwrite) {
  std::error_code none;
  if (fs::is_regular_file(path, none) && (overwrite || fs::file_size(path, none) == 0)) fs::remove(path);
}

void addOverwrite(CLI::App& command, bool& overwrite) {
  command.add_flag("--overwrite", overwrite, "replaces results that are there");
}

void protectOutputs(CLI::App& command, const std::vector<std::string>& options) {
  auto overwrite = std::make_shared<bool>(false);
  addOverwrite(command, *overwrite);
  command.parse_complete_callback([&command, options, overwrite] {
    for (const std::string& name : options)
      if (const CLI::Option* option = command.get_option(name); option->count() > 0)
        requireFree(option->results().back(), *overwrite);
  });
}

}  // namespace enamel::app
