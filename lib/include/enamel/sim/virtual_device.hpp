// The device in the computer: closed-form dynamics between ticks, motors with limits and delay, encoders.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/sim/integrator.hpp"
#include "enamel/sim/random.hpp"

namespace enamel {

/// Delay between a tick's torque and the motors, in ticks. The torque computed at tick j acts from tick j + d; with
/// low < high each tick draws its own d uniformly, and the motors get what was computed at tick j - d, so commands may
/// repeat or be skipped. Before the first command the motors balance gravity at the start pose.
struct Delay {
  int low = 0;
  int high = 0;
};

/// Largest delay, ticks.
inline constexpr int kMaxDelay = 63;

/// Where the joint rates come from.
enum class RateSource : std::uint8_t {
  exact,       ///< the plant's own
  difference,  ///< backward difference of the encoder angles over one tick
  lowPass,     ///< the difference through a first-order low pass: r += (1 - e^{-2 pi f Ts}) (difference - r)
};

/// Encoders: exact, or rounded to the nearest count.
struct EncoderOptions {
  bool quantised = false;
  RateSource rates = RateSource::exact;
  double cutoff = 100.0;  ///< f of lowPass, Hz
};

/// What the encoders deliver at a tick.
struct Measurement {
  Vec6 q;      ///< rad
  Vec6 rates;  ///< rad/s
};

/// Encoders with the memory of the rate filter; plain data.
class Encoders {
 public:
  /// `counts` per joint revolution; `period` of the ticks, s.
  Encoders(const EncoderOptions& options, double counts, double period) noexcept;

  /// Measures exact angles and rates; the first call starts the rate filter at rest. Realtime: yes.
  Measurement measure(const Vec6& q, const Vec6& rates) noexcept;

 private:
  EncoderOptions options_;
  double count_;   // rad
  double period_;  // s
  double gain_;    // of the low pass
  bool started_ = false;
  Vec6 last_ = Vec6::Zero(), filtered_ = Vec6::Zero();
};

/// Motors behind a delay line; plain data.
class Motors {
 public:
  /// `initial`: the torque before the first command, N m.
  Motors(const Delay& delay, const Vec6& initial) noexcept;

  /// Takes the command of tick `tick` (0, 1, 2, ...) and returns the torque that acts during this tick. Realtime: yes.
  Vec6 actuate(std::uint64_t tick, const Vec6& command, const RandomStream& random) noexcept;

 private:
  Delay delay_;
  Vec6 initial_;
  std::array<Vec6, kMaxDelay + 1> commands_;
};

}  // namespace enamel
