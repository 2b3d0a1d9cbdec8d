// The guard decides which torque reaches the motors. It is part of every HapticTick and on by default.
//
// A request that breaks no rule passes unchanged, bit for bit. Each tick the guard checks for faults in this order:
//
// 1. invalid numbers, joints that jump, frozen encoders, the clock, late ticks;
// 2. a failed driver, an unreachable configuration, a failed renderer;
// 3. workspace, speed, and the energy given to the tool;
// 4. missed deadlines, and samples that come too fast;
// 5. oscillation.
//
// Without a fault it applies the user's enable, the ramp in, the brake, and the limits of force, torque and slew. A
// limit scales the part of the torque above gravity. The force then becomes smaller and keeps its direction.
//
// A fault ramps the torque to the torque that balances gravity, or to zero if the configuration is unknown. It stays
// latched until reset(). Details, and the faults that the guard cannot detect: lib/docs/guard.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "enamel/device/haptic_device.hpp"
#include "enamel/device/mapped_mechanism.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Largest GuardOptions::delay, ticks.
inline constexpr int kMostGuardDelay = 3;

/// Limits and budgets of a guard. guardFor() derives them from a device. Make them tighter where the application allows
/// it.
struct GuardOptions {
  bool on = true;        ///< false: every torque passes; ticks are still recorded
  double period = 1e-3;  ///< period of the ticks, s

  JointVector torque;                           ///< largest torque of each motor, N m or N; 0: a joint without a motor
  JointVector slew;                             ///< largest rate of change of each torque, N m/s or N/s
  double force = kUnlimited;                    ///< largest rendered force at the TCP, N
  double moment = kUnlimited;                   ///< largest rendered moment at the TCP, N m
  Vec3 workspace = Vec3::Constant(kUnlimited);  ///< half widths of a box around home, m; the brake acts outside
  double margin = 5e-3;                         ///< distance from that box to the stop, m

  double speed = 1.0, stopSpeed = 3.0;  ///< TCP speeds at which brake and stop begin, m/s
  double turn = 20.0, stopTurn = 60.0;  ///< the same of the angular speed, rad/s
  double brake = 0.0, brakeTurn = 0.0;  ///< damping of the excess speed, N s/m and N m s/rad

  JointVector rate;         ///< largest plausible rate of each joint, rad/s or m/s
  JointVector encoderStep;  ///< encoder step of each joint, rad or m
  /// Transmission between motors and links. Behind cables the energy account has only the work on the links.
  Drive drive;
  int delay = 0;        ///< delay of the commands, ticks; used if neither the device nor the renderer knows better
  int longestGap = 4;   ///< longest time between two ticks or two samples, periods
  int mostMissed = 10;  ///< largest number of missed ticks and samples; each tick forgets 1 % of them

  Mat6 damping = Mat6::Zero();  ///< the device's own mechanical damping of the TCP's twist, N s/m, N m s/rad
  double energy = 0.0;          ///< energy budget, J
  double power = 0.0;           ///< power that does not count against the budget, W
  double softest = 500.0;       ///< stiffness K of the softest wall, N/m; it may return at most F^2 / (2 K)

  /// Largest change of a rendered torque per tick, rms over 0.1 s, as a share of the motor's limit.
  double oscillation = 0.7;
  /// The renderer engages below this demanded torque above gravity, as a share of each motor's limit.
  double engage = 0.1;
  double rampIn = 0.1;    ///< duration of the ramp in, s
  double rampOut = 0.02;  ///< duration of the ramp out, s
};

/// Return options for a device and ticks of `period` s:
///
/// - torque: the motors' limits; slew: their whole range within half a millisecond;
/// - brake: damps the lightest direction at home by 5 % per tick;
/// - damping: the mechanical damping of the model at home;
/// - energy: F over 0.7 mm; power: F at 1 mm/s. F is the largest force at home in the weakest of the six axis
///   directions.
///
/// Throws Error if the period is outside 1e-5 to 0.1 s, or if the device is scaled (MappedMechanism): toScene()
/// converts the options of the device itself. Realtime: no.
GuardOptions guardFor(const Mechanism& device, double period);

/// Return the options of a device for a MappedMechanism with this map: lengths and forces are those in the scene.
/// Throws Error if they limit the workspace. Realtime: no.
GuardOptions toScene(const GuardOptions& ofDevice, const WorkspaceMap& map);

