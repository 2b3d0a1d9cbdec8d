// Figures as JSON: panels with axes and layers, which page/figures.js draws by Vega.
#pragma once

#include <string>
#include <vector>

#include "colours/palette.hpp"
#include "json_matrices.hpp"

namespace enamel::app {

/// Format a colour: "#0072b2".
std::string colourText(unsigned rgb);

/// Return values with five significant digits; null for those that are not finite.
Json numbers(const std::vector<double>& values);

/// Return an axis with its title, which has the unit. Its range is that of the layers.
Json axis(const std::string& title, bool logarithmic = false);
/// Return an axis with a fixed range.
Json axis(const std::string& title, double low, double high, bool logarithmic = false);

/// Colour, dashes and width of a line.
struct Style {
  unsigned colour = viewer::kInk;
  std::vector<int> dash = {};
  double width = 1.5;
};
inline Style dashed(unsigned colour) { return {colour, {6, 4}, 1.0}; }

/// Return a line of a panel; `x` is numbers() or {"from", "step"}.
Json line(const std::string& name, Json x, const std::vector<double>& y, const Style& style);
/// Return a horizontal line.
Json level(double y, const Style& style);

/// Return boxes of one group and series from its values; "texts", if set, has one text for each value.
Json boxOf(const std::string& group, const std::string& series, const Style& style, const std::vector<double>& values);

/// Return a rectangle of a layer "cells"; add "colour" or "value", and "text" for the mouse.
Json rectangle(double x0, double x1, double y0, double y1);

/// Return a panel of layers, with its size in pixels; and a figure of panels in columns.
Json panel(const std::string& title, double width, double height, Json x, Json y, Json layers);
Json figure(const std::string& label, int columns, Json legend, Json panels);

/// Return an entry of a legend: a line, or a filled square.
Json entry(const std::string& name, const Style& style, bool filled = false);

}  // namespace enamel::app
