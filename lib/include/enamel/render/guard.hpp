// The guard: decides what a renderer's torque becomes before it reaches the motors. In every HapticTick, on by default.
//
// A request that no rule objects to passes bit for bit. The rules, in this order: finite numbers; a measurement that
// can be (jumps, frozen encoders, the clock); a driver that fails; force, torque and slew; workspace and speed; the
// energy that the tool was given; oscillation; missed deadlines; samples that come too fast; the user's enable. Cuts
// scale the part beyond gravity, so a force becomes smaller and is never turned. A fault ramps the torque to what
// balances gravity where the configuration is known, to zero where it is not, and stays until reset(). Told at length,
// with what it cannot see: lib/docs/guard.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "enamel/device/haptic_device.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Largest GuardOptions::delay, ticks.
inline constexpr int kMostGuardDelay = 3;

/// Limits and budgets of a guard: guardFor() derives them from a device; tighten what should be tighter.
struct GuardOptions {
  bool on = true;        ///< false: everything passes; ticks are kept all the same
  double period = 1e-3;  ///< of the ticks, s

  JointVector torque;                           ///< largest of every motor, N m or N; 0: a joint without a motor
  JointVector slew;                             ///< largest change, N m/s or N/s
  double force = kUnlimited;                    ///< largest rendered at the TCP, N
  double moment = kUnlimited;                   ///< the same, N m
  Vec3 workspace = Vec3::Constant(kUnlimited);  ///< half widths of a box about home, m
  double margin = 5e-3;                         ///< beyond it: the stop, m

  double speed = 1.0, stopSpeed = 3.0;  ///< of the TCP: where the brake begins, and the stop, m/s
  double turn = 20.0, stopTurn = 60.0;  ///< rad/s
  double brake = 0.0, brakeTurn = 0.0;  ///< damping on what is beyond, N s/m and N m s/rad

  JointVector rate;         ///< faster is no motion of a joint, rad/s or m/s
  JointVector encoderStep;  ///< of the encoders, rad or m
  Drive drive;              ///< between motors and links: what rotors and cables hold is not the tool's energy
  JointVector linkInertia;  ///< of each link by itself, without rotors, kg m^2 or kg; needed behind cables
  int delay = 0;            ///< of the commands, ticks; used if the device does not report what acted
  int longestGap = 4;       ///< between two ticks, and between two samples, periods
  int mostMissed = 10;      ///< ticks and samples that were missed, of which 1 % are forgotten a tick

  Mat6 damping = Mat6::Zero();  ///< mechanical, of the TCP's twist: what the device itself takes out, SI
  double energy = 0.0;          ///< budget, J
  double power = 0.0;           ///< that does not count against the budget, W
  double softest = 500.0;       ///< wall that may give back all that it took: F^2 / (2 K) at most, N/m

  double oscillation = 0.7;  ///< rms change of a rendered torque in a tick, over 0.1 s; a share of the motor's limit
  double engage = 0.1;       ///< demanded torque beyond gravity at which it engages, a share of every motor's limit
  double rampIn = 0.1;       ///< s
  double rampOut = 0.02;     ///< s
};

/// Options for a device and ticks of `period` s: the motors' limits, their whole range within half a millisecond, a
/// brake that damps the lightest direction at home by 5 % a tick, the mechanical damping of the model at home, an
/// energy budget of the largest force at home in its weakest direction over 0.7 mm, and beside it that force at 1 mm/s.
/// Throws Error: a period outside 1e-5 to 0.1 s. Realtime: no.
GuardOptions guardFor(const Mechanism& device, double period);

/// Sets drive and linkInertia to those of a device at home. Realtime: no.
void setDrive(const Mechanism& device, GuardOptions& options);

/// One tick as the guard keeps it.
struct GuardTick {
  double time = 0.0;                       ///< s
  JointVector q;                           ///< measured, rad or m
  JointVector requested, applied;          ///< N m or N
  double energy = 0.0;                     ///< that the tool was given beyond what it gave, by the worse account, J
  GuardReason reason = GuardReason::none;  ///< why the two differ
};

/// How many ticks are kept; none is added once a fault has ramped out.
inline constexpr std::size_t kGuardTicks = 1000;

/// A guard with its memory. A value: a copy continues as the original does.
class Guard {
 public:
  /// Throws Error: a torque limit beyond the device's, or one joint's number missing; limits that are negative or not
  /// numbers; a period outside 1e-5 to 0.1 s. Realtime: no.
  Guard(const Mechanism& device, const GuardOptions& options);

  /// One tick: reads kinematics, contacts and requested torque of the frame, writes its command and reason. The
  /// kinematics count where their q is that of the measurement. `status` is that of everything before. What a moving
  /// obstacle does to the tool is not held against the renderer. Realtime: yes (no allocation).
  void step(const Measurement& measurement, Status status, TickFrame& frame) noexcept;

  /// Forgets a fault. What is rendered next ramps in once the demanded force is small. Realtime: yes.
  void reset() noexcept;

  /// As new, for a device at rest that nothing acts on yet: nothing ramps in. Realtime: yes.
  void restart() noexcept;

  /// The fault that is latched, or none; whether anything of the renderer's torque is let through. Realtime: yes.
  GuardReason fault() const noexcept { return state_.fault; }
  bool engaged() const noexcept { return state_.open || state_.weight > 0.0; }

  const GuardOptions& options() const noexcept { return options_; }

  /// Return whether a report of the acting torque (Measurement::applied) is plausible. Each motor must be within 1.5
  /// times its limit. The report must contain at least 0.75 of the commands of the last 0 to kMostGuardDelay ticks (by
  /// regression over 10 ms); it may contain more, such as effects of an application. The command replaces a report that
  /// is rejected. Realtime: yes.
  bool believes(const JointVector& applied) const noexcept;

