// The device in the computer: a mechanism's dynamics between ticks, motors with limits and delay, encoders.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "enamel/device/haptic_device.hpp"
#include "enamel/sim/plant.hpp"
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

/// Encoders with the memory of the rate filter; plain data.
class Encoders {
 public:
  /// `encoderStep`: of each joint, rad or m; `period` of the ticks, s.
  Encoders(const EncoderOptions& options, const JointVector& encoderStep, double period) noexcept;

  /// Measures exact coordinates and rates; the first call starts the rate filter at rest. Realtime: yes.
  void measure(const JointVector& q, const JointVector& rates, Measurement& measurement) noexcept;

 private:
  EncoderOptions options_;
  JointVector encoderStep_;
  double period_;  // s
  double gain_;    // of the low pass
  bool started_ = false;
  JointVector last_, filtered_;
};

/// Motors behind a delay line; plain data.
class Motors {
 public:
  /// `initial`: the torque before the first command, N m or N.
  Motors(const Delay& delay, const JointVector& initial) noexcept;

  /// Takes the command of tick `tick` (0, 1, 2, ...) and returns the torque that acts during this tick. Realtime: yes.
  JointVector actuate(std::uint64_t tick, const JointVector& command, const RandomStream& random) noexcept;

 private:
  Delay delay_;
  JointVector initial_;
  std::array<JointVector, kMaxDelay + 1> commands_;
};

/// What determines a virtual device.
struct VirtualDeviceSetup {
  Pose start;  ///< at rest
  EncoderOptions encoders;
  Delay delay;
  double period = 1e-3;  ///< Ts, s
  int substeps = 1;      ///< integration steps a tick
  Integrator integrator = Integrator::rungeKutta4;
  double jitter = 0.0;       ///< each tick is late by a uniform share of the period up to this, in 0 to 1
  double lostSamples = 0.0;  ///< share of the ticks at which measure() is stale, in 0 to 0.5; never the first
  std::uint64_t seed = 1;
  std::uint32_t run = 0;  ///< number of the random stream
};

/// Checks a setup. Throws Error: substeps outside 1 to 1000; a period outside 1e-5 to 0.1 s; delays outside 0 to
/// kMaxDelay ticks or low > high; jitter or lost samples outside their range; a cutoff that is not positive; a start
/// pose that is not finite or no rotation. Realtime: no.
void checkVirtualDevice(const VirtualDeviceSetup& setup);

/// A device that lives in steps of one period: measure(), actuate(), advance(), and again. It tells the torque that
/// acted. Refers to the mechanism.
class VirtualDevice final : public HapticDevice {
 public:
  /// Throws Error: as checkVirtualDevice(), or the start pose is not reachable. Realtime: no.
  VirtualDevice(const Mechanism& mechanism, const VirtualDeviceSetup& setup);

  /// The same with another plant than the closed form; the setup's substeps and integrator are not used. Also throws
  /// Error: there is no plant.
  VirtualDevice(std::unique_ptr<Plant> plant, const VirtualDeviceSetup& setup);

  /// At rest at a pose at tick 0 again, as after construction. Statuses of Plant::start(); it then stays where it is.
  /// Realtime: as the plant's.
  [[nodiscard]] Status restart(const Pose& start);

  /// ok; stale where the sample was lost; or the status of the configuration that the mechanism could not leave.
  /// Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;
  /// Always ok. Realtime: yes.
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// Moves on by one period under a load, or under `before` until `instant` (s after the tick's begin, in 0 to the
  /// period) and `after` from then on. Statuses of Plant::advance(); it then stays where it is. Realtime: yes, if plant
  /// and loads are.
  [[nodiscard]] Status advance(const ExternalWrench& load) noexcept;
  [[nodiscard]] Status advance(const ExternalWrench& before, double instant, const ExternalWrench& after) noexcept;

  /// Number and time (s) of the tick that comes next or is under way. Realtime: yes.
  std::uint64_t tick() const noexcept { return tick_; }
  double time() const noexcept { return timeOf(tick_); }

  const Plant& plant() const noexcept { return *plant_; }

  /// The truth: the state now; kinematics at the last measure(); torque that acts during the tick under way. Realtime:
  /// yes.
  const DeviceState& state() const noexcept { return plant_->state(); }
  const Kinematics& kinematics() const noexcept { return kinematics_; }
  const JointVector& torque() const noexcept { return torque_; }

 private:
  double timeOf(std::uint64_t tick) const noexcept;
  double duration() const noexcept;  // of the tick under way, s

  VirtualDeviceSetup setup_;
  std::unique_ptr<Plant> plant_;
  RandomStream random_;
  Kinematics kinematics_;
  Encoders encoders_;
  Motors motors_;
  JointVector torque_;
  std::uint64_t tick_ = 0;
};

}  // namespace enamel
