#define GLFW_INCLUDE_NONE
#include "actions.hpp"

#include <GLFW/glfw3.h>

namespace enamel::viewer {

const std::vector<ActionRow>& actionRows() {
  static const std::vector<ActionRow> rows{
      {Action::swapRenderers, "swap", "Tab", "swap with the previous renderer", GLFW_KEY_TAB, false, Source::live},
      {Action::split, "split", "V", "split screen: two renderers, one hand", GLFW_KEY_V, false, Source::live},
      {Action::tour, "tour", "T", "tour of the split screen, 20 s", GLFW_KEY_T, false, Source::live},
      {Action::testPush, "push", "P", "test push: a step of 12 N on the surface", GLFW_KEY_P, false, Source::live},
      {Action::grip, "grip", "G", "firm grip 400 N/m, or the paper's 40 N/m", GLFW_KEY_G, false, Source::live},
      {Action::home, "home", "H", "move the hand back to the start", GLFW_KEY_H, false, Source::live},
      {Action::reset, "reset", "Backspace", "reset settings, hand, teeth, time and view", GLFW_KEY_BACKSPACE, false},
      {Action::nextScene, "next-scene", "N", "next scene", GLFW_KEY_N, false, Source::live},
      {Action::undo, "undo", "Ctrl+Z", "undo the last stroke of the bur", GLFW_KEY_Z, true, Source::live},
      {Action::pause, "pause", "Space", "pause or continue", GLFW_KEY_SPACE, false, Source::timed},
      {Action::step, "step", "Right", "one tick (pauses first)", GLFW_KEY_RIGHT, false, Source::timed},
      {Action::stepBack, "step-back", "Left", "one tick back", GLFW_KEY_LEFT, false, Source::recording},
      {Action::nextEvent, "next-event", "Ctrl+Right", "go to the next contact or guard event", GLFW_KEY_RIGHT, true,
       Source::recording},
      {Action::previousEvent, "previous-event", "Ctrl+Left", "go to the previous one", GLFW_KEY_LEFT, true,
       Source::recording},
      {Action::record, "record", "Ctrl+R", "start or stop recording every tick", GLFW_KEY_R, true, Source::live},
      {Action::clip, "clip", "Ctrl+M", "start or stop a clip (PNGs, MP4)", GLFW_KEY_M, true},
      {Action::faster, "faster", "+", "faster; a run up to real time", GLFW_KEY_EQUAL, false, Source::timed},
      {Action::slower, "slower", "-", "slower; a run down to 1:1000", GLFW_KEY_MINUS, false, Source::timed},
      {Action::cameraField, "camera-field", "1", "view: operating field", GLFW_KEY_1, false},
      {Action::cameraDevice, "camera-device", "2", "view: whole device", GLFW_KEY_2, false},
      {Action::cameraSide, "camera-side", "3", "view: side", GLFW_KEY_3, false},
      {Action::cameraTop, "camera-top", "4", "view: top", GLFW_KEY_4, false},
      {Action::follow, "follow", "5", "view: follow the contact, on or off", GLFW_KEY_5, false},
      {Action::nextCamera, "next-camera", "]", "next view", GLFW_KEY_RIGHT_BRACKET, false},
      {Action::previousCamera, "previous-camera", "[", "previous view", GLFW_KEY_LEFT_BRACKET, false},
      {Action::turnX, "turn-x", "X", "turn a scan by 90 deg about x", GLFW_KEY_X, false, Source::live},
      {Action::turnY, "turn-y", "Y", "turn a scan about y", GLFW_KEY_Y, false, Source::live},
      {Action::turnZ, "turn-z", "Z", "turn a scan about z", GLFW_KEY_Z, false, Source::live},
      {Action::scanUnit, "scan-unit", "U", "next unit of a scan: mm, m, um", GLFW_KEY_U, false, Source::live},
      {Action::saveScene, "save-scene", "Ctrl+S", "save a scan as a scene file", GLFW_KEY_S, true, Source::live},
      {Action::saveSolids, "save-solid", "Ctrl+D", "save the drilled solids (.solid)", GLFW_KEY_D, true},
      {Action::cutAway, "cut-away", "C", "cut a solid open at the tool", GLFW_KEY_C, false},
      {Action::sound, "sound", "M", "sound of the bur, on or off", GLFW_KEY_M, false, Source::live},
      {Action::help, "help", "F1", "this help", GLFW_KEY_F1, false},
      {Action::panels, "panels", "F2", "panels", GLFW_KEY_F2, false},
      {Action::timing, "timing", "F3", "timing of the loop, guard events", GLFW_KEY_F3, false},
      {Action::charts, "charts", "F4", "charts", GLFW_KEY_F4, false},
      {Action::fullScreen, "full-screen", "F5", "full screen", GLFW_KEY_F5, false},
      {Action::screenshot, "screenshot", "Ctrl+P", "save a PNG in the working folder", GLFW_KEY_P, true},
      {Action::cancel, "cancel", "Esc", "close what is open", GLFW_KEY_ESCAPE, false},
      {Action::quit, "quit", "Ctrl+Q", "end the viewer", GLFW_KEY_Q, true},
  };
  return rows;
}

const std::vector<HelpRow>& drivingRows() {
  static const std::vector<HelpRow> rows{
      {"Drag the tool", "move the hand across the view", Source::live},
      {"Shift+drag", "move the hand along the nearest wall", Source::live},
      {"E, Q, held", "press or lift (also Ctrl+wheel)", Source::live},
      {"A D W S", "move the hand left, right, up, down", Source::live},
      {"F, held", "pedal: the bur spins and drills", Source::live},
      {"Drag the bar", "go to any time", Source::recording},
      {"Drag beside it", "turn the view (also right drag)"},
      {"Middle drag", "shift the view"},
      {"Wheel", "zoom at the cursor"},
  };
  return rows;
}

const ActionRow* actionOfKey(int key, bool control) {
  if (key == GLFW_KEY_KP_ADD) key = GLFW_KEY_EQUAL;
  if (key == GLFW_KEY_KP_SUBTRACT) key = GLFW_KEY_MINUS;
  for (const ActionRow& row : actionRows())
    if (row.key == key && row.control == control) return &row;
  return nullptr;
}

const ActionRow* actionOfName(std::string_view name) {
  for (const ActionRow& row : actionRows())
    if (name == row.name) return &row;
  return nullptr;
}

}  // namespace enamel::viewer
