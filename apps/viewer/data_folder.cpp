#include "data_folder.hpp"

#include <algorithm>

namespace enamel::viewer {

std::string dataFolder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "share" / "enamel";
  if (!error && std::filesystem::is_directory(installed / "scenes", error)) return installed.string();
  return ENAMEL_SOURCE_DATA;
}

void SceneList::add(const std::string& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  const auto found = std::find(files_.begin(), files_.end(), whole.string());
  index_ = static_cast<std::size_t>(found - files_.begin());
  if (found != files_.end()) return;
  files_.push_back(whole.string());
  names_.push_back(whole.stem().string());
}

void SceneList::addFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".toml") found.push_back(entry.path().string());
  std::sort(found.begin(), found.end());
  for (const std::string& path : found) add(path);
}

}  // namespace enamel::viewer
