#include "enamel/sim/random.hpp"

#include <cmath>

namespace enamel {
namespace {

double toUnit(std::uint32_t high, std::uint32_t low) noexcept {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32) | low;
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

}  // namespace

RandomStream::Block RandomStream::block(Purpose purpose, std::uint64_t index) const noexcept {
  Block c{{static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32), stream_,
           static_cast<std::uint32_t>(purpose)}};
  std::uint32_t key0 = static_cast<std::uint32_t>(seed_), key1 = static_cast<std::uint32_t>(seed_ >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = std::uint64_t{0xD2511F53} * c.word[0];
    const std::uint64_t product1 = std::uint64_t{0xCD9E8D57} * c.word[2];
    c = {{static_cast<std::uint32_t>(product1 >> 32) ^ c.word[1] ^ key0, static_cast<std::uint32_t>(product1),
          static_cast<std::uint32_t>(product0 >> 32) ^ c.word[3] ^ key1, static_cast<std::uint32_t>(product0)}};
    key0 += 0x9E3779B9;
    key1 += 0xBB67AE85;
  }
  return c;
}

double RandomStream::uniform(Purpose purpose, std::uint64_t index) const noexcept {
  const Block b = block(purpose, index);
  return toUnit(b.word[0], b.word[1]);
}

double RandomStream::normal(Purpose purpose, std::uint64_t index) const noexcept {
  const Block b = block(purpose, index);
  const double radius = std::sqrt(-2.0 * std::log(1.0 - toUnit(b.word[0], b.word[1])));
  return radius * std::cos(2.0 * M_PI * toUnit(b.word[2], b.word[3]));
}

}  // namespace enamel
