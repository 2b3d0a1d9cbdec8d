// The virtual device: a mechanism's dynamics between ticks, motors with limits and delay, and encoders.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "enamel/device/haptic_device.hpp"
#include "enamel/sim/plant.hpp"
#include "enamel/sim/random.hpp"

namespace enamel {

/// Read "N" or "LOW..HIGH", whole ticks in decimal digits. Empty: the text has another form. Realtime: no.
std::optional<Delay> readDelay(std::string_view text) noexcept;

/// Write a delay as readDelay() reads it: "N" if it is constant, otherwise "LOW..HIGH". Realtime: no.
std::string toText(const Delay& delay);

/// Largest delay, ticks.
inline constexpr int kMaxDelay = 63;

/// Source of the joint rates.
enum class RateSource : std::uint8_t {
  exact,       ///< the plant's rates
  difference,  ///< backward difference of the encoder readings over one tick
  /// The difference through a first-order low pass: r += (1 - e^{-2 pi f Ts}) (difference - r).
  lowPass,
};

/// Options of encoders. Readings are exact, or rounded to the nearest count.
struct EncoderOptions {
  bool quantised = false;
  RateSource rates = RateSource::exact;
  double cutoff = 100.0;  ///< f of lowPass, Hz
};

/// Encoders with the state of the rate filter. Plain data.
class Encoders {
 public:
  /// `encoderStep` is the step of each joint, rad or m. `period` is that of the ticks, s.
  Encoders(const EncoderOptions& options, const JointVector& encoderStep, double period) noexcept;

  /// Measure exact coordinates and rates. The first call starts the rate filter at rest. Realtime: yes.
  void measure(const JointVector& q, const JointVector& rates, Measurement& measurement) noexcept;

 private:
  EncoderOptions options_;
  JointVector encoderStep_;
  double period_;  // s
  double gain_;    // gain of the low pass
  bool started_ = false;
  JointVector last_, filtered_;
};

/// Motors behind a delay line. Plain data.
class Motors {
 public:
  /// `initial` is the torque before the first command, N m or N.
  Motors(const Delay& delay, const JointVector& initial) noexcept;

  /// Take the command of tick `tick` (0, 1, 2, ...) and return the torque that acts during this tick. Realtime: yes.
  JointVector actuate(std::uint64_t tick, const JointVector& command, const RandomStream& random) noexcept;

 private:
  Delay delay_;
  JointVector initial_;
  std::array<JointVector, kMaxDelay + 1> commands_;
};

/// All data of a virtual device.
struct VirtualDeviceSetup {
  Pose start;  ///< the device starts at rest at this pose
  EncoderOptions encoders;
  Delay delay;
  double period = 1e-3;  ///< Ts, s
  int substeps = 1;      ///< integration steps per tick
  Integrator integrator = Integrator::rungeKutta4;
  double jitter = 0.0;       ///< largest lateness of a tick, share of the period, 0 to 1; uniform
  double lostSamples = 0.0;  ///< share of the ticks at which measure() is stale, 0 to 0.5; never the first tick
  std::uint64_t seed = 1;
  std::uint32_t run = 0;  ///< number of the random stream
};

/// Check a setup. Throws Error in these cases:
///
/// - substeps outside 1 to 1000, or a period outside 1e-5 to 0.1 s;
/// - delays outside 0 to kMaxDelay ticks, or low > high;
/// - jitter or lost samples outside their range, or a cutoff that is not positive;
/// - a start pose that is not finite or does not have a rotation matrix.
///
/// Realtime: no.
void checkVirtualDevice(const VirtualDeviceSetup& setup);

/// A device that moves in steps of one period: call measure(), actuate(), advance(), and repeat. It reports the torque
/// that acted. It refers to the mechanism.
class VirtualDevice final : public HapticDevice {
 public:
  /// Throws Error as checkVirtualDevice(), and if the start pose is out of reach. Realtime: no.
  VirtualDevice(const Mechanism& mechanism, const VirtualDeviceSetup& setup);

  /// Use another plant than the closed form. Substeps and integrator of the setup are not used. Throws Error also if
  /// the plant is null.
  VirtualDevice(std::unique_ptr<Plant> plant, const VirtualDeviceSetup& setup);

  /// Restart at tick 0, at rest at a pose, as after construction. Returns a status of Plant::start(); on an error the
  /// device does not move. Realtime: as the plant's.
  [[nodiscard]] Status restart(const Pose& start);

  /// Measure. Returns ok, stale if the sample was lost, or the status of the configuration that the mechanism cannot
  /// leave. Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;
  /// Take a command. Returns ok. Realtime: yes.
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// Move on by one period under a load. The second form applies `before` until `instant`, and `after` from then on.
  /// `instant` is the time after the tick's beginning, in 0 to the period, s. Returns a status of Plant::advance(); on
  /// an error the device does not move. Realtime: yes, if plant and loads are.
  [[nodiscard]] Status advance(const ExternalWrench& load) noexcept;
  [[nodiscard]] Status advance(const ExternalWrench& before, double instant, const ExternalWrench& after) noexcept;

  /// Return the number of the present or next tick. time() returns its time, s. Realtime: yes.
  std::uint64_t tick() const noexcept { return tick_; }
  double time() const noexcept { return timeOf(tick_); }

  const Plant& plant() const noexcept { return *plant_; }

  /// Return the true state now. kinematics() are those at the last measure(). torque() is the torque that acts during
  /// the present tick. Realtime: yes.
  const DeviceState& state() const noexcept { return plant_->state(); }
  const Kinematics& kinematics() const noexcept { return kinematics_; }
  const JointVector& torque() const noexcept { return torque_; }

 private:
  double timeOf(std::uint64_t tick) const noexcept;
  double duration() const noexcept;  // of the present tick, s

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
