// Shared by the files of figures: helpers, and the figures that each file draws.
#pragma once

#include "study/figures.hpp"
#include "study/svg.hpp"

namespace enamel::app {

/// Return the colour of a renderer, the same in every figure.
std::string colourOf(const Study& study, std::size_t column);

std::string join(const std::vector<std::string>& parts, const std::string& between);

/// Return the half width of the wall along x and y, mm.
inline double edgeOf(const Study& study) { return 1e3 * study.plan.halfWidth; }

// push_figures.cpp: the device, and responses to pushes.
Figure deviceFigure(const Study& study);
Figure responseFigure(const Study& study, int scenario);
Figure torqueFigure(const Study& study);

// wall_figures.cpp: values over the wall.
Figure firstImpactMap(const Study& study, const Findings& findings);
Figure steadyMap(const Study& study, const Findings& findings, int scenario);
Figure alongYFigure(const Study& study, const Findings& findings);

}  // namespace enamel::app
