// Widgets of the panel. Each one notes its position and has a tip for the mouse.
#pragma once

#include <initializer_list>
#include <string>

#include "brush.hpp"
#include "overlay_input.hpp"

namespace enamel::viewer {

/// Show a tip when the mouse has rested on an item. A formula has its own line.
void showTip(OverlayState& state, const char* text);
/// Show the tip of the last item while the mouse is on it.
void tip(OverlayState& state, const char* text);
/// Note the position of the last item for the report.
void note(OverlayState& state, const std::string& name);

void heading(const char* text);
void remark(const std::string& text, unsigned rgb = kMuted);
void label(const char* name);

/// Display and range of a value. `factor`: shown unit per SI unit.
struct SliderRow {
  const char *name, *pattern, *unit;
  double low, high;
  const char* about;
  double factor = 1.0;
};
/// Draw a slider with its name above and its value, which can be typed after a click. Return true when a change is
/// complete.
bool slider(OverlayState& state, double& value, const SliderRow& row);

/// Draw a button that is on or off. Return true when it is pressed.
bool toggle(const char* name, bool on, float width, unsigned colour = kChosen);

/// Draw a row of buttons; `chosen` is on. Return the pressed one, or -1.
int choice(OverlayState& state, const char* const* names, int count, int chosen, float width, const char* about);

/// A button in a row of equal width that requests an action; `about` may be nullptr.
struct ActionButton {
  std::string name;
  bool on;
  Action action;
  const char* about = nullptr;
};
void actionButtons(OverlayState& state, std::initializer_list<ActionButton> buttons, float scale, float width);

}  // namespace enamel::viewer
