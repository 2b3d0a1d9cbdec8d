// The overlay that Dear ImGui draws over the scene: panels, numbers, the magnified contact, the stiffness gauge, help.
#pragma once

#include <string>

#include "overlay_input.hpp"

namespace enamel::viewer {

/// Load the font at a scale; call it again when the scale changes. `font`: a TrueType file, or empty for the built-in
/// font.
void setUpOverlay(const std::string& font, const std::string& boldFont, float scale);

/// Draw everything into the current ImGui frame.
void drawOverlay(const Layout& layout, const OverlayInput& input, OverlayState& state);

}  // namespace enamel::viewer