/// Record of one tick.
struct GuardTick {
  double time = 0.0;                       ///< s
  JointVector q;                           ///< measured joint coordinates, rad or m
  JointVector requested, applied;          ///< torques, N m or N
  double energy = 0.0;                     ///< net energy given to the tool, the larger of two accounts, J
  GuardReason reason = GuardReason::none;  ///< why applied and requested differ
};

/// Number of recorded ticks. Recording stops once a fault has ramped out.
inline constexpr std::size_t kGuardTicks = 1000;

/// The guard of one device, with its memory. A guard is a value: a copy continues as the original does.
class Guard {
 public:
  /// Throws Error in these cases:
  ///
  /// - a torque limit exceeds the device's;
  /// - a vector does not have one number per joint;
  /// - a limit is negative or NaN, or a slew, rate, encoder step or softest wall is not positive;
  /// - a stop is below its limit, the delay is outside 0 to kMostGuardDelay, or longestGap is below 1;
  /// - cables without an inertia of the rotors, or one that exceeds the device's;
  /// - the period is outside 1e-5 to 0.1 s.
  ///
  /// Realtime: no.
  Guard(const Mechanism& device, const GuardOptions& options);

  /// Guard one tick. Read kinematics, contacts and requested torque of the frame; write its command and reason.
  /// `status` is the status of all earlier stages. The kinematics count only if their q equals the measured q. The
  /// energy account excludes the work of a moving obstacle and of TickFrame::guided. Realtime: yes (no allocation).
  void step(const Measurement& measurement, Status status, TickFrame& frame) noexcept;

  /// Clear a fault. The renderer's torque then ramps in once the demanded force is small. Realtime: yes.
  void reset() noexcept;

  /// Restart as after construction, for a device at rest without any torque. There is then no ramp in. Realtime: yes.
  void restart() noexcept;

  /// Return the latched fault, or `none`. engaged() returns whether any of the renderer's torque passes, weight() the
  /// share that passes, 0 to 1. Realtime: yes.
  GuardReason fault() const noexcept { return state_.fault; }
  bool engaged() const noexcept { return state_.open || state_.weight > 0.0; }
  double weight() const noexcept { return options_.on ? state_.weight : 1.0; }

  const GuardOptions& options() const noexcept { return options_; }

  /// Return whether a report of the acting torque (Measurement::applied) is plausible. Each torque must be within 1.5
  /// times its motor's limit. The report must contain at least 0.75 of the commands of the last 0 to kMostGuardDelay
  /// ticks, by regression over 10 ms. It may contain more, such as effects of an application. The command replaces a
  /// rejected report. Realtime: yes.
  bool believes(const JointVector& applied) const noexcept;

  /// Return the number of rejected reports since construction or restart(). ignoredJoint() returns the joint of the
  /// last one, or -1. Realtime: yes.
  std::uint64_t ignoredReports() const noexcept { return ignored_; }
  int ignoredJoint() const noexcept { return ignoredJoint_; }

  /// Save and load the state between ticks, stateSize() numbers. The recorded ticks are not part of it and remain.
  /// Invalid numbers give the state after reset(). Realtime: yes.
  static std::size_t stateSize() noexcept;
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

  /// Return the number of recorded ticks. tick() returns one by its age; 0 is the newest. Realtime: yes.
  std::size_t kept() const noexcept { return count_ < kGuardTicks ? count_ : kGuardTicks; }
  const GuardTick& tick(std::size_t age) const noexcept { return ring_[(count_ - 1 - age) % kGuardTicks]; }

