// What Dear ImGui draws over the scene: panels, numbers, the magnified contact, the gauge of stiffness, help.
#pragma once

#include <string>

#include "overlay_input.hpp"

namespace enamel::viewer {

/// Loads the font at a scale; call again when the scale changes. `font`: a TrueType file, or empty for the built-in.
void setUpOverlay(const std::string& font, const std::string& boldFont, float scale);

/// Draws everything into the current ImGui frame.
void drawOverlay(const Layout& layout, const OverlayInput& input, OverlayState& state);

}  // namespace enamel::viewer
