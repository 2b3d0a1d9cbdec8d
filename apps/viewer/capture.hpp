// Pictures and clips of what a viewer shows, as files.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "viewer.hpp"

namespace enamel::viewer {

/// Writes what was drawn last into a folder, once for each name (empty: the next free one). Throws Error.
void writePictures(const std::string& folder, Viewer& viewer, const std::vector<std::string>& names);

/// The clip that a viewer wants: numbered pictures, and of them a film where ffmpeg is.
class ClipMaker {
 public:
  explicit ClipMaker(const std::string& folder);
  ~ClipMaker();

  /// Before a picture: whether the clip needs it.
  bool begin(Viewer& viewer, double now);
  /// After it was drawn.
  void add(Viewer& viewer, double now);
  /// At the end of the program.
  void finish(Viewer& viewer);

 private:
  class Clip;
  void end(Viewer& viewer);

  std::string folder_;
  std::unique_ptr<Clip> clip_;
  std::future<std::string> film_;  // of the last one: what came of it, in a sentence
};

}  // namespace enamel::viewer