  /// Return the number of rejected reports since construction or restart(), and the joint of the last one (-1: none).
  /// Realtime: yes.
  std::uint64_t ignoredReports() const noexcept { return ignored_; }
  int ignoredJoint() const noexcept { return ignoredJoint_; }

  /// The state between ticks, as stateSize() numbers, and back; the ticks that are kept stay. Numbers that no state can
  /// have are those after reset(). Realtime: yes.
  static std::size_t stateSize() noexcept;
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

  /// The ticks that are kept: how many, and one by its age, 0 the newest. Realtime: yes.
  std::size_t kept() const noexcept { return count_ < kGuardTicks ? count_ : kGuardTicks; }
  const GuardTick& tick(std::size_t age) const noexcept { return ring_[(count_ - 1 - age) % kGuardTicks]; }

 private:
  using Row = std::array<double, kMaxJoints>;
  // Torque of a motor, stretch of its cable and its rate, a period later: by themselves and by the command.
  struct Transmission {
    double kept[3][3], command[3];
    double share;  // of what is left for rotor and link that reaches the link
  };
  static constexpr int kReportLags = kMostGuardDelay + 1;
  // Energy that the tool was given, by one opinion on the torque that acted.
  struct Account {
    double energy = 0.0;                     // J
    double held = 0.0;                       // by rotors and cables, J
    Row beyond{};                            // that reached the links beyond gravity before the last tick
    Row lagged{}, stretch{}, stretchRate{};  // of motors and cables: torque beyond gravity, rad or m, and its rate
  };
  struct State {
    GuardReason fault = GuardReason::none;
    bool started = false;   // there was a tick since reset()
    bool acted = false;     // `torque` was applied
    bool open = false;      // the renderer is let through
    bool withheld = false;  // it was not, at some tick: ramp in
    bool known = true;      // of a fault: the configuration
    bool shedding = false;  // of a fault: the rendered part is gone
    double time = 0.0;
    double sampleTime = 0.0;  // of the last sample, with what follows
    Row q{};
    Vec6 twist = Vec6::Zero();
    Row acting{};                         // applied since then, the mean
    double ticks = 0.0;                   // since then
    Row torque{};                         // applied last; of a joint without a motor what the wall would have needed
    Row gravity{};                        // at the last tick
    Row rendered{};                       // requested beyond gravity, at the last tick
    Vec3 surface = Vec3::Zero();          // velocity of what was touched at the last tick, W
    Mat3 rotation = Mat3::Identity();     // of the platform at the last sample
    double weight = 0.0;                  // of the rendered part
    Row from{}, fromGravity{};            // where a fault's ramp begins
    int rampTicks = 0;                    // of it
    Account commanded, reported;          // by what was commanded, and by what the device reports
    bool reports = false;                 // the device has reported
    std::array<Row, kReportLags> sent{};  // applied at the last ticks, the newest first
    Row match{}, power{};                 // means of report times command, and of the oldest command squared
    double interval = 0.0;                // mean time between samples, less a period, s
    double peak = 0.0;                    // largest rendered force of late, N
    Row jerk{};                           // mean square change of the rendered torque, shares
    double missed = 0.0;                  // ticks
    Row pace{}, claimed{};  // of a joint at rest: counts a tick before it stopped, counts that its rate predicts since
    std::array<bool, kMaxJoints> even{};  // whether the pace was that of the tick before
    std::array<int, kMaxJoints> still{};  // for how many ticks
  };

  template <typename AnyState, typename Visit>
  static void forEachNumber(AnyState& state, const Visit& visit);
  GuardReason measured(const Measurement& m, double elapsed) noexcept;
  GuardReason judged(const Measurement& m, Status status, bool known, double elapsed, const TickFrame& frame) noexcept;
  void remember(const Measurement& m) noexcept;
  GuardReason moved(const Measurement& m, const Kinematics& k) noexcept;
  void describeTransmission();
  void reachLink(int joint, double elapsed, Account& account, double& torque, double& way) const noexcept;
  int unlikelyJoint(const JointVector& applied) const noexcept;
  void compareReport(const JointVector& applied, const Row& command, double elapsed) noexcept;
  const Row& nearestCommand(const JointVector& applied) const noexcept;
  double book(const Measurement& m, const Kinematics& k, const Row& torque, Account& account) const noexcept;
  double energy() const noexcept;
  GuardReason asked(const JointVector& requested, const Kinematics& k) noexcept;
  GuardReason shape(const Measurement& m, const Kinematics& k, const JointVector& requested, double elapsed,
                    JointVector& torque) noexcept;
  void ramp(const Measurement& m, bool known, JointVector& torque) noexcept;
  bool limitSlew(double elapsed, JointVector& torque) const noexcept;
  Row bounded(const JointVector& gravity) const noexcept;
  bool isSmall() const noexcept;
  bool isDriven(int joint) const noexcept { return options_.torque[joint] > 0.0; }

  GuardOptions options_;
  int n_;
  bool damped_;
  std::array<Transmission, kMaxJoints> transmission_{};  // behind cables
  double lag_ = 0.0, mostHeld_ = 0.0;                    // of the motors, 1/s; largest of Account::held, J
  JointVector most_;                                     // of the motors, whatever the options, N m or N
  Row weight_{};                                         // of a joint in a comparison of torques: 1 / most_^2
  std::uint64_t ignored_ = 0;
  int ignoredJoint_ = -1;
  State state_;
  std::vector<GuardTick> ring_;
  std::size_t count_ = 0;
};

}  // namespace enamel
