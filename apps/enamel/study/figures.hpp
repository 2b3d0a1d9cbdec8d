// The figures of the report.
#pragma once

#include <optional>

#include "enamel/control/impedance_map.hpp"
#include "enamel/study/paired.hpp"
#include "study/convergence.hpp"
#include "study/plot.hpp"
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

}  // namespace enamel::app
