// Folder of the scenes and devices that come with the program, and the list of scenes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace enamel::viewer {

/// Return the folder `data`: beside the installed program if it exists, otherwise in the source tree.
std::string dataFolder();

class SceneList {
 public:
  /// Select a file. A file that is already in the list keeps its position.
  void add(const std::string& path);
  /// Add all scene files of a folder, sorted by name.
  void addFolder(const std::filesystem::path& folder);

  bool empty() const { return files_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  std::size_t index() const { return index_; }  ///< of the selected scene
  std::size_t next() const { return (index_ + 1) % files_.size(); }
  /// Select a scene and return its file.
  const std::string& choose(std::size_t index) { return files_[index_ = index]; }

 private:
  std::vector<std::string> files_, names_;
  std::size_t index_ = 0;
};

}  // namespace enamel::viewer
