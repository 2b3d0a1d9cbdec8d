// Texts and legends over a figure, placed to the pixel.
#pragma once

#include "canvas.hpp"

namespace enamel::figures {

/// A text: {x, y (baseline), text, size, colour, align: "left", "centre", "right", turned: true (reads upwards)}.
void addText(Canvas& canvas, const Json& text);

/// A legend inside `place` ([x, y, width, height]), or in a row over it: see addPanel().
void addLegend(Canvas& canvas, const Json& legend, const Json& place);

}  // namespace enamel::figures
