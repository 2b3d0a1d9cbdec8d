// The figures of the report.
#pragma once

#include <optional>

#include "enamel/control/impedance_map.hpp"
#include "enamel/study/paired.hpp"
#include "study/convergence.hpp"
#include "study/page.hpp"
#include "study/study.hpp"

namespace enamel::app {

/// All results in the report besides the study itself.
struct Findings {
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<PairedComparison> pairs;  ///< reportQuestions() of referenceOf() and each other column
  std::vector<Claim> claims;
  std::optional<Convergence> convergence;
  bool whole = true;  ///< false: only the convergence
};

struct Figure {
  std::string name;
  Json plot;            ///< for page/figures.js
  std::string caption;  ///< HTML
};

/// Return the impedance column's plant as an impedance wall sees it. Without such a column, use the first column.
WallDevice wallDeviceOf(const Study& study);

std::vector<Figure> figuresOf(const Study& study, const Findings& findings);

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
