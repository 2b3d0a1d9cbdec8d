#include "capture.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "free_path.hpp"
#include "offscreen/png.hpp"

namespace enamel::viewer {
namespace {

void print(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

void tell(Viewer& viewer, const std::string& text) {
  viewer.notify(text);
  print(text);
}

// What cannot be written ends the clip.
template <typename Function>
void guarded(Viewer& viewer, const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    viewer.notify(error.what());
    viewer.endClip();
  }
}

}  // namespace

void writePictures(const std::string& folder, Viewer& viewer, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string path =
        (name.empty() ? freePath(folder, "enamel", {".png"}) : (std::filesystem::path(folder) / name).string()) +
        ".png";
    const Picture picture = viewer.canvas().read();
    offscreen::writePng(picture.size.x, picture.size.y, picture.rgb.data(), path);
    print(path);
  }
}

bool ClipMaker::begin(Viewer& viewer, double now) {
  if (film_.valid() && film_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) tell(viewer, film_.get());
  if (viewer.wantsClip() && !clip_) guarded(viewer, [&] { clip_.emplace(folder_, now); });
  if (!viewer.wantsClip() && clip_) end(viewer);
  viewer.showClip(clip_ ? clip_->seconds(now) : -1.0);
  return clip_ && clip_->wants(now);
}

void ClipMaker::add(Viewer& viewer, double now) {
  guarded(viewer, [&] { clip_->add(now, viewer.canvas().read()); });
}

void ClipMaker::finish(Viewer& viewer) {
  if (clip_) end(viewer);
  if (film_.valid()) tell(viewer, film_.get());
}

void ClipMaker::end(Viewer& viewer) {
  if (film_.valid()) tell(viewer, film_.get());
  film_ = filmOf(*clip_);
  clip_.reset();
}

}  // namespace enamel::viewer
