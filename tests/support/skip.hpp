// A test that cannot run here says so: `return skipTest("Xvfb is missing");`.
#pragma once

#include <string>

namespace enamel::test {

/// Prints the reason; where nothing fails, the runner ends with status 4, which ctest calls skipped.
void skipTest(const std::string& reason);

}  // namespace enamel::test
