// All actions of keys, buttons and scripts.
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
  cameraField,
  cameraDevice,
  cameraSide,
  cameraTop,
  follow,
  nextCamera,
  previousCamera,
  turnX,
  turnY,
  turnZ,
  scanUnit,
  saveScene,
  saveSolids,
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

/// Where an action applies: everywhere (`both`), to a simulated run, to a recording, or to these two (`timed`), whose
/// time the viewer controls. A connected device has only `both`.
enum class Source : std::uint8_t { both, live, recording, timed };

/// A row of the help, of the key bindings and of the script's vocabulary.
struct ActionRow {
  Action action;
  const char* name;  ///< name in scripts
  const char* keys;  ///< text in the help
  const char* meaning;
  int key;       ///< key code of GLFW
  bool control;  ///< with Ctrl
  Source source = Source::both;
};

/// Return the rows in the order of Action.
const std::vector<ActionRow>& actionRows();

/// A row of the help that is not a single action.
struct HelpRow {
  const char* keys;
  const char* meaning;
  Source source = Source::both;
};
const std::vector<HelpRow>& drivingRows();

/// Return the action of a key, or of a name in a script; nullptr if nothing matches.
const ActionRow* actionOfKey(int key, bool control);
const ActionRow* actionOfName(std::string_view name);

}  // namespace enamel::viewer
