// Text of error messages. Private to the library.
#pragma once

#include <string>

#include "enamel/core/error.hpp"

namespace enamel {

/// A number as it should stand in a message (shortest form that is exact).
std::string formatNumber(double value);

/// Throws Error(message) unless the condition holds.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw Error(message);
}

/// Throws Error unless `period` is one that ticks can have, 1e-5 to 0.1 s; `who` begins the message.
void requirePeriod(double period, const std::string& who);

}  // namespace enamel
