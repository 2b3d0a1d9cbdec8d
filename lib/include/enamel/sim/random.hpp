// A counter-based random stream. The number at (seed, stream, index, purpose) is a pure function of these. A run's
// numbers therefore do not depend on other draws or on threads.
#pragma once

#include <cstdint>

namespace enamel {

/// Random numbers of one run. Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1,
/// 2, 3"): key = seed, counter = (index, stream, purpose).
class RandomStream {
 public:
  /// Use of a number. Numbers for different purposes are independent.
  enum class Purpose : std::uint32_t { force, noise, delay, test, instant, build, encoder, jitter, loss };

  RandomStream(std::uint64_t seed, std::uint32_t stream) noexcept : seed_(seed), stream_(stream) {}

  /// Return a number uniform in [0, 1), with 53 bits. Realtime: yes.
  double uniform(Purpose purpose, std::uint64_t index) const noexcept;

  /// Return a standard normal number (Box and Muller 1958). Realtime: yes.
  double normal(Purpose purpose, std::uint64_t index) const noexcept;

 private:
  struct Block {
    std::uint32_t word[4];
  };
  Block block(Purpose purpose, std::uint64_t index) const noexcept;

  std::uint64_t seed_;
  std::uint32_t stream_;
};

}  // namespace enamel
