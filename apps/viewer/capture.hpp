// Writes pictures and clips of the viewer to files.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "viewer.hpp"

namespace enamel::viewer {

/// Write the last drawn picture into a folder, once for each name (empty: the next free name). Throws Error.
void writePictures(const std::string& folder, Viewer& viewer, const std::vector<std::string>& names);

/// Makes a clip for a viewer: numbered pictures, and a film if ffmpeg is installed.
class ClipMaker {
 public:
  explicit ClipMaker(const std::string& folder);
  ~ClipMaker();

  /// Return whether the clip needs the next picture. Call it before drawing.
  bool begin(Viewer& viewer, double now);
  /// Add the picture after it was drawn.
  void add(Viewer& viewer, double now);
  /// Complete the clip at the end of the program.
  void finish(Viewer& viewer);

 private:
  class Clip;
  void end(Viewer& viewer);

  std::string folder_;
  std::unique_ptr<Clip> clip_;
  std::future<std::string> film_;  // result of the last film as a sentence
};

}  // namespace enamel::viewer
