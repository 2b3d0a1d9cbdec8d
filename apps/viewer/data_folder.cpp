#include "data_folder.hpp"

#include <filesystem>

namespace enamel::viewer {

std::string dataFolder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "share" / "enamel";
  if (!error && std::filesystem::is_directory(installed / "scenes", error)) return installed.string();
  return ENAMEL_SOURCE_DATA;
}

}  // namespace enamel::viewer
