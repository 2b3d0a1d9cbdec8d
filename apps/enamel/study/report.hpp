// report.html: the study as one self-contained file.
#pragma once

#include "study/figures.hpp"

namespace enamel::app {

// report_terms.cpp: the procedure and the terms; report_tables.cpp: every metric.
void addTerms(Page& page, const Study& study);
void addMeasures(Page& page, const Study& study, const Findings& findings);

std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures);

}  // namespace enamel::app
