// Where the scenes and devices that come with the program are, and the scenes to choose from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace enamel::viewer {

/// The folder `data`: beside the installed program if there is one, else that of the source tree.
std::string dataFolder();

class SceneList {
 public:
  /// Makes a file the chosen one; if it is in the list already, it stays where it is.
  void add(const std::string& path);
  /// All scene files of a folder, by name.
  void addFolder(const std::filesystem::path& folder);

  bool empty() const { return files_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  std::size_t index() const { return index_; }  ///< of the chosen one
  std::size_t next() const { return (index_ + 1) % files_.size(); }
  /// Its file.
  const std::string& choose(std::size_t index) { return files_[index_ = index]; }

 private:
  std::vector<std::string> files_, names_;
  std::size_t index_ = 0;
};

}  // namespace enamel::viewer
