// What the files of compare.html share.
#pragma once

#include "compare/page.hpp"
#include "study/page.hpp"

namespace enamel::app {

inline constexpr double kTooDeep = 1e-3;  ///< m: what the paper allows

/// A plant in words.
const std::string& plantTitle(const std::string& plant);

inline double meanOf(const std::vector<double>& values) { return spreadOf(values).mean; }

/// "lost" for what is infinite.
std::string scoreText(double value);

/// A probability; "–" where there is none.
std::string pText(double p);

/// Hold and position control: what the paper's comparison sets against its spring.
bool isPositionBased(ColumnKind kind);

/// The paper's claims, each with its verdict; the form of its Table III and Table IV.
void addPaper(Page& page, const std::vector<Condition>& conditions);

}  // namespace enamel::app
