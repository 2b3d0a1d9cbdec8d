// The wall as a position servo in contact space: it pushes and never pulls, lets the tool slide, and stands at the edge
// of what physics allows. How it works, told at length: lib/docs/position-control.md.
//
// Contact k has the unit normal n_k, the gap g_k and the row N_k = n_k^T J_k of the joint rates' effect on the gap.
// With time in ticks, the joints' acceleration under torques tau is q'' = s M^-1 (tau - gravity) + a, where a is what a
// person's push and everything unmodelled brings and s tells how far the model's inertia is off.
//
//  1. Observer. The state (q, q', a, b) of every joint, b the growth of a from tick to tick, is predicted under the
//     torque that really acted and corrected by the innovation e, encoder minus prediction, with the gains of a Kalman
//     filter for encoder counts, a trembling hand (white acceleration), a wandering push, and a wandering growth that
//     fades by itself within some 20 ticks.
//  2. Jumps. A push that jumps shows as an innovation along M^-1 N_k^T, what a force at the contact does. Above a
//     threshold the filter's covariance is raised by that of a jump somewhere in the last tick: near-deadbeat gains
//     that decay by themselves. How old the jump is shows in the innovation before: what has built up over some ticks
//     is a push that the slow gains have not followed, and is answered gently. Outward it is a push that falls, and
//     the covariance is raised by that of a growth. Just above the threshold, where it may be none, the gains are lower
//     and the tool is stopped, not sent back. Jumps that follow each other within some 0.1 s must be larger and larger,
//     and none is what a scale wrong by 0.15 explains.
//  3. Inertia. s is estimated by the recursive prediction-error method (Ljung and Soederstroem 1983) from what changes
//     quickly, within kLowestScale to kHighestScale, while a contact carries force, no jump is under way and the
//     encoders show more than the flicker of a tool at rest. A command that moves the tool by far more than pushes
//     can, as after an impact, teaches at once. Where the delay is random, only what acted beyond its expectation
//     teaches: an instrument without the bias of the loop. What s may yet be off by, its doubt, sends no tool out by
//     more than 0.1 mm.
//  4. Prediction through the delay, under the commands that are under way. Where the delay is random, it is by their
//     mean: which contacts are near and friction go by it, the law does not.
//  5. Law. Every contact is asked for the gap acceleration  w_k = min(-k1 g_k - k2 g_k', v_out - g_k'),  k1 = (1-z)^2,
//     k2 = r (1-z)(3+z)/2, where v_out = outwardSpeed + sqrt(2 |N_k a| outwardDistance) is what the push turns back at
//     once. The forces lambda >= 0 solve  N (s M^-1 N^T lambda + a) >= w,  with equality where lambda > 0, as a
//     quadratic program with the motors' limits among its bounds: a cut never turns the force. Contacts that the next
//     tick will still find 20 um outside have none. Dependent contacts share by a regularisation of 0.1 %; a surface of
//     stiffness k_m gives way by lambda / k_m.
//     Where the delay is random, w_k is the state feedback that minimises the expected cost of a mass whose last
//     commands act by chance: of g_k, g_k' and of what each command that may yet act would do (de Koning 1982). There a
//     contact also has force where the push alone, or a fall after a jump, will bring it back within three ticks, and
//     v_out, from the depth, bounds g_k' with all that may yet act: its mean and 1.5 standard deviations.
//  6. Friction along the surface: FrictionMemory, stuck with the poles 0.6 + 0.4 z.
//
// Proven: lambda >= 0, torques within limits, forces along N^T where a limit cuts. Stability, stiffness and chatter are
// tested on the virtual devices, with inertias wrong by 30 % and every delay up to 3 ticks.
#pragma once

#include <array>

#include "enamel/render/friction.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Largest delay that can be stated, ticks; most contacts that carry force at once (the deepest).
inline constexpr int kMaxLoopDelay = 8;
inline constexpr int kMaxActiveContacts = 6;

/// What the servo is told of the device, and what `enamel design --surface` chooses. The defaults are those for a
/// device without delay; positionControlFor() or a file has the others.
struct PositionControlOptions {
  double period = 1e-3;     ///< of the ticks, s
  JointVector encoderStep;  ///< step of each joint's encoder, rad or m: as many as the device has joints

  /// A command acts this many ticks late: constant, or anything between the two.
  int delayLow = 0, delayHigh = 0;
  int horizon = 0;  ///< how far the law looks ahead, ticks: the delay where it is constant

  double pole = 0.3061;               ///< z of the contact's loop, in [0, 1)
  double damping = 1.103;             ///< r
  double jumpPole = 0.298;            ///< z for the first `jumpTicks` ticks of a jump
  double jumpTicks = 3.089;           ///< ticks
  double outwardSpeed = 0.01084;      ///< m/s
  double outwardDistance = 3.237e-5;  ///< m

  double tremor = 0.5032;        ///< of the hand, white, counts/tick^2
  double wander = 0.32;          ///< of the push from tick to tick, counts/tick^2
  double growth = 0.005;         ///< of the push's growth from tick to tick, counts/tick^3
  double jumpThreshold = 4.306;  ///< innovation of a jump, counts
  double jumpAge = 0.95;         ///< least age of a jump that is seen for the first time, ticks, in [0, 1)
  double jumpSize = 13.73;       ///< counts/tick^2
  double jumpGrowth = 0.3;       ///< of the push after a jump, counts/tick^3
};

/// One of the numbers that a design chooses.
struct PositionControlParameter {
  const char* name;  ///< as in a file
  double PositionControlOptions::*value;
  double low, high;  ///< what is accepted
  const char* unit;
};

/// All of them. Realtime: yes.
const std::array<PositionControlParameter, 13>& positionControlParameters() noexcept;

