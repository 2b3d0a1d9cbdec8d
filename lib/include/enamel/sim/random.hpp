// A counter-based random stream: the value at (seed, stream, index, purpose) is a pure function, so a run's numbers do
// not depend on which other numbers were drawn, or in which thread.
#pragma once

#include <cstdint>

namespace enamel {

/// Random numbers of one run. Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as
/// 1, 2, 3"): key = seed, counter = (index, stream, purpose).
class RandomStream {
 public:
  /// What a number is for; numbers for different purposes are independent.
  enum class Purpose : std::uint32_t { force, noise, delay, test, instant, build, encoder, jitter, loss };

  RandomStream(std::uint64_t seed, std::uint32_t stream) noexcept : seed_(seed), stream_(stream) {}

  /// Uniform in [0, 1), 53 bits. Realtime: yes.
  double uniform(Purpose purpose, std::uint64_t index) const noexcept;

  /// Standard normal (Box and Muller 1958). Realtime: yes.
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
