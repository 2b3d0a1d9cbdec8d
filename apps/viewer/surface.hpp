// The window of the viewer, and the surface without a display.
#pragma once

#include <memory>
#include <string>

#include "offscreen/surface.hpp"

struct GLFWwindow;

namespace enamel::viewer {

using offscreen::openHeadless;
using offscreen::Surface;

/// A window, for input.
class WindowSurface : public Surface {
 public:
  virtual GLFWwindow* window() = 0;
  virtual void setFullScreen(bool full) = 0;
};

/// Open a window of `size` units. Throws Error: no display, no OpenGL 3.2.
std::unique_ptr<WindowSurface> openWindow(const std::string& title, const glm::ivec2& size);

}  // namespace enamel::viewer
