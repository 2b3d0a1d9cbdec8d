// The widgets of the panel: each notes where it is and has a tip for the mouse.
#pragma once

#include <initializer_list>
#include <string>

#include "brush.hpp"
#include "overlay_input.hpp"

namespace enamel::viewer {

/// A tip for what the mouse is on, once it has stayed there. A formula is a line of its own.
void showTip(OverlayState& state, const char* text);
/// What the last item is for, while the mouse is on it.
void tip(OverlayState& state, const char* text);
/// Notes where the last item is, for the report.
void note(OverlayState& state, const std::string& name);

void heading(const char* text);
void remark(const std::string& text, unsigned rgb = kMuted);
void label(const char* name);

/// How a value is shown and set. `factor`: shown unit per SI unit.
struct SliderRow {
  const char *name, *pattern, *unit;
  double low, high;
  const char* about;
  double factor = 1.0;
};
/// A slider with its name above, and its value, which a click lets one type; true when a change is complete.
bool slider(OverlayState& state, double& value, const SliderRow& row);

/// A button that is on or off; true when it is pressed.
bool toggle(const char* name, bool on, float width, unsigned colour = kChosen);

/// A row of buttons of which one is on; the one that was pressed, or -1.
int choice(OverlayState& state, const char* const* names, int count, int chosen, float width, const char* about);

/// Buttons of equal width in a row that ask for actions; `about`: or nullptr.
struct ActionButton {
  std::string name;
  bool on;
  Action action;
  const char* about = nullptr;
};
void actionButtons(OverlayState& state, std::initializer_list<ActionButton> buttons, float scale, float width);

}  // namespace enamel::viewer
