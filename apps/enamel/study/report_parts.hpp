// What the files of report.html share, and the sections that they add.
#pragma once

#include "study/figures.hpp"
#include "study/page.hpp"

namespace enamel::app {

/// Of one scenario and a linked renderer; nullptr where the study does not have it.
const WallSummary* wallOf(const Study& study, const Findings& findings, int scenario, ColumnKind kind);

const PointStatistics& pointOf(const Findings& findings, const WallSummary& wall, std::size_t point);

/// A share to three digits.
std::string percent(double share);

// report_terms.cpp: what was done, and what the words mean.
void addTerms(Page& page, const Study& study);

// report_tables.cpp: the paper's Table IV, and more measures.
void addTableFour(Page& page, const Study& study, const Findings& findings);
void addMeasures(Page& page, const Study& study, const Findings& findings);

// report_differences.cpp: where this device differs from the paper's, and why.
void addDifferences(Page& page, const Study& study, const Findings& findings);

}  // namespace enamel::app
