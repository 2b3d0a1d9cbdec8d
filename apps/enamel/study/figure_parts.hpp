// What the files of figures share, and the figures that each draws.
#pragma once

#include "study/figures.hpp"
#include "study/svg.hpp"

namespace enamel::app {

/// Of a renderer in every figure.
std::string colourOf(const Study& study, std::size_t column);

std::string join(const std::vector<std::string>& parts, const std::string& between);

/// Ends of the wall along x and y, mm.
inline double edgeOf(const Study& study) { return 1e3 * study.plan.halfWidth; }

// push_figures.cpp: the device and what pushes do.
Figure deviceFigure(const Study& study);
Figure responseFigure(const Study& study, int scenario);
Figure torqueFigure(const Study& study);

// wall_figures.cpp: how figures run over the wall.
Figure firstImpactMap(const Study& study, const Findings& findings);
Figure steadyMap(const Study& study, const Findings& findings, int scenario);
Figure alongYFigure(const Study& study, const Findings& findings);

}  // namespace enamel::app
