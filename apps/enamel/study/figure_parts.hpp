// Shared by the files of figures: helpers, and the figures that each file makes.
#pragma once

#include "study/figures.hpp"
#include "study/page.hpp"

namespace enamel::app {

std::string join(const std::vector<std::string>& parts, const std::string& between);

/// Return the half width of the wall along x and y, mm.
inline double edgeOf(const Study& study) { return 1e3 * study.plan.halfWidth; }

/// Return a legend of all renderers.
Json legendOf(const Study& study, bool filled = false);

// push_figures.cpp: the device, and responses to pushes.
Figure deviceFigure(const Study& study);
Figure responseFigure(const Study& study, int scenario);
Figure torqueFigure(const Study& study);

// wall_figures.cpp: values over the wall.
Figure stiffnessBoxes(const Study& study, const Findings& findings);
Figure firstImpactMap(const Study& study, const Findings& findings);
Figure steadyMap(const Study& study, const Findings& findings, int scenario);

}  // namespace enamel::app
