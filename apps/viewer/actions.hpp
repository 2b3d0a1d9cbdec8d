// Everything that a key, a button or a script can do.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace enamel::viewer {

enum class Action : std::uint8_t {
  swapRenderers,
  split,
  tour,
  testPush,
  grip,
  home,
  reset,
  nextScene,
  undo,
  pause,
  step,
  stepBack,
  nextEvent,
  previousEvent,
  record,
  clip,
  faster,
  slower,
  camera1,
  camera2,
  camera3,
  camera4,
  follow,
  nextCamera,
  previousCamera,
  cutAway,
  sound,
  help,
  panels,
  timing,
  charts,
  fullScreen,
  screenshot,
  cancel,
  quit,
};

/// What an action is for: a live run, a recording that is played, or both.
enum class Source : std::uint8_t { both, live, recording };

/// A row of the help, of the key bindings and of the script's vocabulary.
struct ActionRow {
  Action action;
  const char* name;  ///< in scripts
  const char* keys;  ///< as the help shows them
  const char* meaning;
  int key;       ///< GLFW's number
  bool control;  ///< with Ctrl
  Source source = Source::both;
};

/// In the order of Action.
const std::vector<ActionRow>& actionRows();

/// The rows of the help that are not single actions.
struct HelpRow {
  const char* keys;
  const char* meaning;
  Source source = Source::both;
};
const std::vector<HelpRow>& drivingRows();

/// The action bound to a key, or of a name in a script; or nullptr.
const ActionRow* actionOfKey(int key, bool control);
const ActionRow* actionOfName(std::string_view name);

}  // namespace enamel::viewer
