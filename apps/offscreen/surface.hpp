// Target of drawing: an OpenGL 3.2 core context with a framebuffer, in a window or without a display.
#pragma once

#include <glm/glm.hpp>
#include <memory>

namespace enamel::offscreen {

class Surface {
 public:
  Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  virtual ~Surface() = default;

  virtual void makeCurrent() = 0;
  virtual bool isCurrent() const = 0;
  virtual glm::ivec2 size() const = 0;  ///< of the framebuffer, pixels
  virtual float scale() const = 0;      ///< pixels per unit of layout: 2 on a display with twice the usual density
  virtual void resize(const glm::ivec2& size) = 0;
  virtual unsigned framebuffer() const = 0;
  virtual void present() = 0;
};

/// Open a framebuffer of `size` pixels without a display (EGL, surfaceless). Throws Error: no EGL, no OpenGL 3.2.
std::unique_ptr<Surface> openHeadless(const glm::ivec2& size, float scale);

}  // namespace enamel::offscreen
