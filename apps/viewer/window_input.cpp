#define GLFW_INCLUDE_NONE
#include "window_input.hpp"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace enamel::viewer {
namespace {

struct Key {
  int key, scancode, modifiers;
};
GLFWkeyfun gBehind = nullptr;  // callback of ImGui, followed by ours
std::vector<int> gPressed;     // since the last poll()
std::vector<Key> gReleased;    // to be reported at the next poll()

Input& inputOf(GLFWwindow* window) { return *static_cast<Input*>(glfwGetWindowUserPointer(window)); }

void onKey(GLFWwindow* window, int key, int, int action, int modifiers) {
  if (!ImGui::GetIO().WantTextInput) inputOf(window).key(key, action, modifiers);
}

void onButton(GLFWwindow* window, int button, int action, int modifiers) {
  if (action == GLFW_RELEASE || !ImGui::GetIO().WantCaptureMouse) inputOf(window).button(button, action, modifiers);
}

void onCursor(GLFWwindow* window, double x, double y) { inputOf(window).cursor({x, y}); }

void onDrop(GLFWwindow* window, int count, const char** paths) { inputOf(window).drop({paths, paths + count}); }

bool isDown(GLFWwindow* window, int key) { return glfwGetKey(window, key) == GLFW_PRESS; }

void onWheel(GLFWwindow* window, double, double notches) {
  if (!ImGui::GetIO().WantCaptureMouse)
    inputOf(window).wheel(notches, isDown(window, GLFW_KEY_LEFT_CONTROL) || isDown(window, GLFW_KEY_RIGHT_CONTROL));
}

void onAnyKey(GLFWwindow* window, int key, int scancode, int action, int modifiers) {
  if (action == GLFW_PRESS) gPressed.push_back(key);
  if (action == GLFW_RELEASE && std::find(gPressed.begin(), gPressed.end(), key) != gPressed.end())
    gReleased.push_back({key, scancode, modifiers});
  else
    gBehind(window, key, scancode, action, modifiers);
}

}  // namespace

WindowInput::WindowInput(GLFWwindow* window, Input& input) : window_(window), input_(input) {
  glfwSetWindowUserPointer(window, &input);
  glfwSetKeyCallback(window, onKey);
  glfwSetMouseButtonCallback(window, onButton);
  glfwSetCursorPosCallback(window, onCursor);
  glfwSetScrollCallback(window, onWheel);
  glfwSetDropCallback(window, onDrop);
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  gBehind = glfwSetKeyCallback(window, onAnyKey);
}

WindowInput::~WindowInput() { ImGui_ImplGlfw_Shutdown(); }

void WindowInput::poll() {
  gPressed.clear();
  for (const Key& key : std::exchange(gReleased, {}))
    gBehind(window_, key.key, key.scancode, GLFW_RELEASE, key.modifiers);
  glfwPollEvents();
}

void WindowInput::hold(double seconds) {
  if (!ImGui::GetIO().WantTextInput) input_.hold([this](int key) { return isDown(window_, key); }, seconds);
}

}  // namespace enamel::viewer
