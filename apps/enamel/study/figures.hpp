// The figures of the report: what they show, for enamel-figures to draw.
#pragma once

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
  Convergence convergence;
  bool whole = true;  ///< false: the convergence alone
};

struct Figure {
  std::string name, caption;
  Json description;  ///< see apps/figures
};

std::vector<Figure> figuresOf(const Study& study, const Findings& findings);

/// Draws the figures as NAME.png in a folder with the program enamel-figures beside this one. Returns why there are no
/// figures, or nothing.
std::string drawFigures(const std::vector<Figure>& figures, const std::string& folder);

}  // namespace enamel::app
