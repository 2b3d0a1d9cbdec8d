// The report of an identification: a page of HTML.
#pragma once

#include <string>
#include <vector>

#include "enamel/identify/identify.hpp"
#include "enamel/study/expectation.hpp"

namespace enamel::app {

/// Return the page. `files`: device file and recordings. `expected`: the walls of the identified device, or empty.
std::string identificationReport(const Identification& result, const std::vector<std::string>& files,
                                 const std::vector<WallExpectation>& expected);

}  // namespace enamel::app
