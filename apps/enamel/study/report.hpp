// report.html: the study as one self-contained file.
#pragma once

#include "study/figures.hpp"

namespace enamel::app {

std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures);

}  // namespace enamel::app
