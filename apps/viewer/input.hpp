// Meaning of keys and mouse, independent of any window: events in, calls of an InputTarget out.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "actions.hpp"
#include "camera.hpp"
#include "layout.hpp"

namespace enamel::viewer {

/// The object that a person controls.
class InputTarget {
 public:
  virtual ~InputTarget() = default;
  virtual void act(Action action) = 0;
  virtual void moveHandBy(const glm::dvec3& millimetres) = 0;
  virtual void pressBy(double newtons) = 0;                      ///< into the wall, along its normal
  virtual void spin(bool on) = 0;                                ///< switch the bur
  virtual void seek(double share) = 0;                           ///< in a recording, 0 to 1
  virtual void drop(const std::vector<std::string>& paths) = 0;  ///< files dropped on the window
  virtual Camera& camera() = 0;
  virtual const Layout& layout() const = 0;
  virtual glm::dvec3 tool() const = 0;    ///< TCP, mm
  virtual glm::dvec3 axis() const = 0;    ///< of the tool, away from its tip
  virtual glm::dvec3 normal() const = 0;  ///< of the nearest wall, outwards
};

/// Translates events. Keys, buttons and actions have GLFW's codes; places are pixels from the top left. The caller
/// keeps events for its panels to itself, but must always pass on a release of the mouse.
class Input {
 public:
  explicit Input(InputTarget& target) : target_(target) {}

  void key(int key, int action, int modifiers);
  void button(int button, int action, int modifiers = 0);
  void cursor(const glm::dvec2& place);
  void wheel(double notches, bool presses);
  void drop(const std::vector<std::string>& paths) { target_.drop(paths); }
  /// Process keys that act while they are down. `seconds`: since the last call.
  void hold(const std::function<bool(int key)>& isDown, double seconds);

 private:
  InputTarget& target_;
  glm::dvec2 cursor_{0.0};
  enum class Drag { none, hand, orbit, pan } drag_ = Drag::none;
  bool seeks_ = false;  // the drag began on the time bar
  bool along_ = false;  // the drag moves along the wall (Shift)
  bool pedal_ = false;
};

}  // namespace enamel::viewer
