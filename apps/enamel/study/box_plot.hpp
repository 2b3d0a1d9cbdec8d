// Box plots as SVG.
#pragma once

#include <string>
#include <vector>

#include "study/svg.hpp"

namespace enamel::app {

struct BoxPlot {
  std::string yLabel;               ///< with its unit
  std::vector<std::string> groups;  ///< along x
  std::vector<std::string> series;  ///< a colour each
  /// values[group][series]; those that are not finite or not positive are left out.
  std::vector<std::vector<std::vector<double>>> values;
  double line = 0.0;  ///< drawn across, in the unit of y; 0: none
  Extent extent;      ///< what the axis reaches over at least
};

/// Median, quartiles, whiskers to the farthest value within 1.5 times their distance, everything beyond as points
/// (Tukey 1977), on a logarithmic axis; "none" where a box has no value.
std::string svgOf(const BoxPlot& plot);

}  // namespace enamel::app
