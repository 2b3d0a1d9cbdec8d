// The figures of the report: what they show, for enamel-figures to draw.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "enamel/control/impedance_map.hpp"
#include "study/convergence.hpp"
#include "study/study.hpp"
#include "study/survey.hpp"

namespace enamel::app {

using Json = nlohmann::ordered_json;

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
  std::string name, caption;
  Json description;  ///< see apps/figures
};

/// What D_z1 is.
inline constexpr const char* kFirstImpactText =
    "D<sub>z1</sub> is the deepest point of the continuous motion, between ticks too, up to its first return, from the "
    "mean depth in the 0.1 s before the step; K<sub>z1</sub> is the force then over D<sub>z1</sub>. A push that rings, "
    "slips or never returns has none.";

/// The plant of the impedance column as its wall feels it; of the first column where there is none.
WallDevice wallDeviceOf(const Study& study);

std::vector<Figure> figuresOf(const Study& study, const Findings& findings);

/// Why enamel-figures, beside this program, cannot draw; or nothing.
std::string missingProgram();

/// Draws the figures as NAME.png in a folder with the program enamel-figures beside this one. Returns why there are no
/// figures, or nothing.
std::string drawFigures(const std::vector<Figure>& figures, const std::string& folder);

}  // namespace enamel::app
