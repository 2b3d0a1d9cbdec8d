#include "clip.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "free_path.hpp"
#include "offscreen/png.hpp"

extern char** environ;

namespace enamel::viewer {
namespace {

std::string pictureIn(const std::string& folder, int number) {
  char name[16];
  std::snprintf(name, sizeof(name), "%05d.png", number);
  return folder + "/" + name;
}

std::string film(const std::string& folder, int pictures) {
  const std::string all =
      folder + ": " + std::to_string(pictures) + " pictures, " + std::to_string(Clip::kRate) + " a second";
  if (pictures == 0) return folder + ": no picture";
  const std::string input = folder + "/%05d.png", output = folder + ".mp4", rate = std::to_string(Clip::kRate);
  // Even sides: the usual encoders take no others.
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

Clip::Clip(const std::string& folder, double now) : folder_(freePath(folder, "clip", {"", ".mp4"})), begin_(now) {
  std::error_code error;
  if (!std::filesystem::create_directory(folder_, error))
    throw Error(folder_ + ": cannot make the folder of a clip" + (error ? ": " + error.message() : ""));
}

bool Clip::wants(double now) const { return seconds(now) * kRate + 1e-6 >= pictures_; }

void Clip::add(double now, const Picture& picture) {
  const std::string first = pictureIn(folder_, pictures_);
  offscreen::writePng(picture.size.x, picture.size.y, picture.rgb.data(), first);
  for (++pictures_; wants(now); ++pictures_) {
    std::error_code error;
    const std::string again = pictureIn(folder_, pictures_);
    if (!std::filesystem::copy_file(first, again, error)) throw Error(again + ": cannot write: " + error.message());
  }
}

std::future<std::string> filmOf(const Clip& clip) {
  return std::async(std::launch::async, film, clip.folder(), clip.pictures());
}

}  // namespace enamel::viewer
