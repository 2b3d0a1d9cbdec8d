// Pictures and clips of what a viewer shows, as files.
#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include "clip.hpp"
#include "viewer.hpp"

namespace enamel::viewer {

/// Writes what was drawn last into a folder, once for each name (empty: the next free one). Throws Error.
void writePictures(const std::string& folder, Viewer& viewer, const std::vector<std::string>& names);

/// The clip that a viewer wants, and the film of the last one.
class ClipMaker {
 public:
  explicit ClipMaker(const std::string& folder) : folder_(folder) {}

  /// Before a picture: whether the clip needs it.
  bool begin(Viewer& viewer, double now);
  /// After it was drawn.
  void add(Viewer& viewer, double now);
  /// At the end of the program.
  void finish(Viewer& viewer);

 private:
  void end(Viewer& viewer);

  std::string folder_;
  std::optional<Clip> clip_;
  std::future<std::string> film_;
};

}  // namespace enamel::viewer
