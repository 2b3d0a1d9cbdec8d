#include "message.hpp"

#include <array>
#include <charconv>

namespace enamel {

std::string formatNumber(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return std::string(buffer.data(), result.ptr);
}

void requirePeriod(double period, const std::string& who) {
  require(period >= 1e-5 && period <= 0.1,
          who + "the period is " + formatNumber(period) + ", must be in 1e-05 to 0.1 s");
}

}  // namespace enamel
