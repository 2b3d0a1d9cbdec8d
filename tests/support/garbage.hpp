// Invalid numbers.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "support/devices.hpp"

namespace enamel::test {

/// Return an ordinary number, an extreme one, or any bit pattern.
double garbage(Random& random);

}  // namespace enamel::test
