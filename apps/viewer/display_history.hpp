// Texts that were shown during a run, for the report: each text once, in order of appearance.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace enamel::viewer {

struct DisplayHistory {
  std::vector<std::string> scenes, renderers, notices, badges, tips, stiffnesses, ratios;
  double deepest = 0.0;  ///< largest depth of the tool in a wall, m

  static void add(std::vector<std::string>& list, const std::string& text) {
    constexpr std::size_t most = 200;  // a run may last for hours
    if (!text.empty() && list.size() < most && std::find(list.begin(), list.end(), text) == list.end())
      list.push_back(text);
  }
};

}  // namespace enamel::viewer
