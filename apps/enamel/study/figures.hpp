// The figures of the report.
#pragma once

#include <optional>

#include "enamel/control/impedance_map.hpp"
#include "study/convergence.hpp"
#include "study/study.hpp"
#include "study/survey.hpp"

namespace enamel::app {

/// Everything that the report tells, beside the study itself.
struct Findings {
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<Claim> claims;
  Survey survey;
  std::optional<Convergence> convergence;
  bool whole = true;  ///< false: the convergence alone
};

struct Figure {
  std::string name, svg;
  std::string caption;  ///< HTML
};

/// The plant of the impedance column as its wall feels it; of the first column without such a column.
WallDevice wallDeviceOf(const Study& study);

std::vector<Figure> figuresOf(const Study& study, const Findings& findings);

}  // namespace enamel::app
