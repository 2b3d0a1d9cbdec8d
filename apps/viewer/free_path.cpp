#include "free_path.hpp"

#include <algorithm>
#include <cstdio>

namespace enamel::viewer {

std::string freePath(const std::filesystem::path& folder, const char* stem,
                     std::initializer_list<const char*> endings) {
  for (int i = 1;; ++i) {
    char number[16];
    std::snprintf(number, sizeof(number), "-%03d", i);
    std::string path = (folder / (std::string(stem) + number)).string();
    if (std::none_of(endings.begin(), endings.end(), [&](const char* e) { return std::filesystem::exists(path + e); }))
      return path;
  }
}

}  // namespace enamel::viewer
