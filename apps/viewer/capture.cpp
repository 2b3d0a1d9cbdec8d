#include "capture.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "free_path.hpp"
#include "offscreen/png.hpp"

extern char** environ;

namespace enamel::viewer {
namespace {

constexpr int kRate = 25;  // pictures per second of a clip

void print(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

void tell(Viewer& viewer, const std::string& text) {
  viewer.notify(text);
  print(text);
}

// Run a function; an error when writing ends the clip.
template <typename Function>
void guarded(Viewer& viewer, const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    viewer.notify(error.what());
    viewer.endClip();
  }
}

std::string pictureIn(const std::string& folder, int number) {
  char name[16];
  std::snprintf(name, sizeof(name), "%05d.png", number);
  return folder + "/" + name;
}

std::string film(const std::string& folder, int pictures) {
  const std::string all =
      folder + ": " + std::to_string(pictures) + " pictures, " + std::to_string(kRate) + " a second";
  if (pictures == 0) return folder + ": no pictures";
  const std::string input = folder + "/%05d.png", output = folder + ".mp4", rate = std::to_string(kRate);
  // Common encoders need even side lengths.
  const char* const words[] = {"ffmpeg",
                               "-nostdin",
                               "-y",
                               "-loglevel",
                               "error",
                               "-framerate",
                               rate.c_str(),
                               "-i",
                               input.c_str(),
                               "-vf",
                               "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                               "-pix_fmt",
                               "yuv420p",
                               output.c_str(),
                               nullptr};
  pid_t child = 0;
  const int refused = posix_spawnp(&child, words[0], nullptr, nullptr, const_cast<char* const*>(words), environ);
  if (refused == ENOENT) return all + "; no MP4: ffmpeg is not installed";
  if (refused != 0) return all + "; no MP4: ffmpeg cannot be started (" + std::strerror(refused) + ")";
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return all + "; no MP4: ffmpeg failed";
  return all + ", and " + output;
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

// Writes pictures at a fixed rate of its clock. If drawing is slower, pictures are repeated, so that the clip lasts as
// long as the scene.
class ClipMaker::Clip {
 public:
  Clip(const std::string& folder, double now) : folder_(freePath(folder, "clip", {"", ".mp4"})), begin_(now) {
    std::error_code error;
    if (!std::filesystem::create_directory(folder_, error))
      throw Error(folder_ + ": cannot create the folder of the clip" + (error ? ": " + error.message() : ""));
  }

  double seconds(double now) const { return now - begin_; }
  // Return whether a picture is due.
  bool wants(double now) const { return seconds(now) * kRate + 1e-6 >= pictures_; }
  // Write a picture as often as it is due.
  void add(double now, const Picture& picture) {
    const std::string first = pictureIn(folder_, pictures_);
    offscreen::writePng(picture.size.x, picture.size.y, picture.rgb.data(), first);
    for (++pictures_; wants(now); ++pictures_) {
      std::error_code error;
      const std::string again = pictureIn(folder_, pictures_);
      if (!std::filesystem::copy_file(first, again, error))
        throw Error(again + ": cannot write the picture: " + error.message());
    }
  }
  std::future<std::string> makeFilm() const { return std::async(std::launch::async, film, folder_, pictures_); }

 private:
  std::string folder_;
  double begin_;
  int pictures_ = 0;
};

ClipMaker::ClipMaker(const std::string& folder) : folder_(folder) {}

ClipMaker::~ClipMaker() = default;

bool ClipMaker::begin(Viewer& viewer, double now) {
  if (film_.valid() && film_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) tell(viewer, film_.get());
  if (viewer.wantsClip() && !clip_) guarded(viewer, [&] { clip_ = std::make_unique<Clip>(folder_, now); });
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
  film_ = clip_->makeFilm();
  clip_.reset();
}

}  // namespace enamel::viewer
