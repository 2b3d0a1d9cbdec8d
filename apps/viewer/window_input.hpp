// Events of a window for Dear ImGui and for Input.
#pragma once

#include "input.hpp"

struct GLFWwindow;

namespace enamel::viewer {

/// Sets the window's callbacks; must end before the canvas. Only one instance at a time. Events that ImGui wants do not
/// reach `input`.
///
/// ImGui 1.86 looks at the keys once per picture. A key that was pressed and released since the last picture is
/// therefore released one picture later; otherwise an Enter could be lost.
class WindowInput {
 public:
  WindowInput(GLFWwindow* window, Input& input);
  ~WindowInput();
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  /// Process the events since the last picture.
  void poll();
  /// Process keys that act while they are down. `seconds`: since the last call.
  void hold(double seconds);

 private:
  GLFWwindow* window_;
  Input& input_;
};

}  // namespace enamel::viewer
