// Box plots as SVG.
#pragma once

#include <string>
#include <vector>

#include "study/svg.hpp"

namespace enamel::app {

struct BoxPlot {
  std::string yLabel;               ///< with unit
  std::vector<std::string> groups;  ///< along x
  std::vector<std::string> series;  ///< one colour each
  /// values[group][series]; values that are not finite or not positive are left out.
  std::vector<std::vector<std::vector<double>>> values;
  double line = 0.0;  ///< horizontal line in the unit of y; 0: no line
  Extent extent;      ///< smallest range of the axis
};

/// Return a box plot on a logarithmic axis (Tukey 1977): median, quartiles, and whiskers to the farthest value within
/// 1.5 interquartile ranges. All other values are points. A box without values shows "none".
std::string svgOf(const BoxPlot& plot);

}  // namespace enamel::app
