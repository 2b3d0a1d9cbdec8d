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

/// Return an entry of a legend: a line, or a filled square.
Json entry(const std::string& name, const Style& style, bool filled = false);

}  // namespace enamel::app
