// Shared by the files of compare.html.
#pragma once

#include "compare/page.hpp"
#include "study/page.hpp"

namespace enamel::app {

inline constexpr double kTooDeep = 1e-3;  ///< m: limit of the paper's Table II

inline double meanOf(const std::vector<double>& values) { return spreadOf(values).mean; }

/// Return "lost" for an infinite value.
std::string scoreText(double value);

/// Return true for hold and position control, which the paper's comparison sets against its spring.
bool isPositionBased(ColumnKind kind);

/// Add the paper's claims with their verdicts, and a table in the form of its Table III.
void addPaper(Page& page, const std::vector<Condition>& conditions);

}  // namespace enamel::app
