// The sections of report.html, one file each.
#pragma once

#include "study/figures.hpp"
#include "study/page.hpp"

namespace enamel::app {

// report_terms.cpp: the procedure and the terms.
void addTerms(Page& page, const Study& study);

// report_tables.cpp: every metric.
void addMeasures(Page& page, const Study& study, const Findings& findings);

}  // namespace enamel::app
