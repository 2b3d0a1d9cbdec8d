// report.html: the study in one file that needs nothing else.
#pragma once

#include "study/figures.hpp"

namespace enamel::app {

/// The report. Figures are read from `folder` as NAME.png; `withoutFigures` says why there are none, or is empty.
std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures,
                     const std::string& folder, const std::string& withoutFigures);

}  // namespace enamel::app
