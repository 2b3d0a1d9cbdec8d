#include "support/garbage.hpp"

namespace enamel::test {

double garbage(Random& random) {
  const double kind = random.uniform(0.0, 1.0);
  if (kind < 0.3) return random.uniform(-3.0, 3.0);
  if (kind < 0.5) {
    const double share = random.uniform(-1.0, 1.0);
    return share * random.power(-320.0, 308.0);
  }
  if (kind < 0.6) return std::nan("");
  if (kind < 0.7) return random.uniform(0.0, 1.0) < 0.5 ? HUGE_VAL : -HUGE_VAL;
  const auto high = static_cast<std::uint64_t>(random.uniform(0.0, 0x1p32));
  const std::uint64_t bits = (high << 32) | static_cast<std::uint64_t>(random.uniform(0.0, 0x1p32));
  double value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

}  // namespace enamel::test
