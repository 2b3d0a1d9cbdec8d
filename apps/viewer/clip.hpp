// A clip of what is shown: numbered pictures, and of them a film where ffmpeg is.
#pragma once

#include <future>
#include <string>

#include "canvas.hpp"

namespace enamel::viewer {

/// Writes pictures at a fixed rate of the clock that drives it, each again where drawing is slower: the clip lasts as
/// long as what it shows.
class Clip {
 public:
  static constexpr int kRate = 25;  ///< pictures a second

  /// Makes a folder clip-001, or the next free one, in `folder`. Throws Error.
  Clip(const std::string& folder, double now);

  const std::string& folder() const { return folder_; }
  double seconds(double now) const { return now - begin_; }
  int pictures() const { return pictures_; }

  /// Whether a picture is due at `now`, s; writes it, as often as it is. Throws Error.
  bool wants(double now) const;
  void add(double now, const Picture& picture);

 private:
  std::string folder_;
  double begin_;
  int pictures_ = 0;
};

/// Makes folder.mp4 of a clip's pictures with ffmpeg, in a thread of its own: what came of it, in a sentence.
std::future<std::string> filmOf(const Clip& clip);

}  // namespace enamel::viewer
