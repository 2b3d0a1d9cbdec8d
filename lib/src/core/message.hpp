// Text of error messages. Private to the library.
#pragma once

#include <string>

#include "enamel/core/error.hpp"

namespace enamel {

/// Return a number in the shortest form that is exact.
std::string formatNumber(double value);

/// Throw Error(message) unless the condition holds.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw Error(message);
}

/// Throw Error unless `period` is valid for ticks, 1e-5 to 0.1 s. `who` begins the message.
void requirePeriod(double period, const std::string& who);

}  // namespace enamel
