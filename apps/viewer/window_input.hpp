// The events of a window, for Dear ImGui and for Input.
#pragma once

#include "input.hpp"

struct GLFWwindow;

namespace enamel::viewer {

/// Sets the window's callbacks; ends before the canvas does. One at a time. What ImGui wants does not reach `input`.
///
/// ImGui 1.86 looks at the keys once a picture: what was pressed and released since the last one is released one
/// picture later, or an Enter would be lost now and then.
class WindowInput {
 public:
  WindowInput(GLFWwindow* window, Input& input);
  ~WindowInput();
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  /// Takes the events since the last picture.
  void poll();
  /// Keys that act as long as they are down, for the seconds since the last call.
  void hold(double seconds);

 private:
  GLFWwindow* window_;
  Input& input_;
};

}  // namespace enamel::viewer
