#include "outputs.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "enamel/core/error.hpp"

namespace enamel::app {

namespace fs = std::filesystem;

void requireFree(const std::string& path, bool overwrite) {
  std::error_code none;
  if (!overwrite && !path.empty() && fs::is_regular_file(path, none) && fs::file_size(path, none) > 0)
    throw Error(path + ": exists; --force overwrites it");
}

void removeOld(const std::string& path, bool overwrite) {
  std::error_code none;
  if (fs::is_regular_file(path, none) && (overwrite || fs::file_size(path, none) == 0)) fs::remove(path);
}

void addOverwrite(CLI::App& command, bool& overwrite) {
  const bool isTaken = command.get_option_no_throw("--force") != nullptr;
  command.add_flag(isTaken ? "--overwrite" : "--force,--overwrite", overwrite,
                   isTaken ? "writes over results that are there; --force without a number does the same"
                           : "writes over results that are there");
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

void nameOverwrite(std::vector<std::string>& arguments) {
  const std::vector<std::string> forceful = {"push", "study", "compare", "design"};
  if (arguments.empty() || std::count(forceful.begin(), forceful.end(), arguments.front()) == 0) return;
  for (auto it = arguments.begin(); it != arguments.end(); ++it)
    if (*it == "--force" && (it + 1 == arguments.end() || (it + 1)->rfind("--", 0) == 0)) *it = "--overwrite";
}

}  // namespace enamel::app
