// Runs the built viewer as a user would, and examines its pictures.
#pragma once

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/skip.hpp"

namespace enamel::test {

/// A picture whose first row is at the top.
class Pixels {
 public:
  explicit Pixels(const std::string& path) {
    vtkNew<vtkPNGReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    image_->ShallowCopy(reader->GetOutput());
    REQUIRE(image_->GetNumberOfScalarComponents() == 3);
  }
  glm::ivec2 size() const { return {image_->GetDimensions()[0], image_->GetDimensions()[1]}; }
  glm::ivec3 at(int x, int y) const {
    const auto* p = static_cast<const unsigned char*>(image_->GetScalarPointer(x, size().y - 1 - y, 0));
    return {p[0], p[1], p[2]};
  }

 private:
  mutable vtkNew<vtkImageData> image_;
};

/// Return whether a lit pixel has a colour's hue: the same proportions of red, green and blue, at any brightness.
inline bool hasHue(const glm::ivec3& pixel, unsigned rgb, double tolerance = 0.06) {
  const glm::dvec3 p(pixel), c(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255);
  const double sum = p.x + p.y + p.z;
  return sum > 60.0 && glm::distance(p / sum, c / (c.x + c.y + c.z)) < tolerance;
}

/// Pixels of a hue in a rectangle: their number and mean position.
struct Patch {
  int count = 0;
  glm::dvec2 centre{0.0};
};
inline Patch patchOf(const Pixels& pixels, unsigned rgb, glm::ivec2 from, glm::ivec2 to, double tolerance = 0.06) {
  Patch patch;
  from = glm::clamp(from, glm::ivec2(0), pixels.size());
  to = glm::clamp(to, glm::ivec2(0), pixels.size());
  for (int y = from.y; y < to.y; ++y)
    for (int x = from.x; x < to.x; ++x)
      if (hasHue(pixels.at(x, y), rgb, tolerance)) {
        ++patch.count;
        patch.centre += glm::dvec2(x, y);
      }
  if (patch.count > 0) patch.centre /= patch.count;
  return patch;
}

/// Run enamel-viewer after `before` (environment, X server). The time limit only ends a viewer that hangs.
inline CommandResult viewer(const std::string& arguments,
                            const std::string& before = "env -u DISPLAY -u WAYLAND_DISPLAY") {
  return runCommand("timeout 3000 " + before + " '" + ENAMEL_VIEWER + "' " + arguments);
}

/// Run a command under a separate X server.
inline std::string underXvfb(const std::string& server) {
  return "sh '" ENAMEL_SOURCE_DIR "/tests/viewer/under_xvfb.sh' '" + server + "' ";
}
inline const std::string kXvfb = underXvfb("-screen 0 1280x720x24");

/// For windows whose pictures are not counted: OpenGL in software takes all available time.
inline const std::string kFewPictures = " --frame-rate 12 ";

/// For scripts in a window: their time advances with the pictures, so that they mean the same on a slow machine.
inline const std::string kByPictures = kFewPictures + "--fixed-step ";

inline bool haveXvfb() { return runCommand("command -v Xvfb").status == 0; }

inline std::string shippedScene(const std::string& name) { return "'" ENAMEL_SOURCE_DIR "/data/scenes/" + name + "'"; }

}  // namespace enamel::test