/// Options that were found for the TAU, for any device: counts and ticks are the units that matter. With a delay beyond
/// 3 ticks those for 3. What is given is checked by PositionControlRenderer. Realtime: yes.
PositionControlOptions positionControlFor(const JointVector& encoderStep, double period, int delayLow, int delayHigh);

/// The contact-space servo, on any mechanism with as many joints as counts were given.
class PositionControlRenderer final : public Renderer {
 public:
  /// Range of the estimated scale s of the inverse inertia.
  static constexpr double kLowestScale = 0.65, kHighestScale = 1.4;

  /// Throws Error: no or more than kMaxJoints counts, one that is not positive; delays outside 0 to kMaxLoopDelay, low
  /// above high; a horizon outside 0 to kMaxLoopDelay; a number outside its range or not finite; at activate(), a
  /// period other than `period`.
  explicit PositionControlRenderer(const PositionControlOptions& options);

  bool needsInertia() const noexcept override { return true; }

  /// The estimated s: the true inverse inertia over the model's. Realtime: yes.
  double inertiaScale() const noexcept { return state_.scale; }

  /// Jumps of the push seen since reset(). Realtime: yes.
  double jumps() const noexcept { return state_.jumps; }

 private:
  using Row = std::array<double, kMaxJoints>;              // one number a joint
  using Gain = std::array<double, 4>;                      // of position, rate, push and its growth
  using LateGain = std::array<double, 2 + kMaxLoopDelay>;  // of the gap, its rate, and what the commands that wait do
  static constexpr int kSchedule = 24;                     // ticks after which the gains are the slow ones again
  static constexpr int kMostMissing = 8;                   // samples in a row that are predicted

  struct Motion {  // of the joints: rad, rad/tick, rad/tick^2, rad/tick^3
    Row q{}, rate{}, push{}, growth{};

    void advance(int joint, double byTorque, double ticks) noexcept;
    void correct(int joint, const Gain& gain, double innovation) noexcept;
  };

  // Time in ticks.
  struct State {
    Motion estimate;
    Motion sensitivity;                             // its derivative by s
    Motion instrument;                              // the same, of what acted beyond what was to be expected
    Row meanInnovation{}, meanInstrument{};         // of the last ticks
    Row rest{}, sinceMoved{};                       // where each joint is at rest; ticks since it was
    std::array<Row, kMaxLoopDelay + 1> commands{};  // the last first, N m
    Row lastInnovation{}, lastAngles{};
    double scale = 1.0, information = 0.0;
    double sinceJump = kSchedule;  // ticks
    double lastJumpOutward = 0.0;  // 1: the last jump was outward
    double jumpProbability = 1.0;  // that the jump of this tick, if any, is one
    double recentJumps = 0.0;      // each counts less from tick to tick
    double jumps = 0.0;
    double lastTime = 0.0;
    double missing = 0.0;  // samples since the last one
    Row lastReading{}, lastRates{};
    double pushes = 0.0;   // 1: a contact carried force at the last tick
    double started = 0.0;  // 1: the observer runs
    FrictionMemory friction;
  };
  struct Jump {
    bool seen = false;
    bool outward = false;
    double probability = 1.0;  // that it is one, in [0, 1]
    double inverseAge = 1.0;   // one over its age in ticks
  };
  struct Schedule {  // by ticks since a jump; the last: slow
    std::array<Gain, kSchedule + 1> gains{};
    std::array<double, kSchedule + 1> deviations{};  // of the innovation, as a share of the slow one's
  };
  struct Inertia;
  struct Normals;
  struct Pushing;
  struct Ahead;
  struct UnderWay {
    Row torque{};        // N m
    double share = 0.0;  // how likely it is that one of them acts
  };

  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override { state_ = State{}; }
  StateBlock stateBlock() noexcept override { return {&state_, sizeof(State)}; }
  void stateLoaded() noexcept override;

  void start(const TickFrame& frame) noexcept;
  void advance(const Row& torque, const Inertia& inertia, double ticks) noexcept;
  void passOver(const TickFrame& frame, const Inertia& inertia, double& ticks) noexcept;
  bool isRepeated(const Kinematics& kinematics) const noexcept;
  void rememberCommand(const Row& command) noexcept;
  Row acted(const TickFrame& frame) const noexcept;
  UnderWay underWay(int ahead) const noexcept;
  void learnFromStrongCommand(double most, Row& innovation) noexcept;
  void observe(const TickFrame& frame, const Inertia& inertia, const Normals& normals, double ticks) noexcept;
  Jump jumpOf(int contacts, const Normals& normals, const Row& innovation) const noexcept;
  Ahead predict(const Inertia& inertia) const noexcept;
  const Schedule& scheduleNow() const noexcept {
    return state_.lastJumpOutward != 0.0 ? outwardSchedule_ : inwardSchedule_;
  }
  int delays() const noexcept { return options_.delayHigh - options_.delayLow + 1; }  // each as likely
  bool isRandom() const noexcept { return options_.delayLow < options_.delayHigh; }
  LateGain lateGain(double pole) const;
  Pushing pushing(const TickFrame& frame, const Inertia& inertia, const Normals& normals,
                  const Ahead& ahead) const noexcept;
  Row addFriction(const TickFrame& frame, const Inertia& inertia, const Normals& normals, const Ahead& ahead,
                  double sinceSample, Pushing& pushing) noexcept;

  PositionControlOptions options_;
  int joints_;
  Schedule inwardSchedule_, outwardSchedule_;  // after a jump inward, and outward
  Schedule missed_;                            // by samples that are missing, far from a jump
  LateGain lateGain_{}, lateJumpGain_{};       // random delay: beyond and after a jump
  State state_;
};

}  // namespace enamel
