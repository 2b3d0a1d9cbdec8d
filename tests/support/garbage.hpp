// Numbers that nobody should send.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "support/devices.hpp"

namespace enamel::test {

/// An ordinary number, or an extreme one, or any bit pattern.
double garbage(Random& random);

}  // namespace enamel::test
