// One chart of a figure.
#pragma once

#include "canvas.hpp"

namespace enamel::figures {

/// Adds a chart. Its description:
///   place: [x, y, width, height] of the area inside the axes; title (optional)
///   x, y: {title, range: [low, high], ticks: [places], labels: [texts], side: "right" (y of a colour bar: no axes)}
///   curves: [{x: [...], y: [...], colour, width, dash: true, marks: true (points instead of a line)}]
///   cells: {x: [first edge, step], y: [first edge, step], columns, values: [row by row, null: no value],
///           scale: [low, high], palette: "viridis" or a list of colours (the value is then an index)}
///   legend: {corner: "top right", ... or "above" (in a row), lift: how far above, entries: [{name, colour, dash,
///   box}]}
/// Throws Error or Json::exception: a description that cannot be drawn.
void addPanel(Canvas& canvas, const Json& panel);

}  // namespace enamel::figures
