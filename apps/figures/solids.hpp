// A scene in three dimensions.
#pragma once

#include "canvas.hpp"

namespace enamel::figures {

/// Draws a scene. Its description, lengths in m:
///   camera: {eye: [x, y, z], focus: [x, y, z], height (of the view at the focus)}
///   rods: [{from, to, radius_mm, colour}], cones (apex first), balls: [{at, radius_mm, colour}]
///   faces: [{corners: [...], colour}], lines: [{from, to, colour, width}]
///   labels: [{at, text, colour, size, offset: [x, y] in pixels}]
/// Throws Error or Json::exception: a description that cannot be drawn.
void addSolids(Canvas& canvas, const Json& scene);

}  // namespace enamel::figures
