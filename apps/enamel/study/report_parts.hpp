// Shared by the files of report.html: helpers, and the sections that each file adds.
#pragma once

#include "study/figures.hpp"
#include "study/page.hpp"

namespace enamel::app {

/// Return the summary of a scenario and a linked renderer; nullptr if the study does not have it.
const WallSummary* wallOf(const Study& study, const Findings& findings, int scenario, ColumnKind kind);

const PointStatistics& pointOf(const Findings& findings, const WallSummary& wall, std::size_t point);

/// Format a fraction as a percentage with three digits.
std::string percent(double share);

// report_terms.cpp: the procedure and the terms.
void addTerms(Page& page, const Study& study);

// report_tables.cpp: the paper's Table IV, and further metrics.
void addTableFour(Page& page, const Study& study, const Findings& findings);
void addMeasures(Page& page, const Study& study, const Findings& findings);

// report_differences.cpp: differences between this device and the paper's, with reasons.
void addDifferences(Page& page, const Study& study, const Findings& findings);

}  // namespace enamel::app
