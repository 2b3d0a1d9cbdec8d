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

}  // namespace enamel