 private:
  using Row = std::array<double, kMaxJoints>;
  // A mode of the links behind cables (lib/src/render/mode_table.hpp): angles of rotor and link relative to the last
  // reading, and their rates. Then torque of the motor above gravity, and push of the hand on the link.
  enum : int { kRotor, kRotorRate, kLink, kLinkRate, kMotor, kPush, kMotion };
  using Motion = std::array<double, kMotion>;
  struct Mode {
    Row axis{};
    double inertia = 0.0, variance = 0.0;  // of the link; of a reading minus its prediction
    std::array<Motion, kMotion> kept{};    // effect of each state on the states a period later
    Motion command{}, gain{};              // effect of the command; of a reading minus its prediction (Kalman filter)
  };
  using Modes = std::array<Mode, kMaxJoints>;
  static constexpr int kReportLags = kMostGuardDelay + 1;
  // Energy given to the tool, computed from one estimate of the acting torque.
  struct Account {
    double energy = 0.0;                     // J
    Row beyond{};                            // torque above gravity before the last tick
    std::array<Motion, kMaxJoints> modes{};  // behind cables: estimated from this torque and the readings
    Row surprise{};                          // last readings of the modes minus their predictions
    double misfit = 0.0;                     // mean square of its changes, over the variance that the model predicts
    bool single = false;                     // the last sample came after one period
  };
  struct State {
    GuardReason fault = GuardReason::none;
    bool started = false;   // there was a tick since reset()
    bool acted = false;     // `torque` was applied
    bool open = false;      // the renderer is admitted
    bool withheld = false;  // the renderer was blocked at some tick: ramp in
    bool known = true;      // during a fault: the configuration is known
    bool shedding = false;  // during a fault: the rendered part was removed at once
    double time = 0.0;
    double sampleTime = 0.0;  // of the last sample, as the next three
    Row q{};
    Vec6 twist = Vec6::Zero();
    Row acting{};                 // mean torque applied since the last sample
    double ticks = 0.0;           // since the last sample
    Row torque{};                 // last applied torque; at a joint without a motor: the torque that the wall needs
    Row gravity{};                // gravity torque at the last tick
    Row rendered{};               // torque above gravity requested at the last tick
    Vec3 surface = Vec3::Zero();  // velocity of the touched surface at the last tick, W
    Mat3 rotation = Mat3::Identity();     // of the platform at the last sample
    double weight = 0.0;                  // weight of the rendered part
    Row from{}, fromGravity{};            // torques at the start of a fault's ramp
    int rampTicks = 0;                    // ticks since that start
    Account commanded, reported;          // from the guard's commands; from the device's reports
    Account learnt;                       // from the commands of the delay that the renderer has learnt
    bool reports = false;                 // the device has reported a torque
    std::array<Row, kReportLags> sent{};  // torques applied at the last ticks, newest first
    // Means of report times command, of the oldest command squared, and of the squared error of the report.
    Row match{}, power{}, error{};
    double interval = 0.0;  // mean time between samples, minus one period, s
    double peak = 0.0;      // largest recent rendered force, N
    Row jerk{};             // mean square change of the rendered torque, shares
    double missed = 0.0;    // missed ticks
    Row pace{}, claimed{};  // counts per tick before a joint stopped; counts predicted from its rate since then
    std::array<bool, kMaxJoints> even{};  // whether the pace equals that of the tick before
    std::array<int, kMaxJoints> still{};  // ticks without a change of the reading
  };

  template <typename AnyState, typename Visit>
  static void forEachNumber(AnyState& state, const Visit& visit);
  GuardReason measured(const Measurement& m, double elapsed) noexcept;
  GuardReason judged(const Measurement& m, Status status, bool known, double elapsed, const TickFrame& frame) noexcept;
  void remember(const Measurement& m) noexcept;
  GuardReason moved(const Measurement& m, const TickFrame& frame) noexcept;
  Modes modesOf(const Mechanism& device, const Drive& drive) const;
  void describeCables(const Mechanism& device);
  void learn(const TickOutput& output) noexcept;
  double workOnLinks(const Row& torque, const Row& step, double elapsed, Account& account) const noexcept;
  int read() const noexcept { return options_.drive.encoderOnLink ? kLink : kRotor; }  // the state that encoders read
  int unlikelyJoint(const JointVector& applied) const noexcept;
  void compareReport(const JointVector& applied, const Row& command, double elapsed) noexcept;
  const Row& nearestCommand(const JointVector& applied) const noexcept;
  double book(const Measurement& m, const TickFrame& frame, const Row& torque, Account& account) const noexcept;
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
  std::vector<Modes> modes_;             // of devices with cables: for several stiffnesses
  std::size_t stiffness_ = 0;            // the one that the renderer has learnt
  int delay_ = 0;                        // of the commands, ticks: learnt by the renderer, or of the options
  double lag_ = 0.0, mostMisfit_ = 0.0;  // of the motors behind cables, 1/s; of a model that the readings do not refute
  JointVector most_;                     // the motors' own limits, N m or N
  Row weight_{};                         // weight of a joint in a comparison of torques: 1 / most_^2
  std::uint64_t ignored_ = 0;
  int ignoredJoint_ = -1;
  State state_;
  std::vector<GuardTick> ring_;
  std::size_t count_ = 0;
};

}  // namespace enamel
