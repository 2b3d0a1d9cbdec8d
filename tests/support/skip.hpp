// Reports that a test cannot run here: `return skipTest("Xvfb is missing");`.
#pragma once

#include <string>

namespace enamel::test {

/// Print the reason. If nothing fails, the runner ends with status 4, which ctest reports as skipped.
void skipTest(const std::string& reason);

}  // namespace enamel::test
