#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

#include "enamel/core/error.hpp"
#include "surface.hpp"

namespace enamel::viewer {
namespace {

std::string reason() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "unknown reason";
}

class Window final : public WindowSurface {
 public:
  Window(const std::string& title, const glm::ivec2& size) {
    if (glfwInit() != GLFW_TRUE)
      throw Error("cannot open a window, no display (" + reason() + "); use --headless without a display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 2);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_SAMPLES, 0);
    window_ = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
      const std::string why = reason();
      glfwTerminate();
      throw Error("cannot open a window with OpenGL 3.2 (" + why + ")");
    }
    glfwSetWindowSizeLimits(window_, 480, 320, GLFW_DONT_CARE, GLFW_DONT_CARE);
    makeCurrent();
    glfwSwapInterval(1);
  }

  ~Window() override {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }

  void makeCurrent() override { glfwMakeContextCurrent(window_); }
  bool isCurrent() const override { return glfwGetCurrentContext() == window_; }

  glm::ivec2 size() const override {
    glm::ivec2 size;
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return glm::max(size, glm::ivec2(1));  // 0 while minimised
  }

  float scale() const override {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(x, 1.0f, 4.0f);
  }

  void resize(const glm::ivec2& size) override { glfwSetWindowSize(window_, size.x, size.y); }
  unsigned framebuffer() const override { return 0; }
  void present() override { glfwSwapBuffers(window_); }
  GLFWwindow* window() override { return window_; }

  void setFullScreen(bool full) override {
    if (full == (glfwGetWindowMonitor(window_) != nullptr)) return;
    if (full) {
      GLFWmonitor* monitor = glfwGetPrimaryMonitor();
      const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
      if (mode == nullptr) return;
      glfwGetWindowPos(window_, &place_.x, &place_.y);
      glfwGetWindowSize(window_, &before_.x, &before_.y);
      glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    } else {
      glfwSetWindowMonitor(window_, nullptr, place_.x, place_.y, before_.x, before_.y, 0);
    }
  }

 private:
  GLFWwindow* window_ = nullptr;
  glm::ivec2 place_{0}, before_{0};
};

}  // namespace

std::unique_ptr<WindowSurface> openWindow(const std::string& title, const glm::ivec2& size) {
  return std::make_unique<Window>(title, size);
}

}  // namespace enamel::viewer
