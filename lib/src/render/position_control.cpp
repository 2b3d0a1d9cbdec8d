#include "enamel/render/position_control.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "render/contact_walls.hpp"
#include "render/controlled_modes.hpp"
#include "render/loop_delay.hpp"

namespace enamel {
namespace {

// These numbers and kStick were chosen; all others are computed. lib/docs/position-control.md says what each trades.
constexpr double kForceCost = 20.0;   // of the linear-quadratic design: chatter against stiffness
constexpr double kModelError = 0.15;  // share of the force that the model misses: robustness against stiffness
constexpr double kReportScale = 0.03, kReportFloor = 0.002;      // deviations of a report: share of it, of the limit
constexpr double kFalseReport = 0.05;                            // probability that a report is wrong
constexpr double kSureDeviations = 1.0, kSpeedDeviations = 0.5;  // of the cap: bounce against stiffness

// Model of a person. A step has a deviation of 8 N, or a fifth of a weak device's largest force. The tremor is a
// sixteenth of a step. A moment counts as a force at 2 cm.
constexpr double kStepForce = 8.0, kStepShare = 0.2, kTremorShare = 1.0 / 16.0, kGrip = 0.02;
constexpr double kPushShare = 0.27;  // of the designs: a large step as a share of the largest force

constexpr double kEarly = 0.5, kMostTicks = 10.5;  // ticks since the last sample: fewer repeat the answer, more reset
constexpr double kDoubtTime = 0.1, kMostDoubts = 12.0;  // s; more contradictions in this time are a fault
constexpr double kContradicts = 8.0;                    // deviations of an innovation that no push explains
constexpr double kNear = 2e-5;    // m: a contact that stays farther outside for a tick carries no force
constexpr int kRefreshTicks = 8;  // between two updates of the inertia
static_assert(kMaxLoopDelay <= kMostPending);

ModeData dataOf(const PositionControlOptions& o) {
  return {o.period, o.delayLow, o.delayHigh, o.drive, kPushShare, kForceCost, kModelError};
}

}  // namespace

// The implementation: with rotors behind cables, or rigid.
class PositionControlRenderer::Controller {
 public:
  virtual ~Controller() = default;
  virtual Status render(const TickFrame& frame, TickOutput& output) noexcept = 0;
  virtual void reset() noexcept = 0;
  virtual StateBlock stateBlock() noexcept = 0;
  virtual void stateLoaded() noexcept = 0;
  virtual PositionControlState state() const noexcept = 0;
  virtual const LoopDelay& delay() const noexcept = 0;
  virtual ControlledModes modes() const noexcept = 0;
};

template <int kMech>
class PositionControlRenderer::ControllerOf final : public Controller {
 public:
  explicit ControllerOf(const PositionControlOptions& options);

  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void reset() noexcept override { memory_ = Memory{}; }
  StateBlock stateBlock() noexcept override { return {&memory_, sizeof memory_}; }
  void stateLoaded() noexcept override;
  PositionControlState state() const noexcept override;
  ControlledModes modes() const noexcept override;

 private:
  using Observer = PushObserver<kMech>;
  using States = typename Observer::States;
  static constexpr int kLink = kMech - 2, kLag = Observer::kLag, kPush = Observer::kPush, kGrowth = Observer::kGrowth;

  // All state between ticks: plain numbers, so that it can be copied bytewise.
  struct Memory {
    ModeAxes axes = {};
    typename Observer::State observer{};
    double started = 0.0, lastTime = 0.0, ticks = 0.0;
    std::array<JointRow, kMaxLoopDelay + 1> sent{};            // without gravity, newest first
    JointRow lastReading{}, lastEstimate{};                    // joints
    double step = 0.0;                                         // step of the hand, N
    double contradictions = 0.0, ignored = 0.0, doubts = 0.0;  // doubts: recent contradictions
    WallMemory walls;
    DelayEstimator::State delay{};
    double push = 0.0, merged = 0.0, lastNormal = 0.0;
    FrictionMemory friction;
  };
  // The states at the time when the command acts.
  struct alignas(64) Ahead {
    States x, next;              // at that time, and a tick later without contact forces
    States sensitivity;          // derivative of the last one by ln(mass), due to what acts from now on
    Lane beside{};               // torque that acts beside the contact forces: of guides and friction
    Lane pending[kMostPending];  // commands that may act instead of the new one, newest first
    PredictedModes modes;
  };

  Lane toModes(const JointRow& v) const noexcept { return enamel::toModes(memory_.axes, joints_, v); }
  void start(const TickFrame& frame, const JointRow& reading) noexcept;
  void decouple(const TickFrame& frame, bool whole) noexcept;
  void observe(const TickFrame& frame, const JointRow& reading) noexcept;
  const LoopDelay& delay() const noexcept override { return delays_[static_cast<int>(memory_.observer.design)]; }
  Rebound rebound() const noexcept { return {delay().reaction, options_.encoderStep}; }
  JointRow acting(const LoopDelay& d, int ahead) const noexcept;
  void compareReport(const TickFrame& frame, DelayEstimator::Evidence& evidence) const noexcept;
  double compareReading(const Lane& reading, DelayEstimator::Evidence& evidence) const noexcept;
  void learnDelay(const TickFrame& frame, const Lane& reading) noexcept;
  void predict(const TickFrame& frame, const JointRow& reading, Ahead& a) const noexcept;
  void addTorque(const JointRow& torque, Ahead& a) const noexcept;
  void act(Ahead& a) const noexcept;
  double share(const TickFrame& frame, const Ahead& a, const Wall* walls, const Target* targets, int count,
               const double* force, TickOutput& output) noexcept;
  double largestSafe(const Ahead& a, const Lane& row, double step, double speed, double depth) noexcept;
  JointRow guideOf(const TickFrame& frame) const noexcept;
  void repeat(const Kinematics& now, const JointRow& guide, TickOutput& output) const noexcept;

  PositionControlOptions options_;
  int joints_;
  DelayEstimator delays_;
  Observer observer_;
  alignas(64) Memory memory_;  // GCC 12 assumes this alignment
};

template <int kMech>
PositionControlRenderer::ControllerOf<kMech>::ControllerOf(const PositionControlOptions& options)
    : options_(options),
      joints_(static_cast<int>(options.encoderStep.size())),
      delays_(dataOf(options)),
      observer_(delays_.designs(dataOf(options)), unseenOf(options.encoderStep, options.effort)) {}

template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::stateLoaded() noexcept {
  const bool isSound = memory_.walls.count >= 0 && memory_.walls.count <= kMostWalls;
  if (!isSound ||
      (memory_.started != 0.0 && !(delays_.accepts(memory_.delay) && observer_.accepts(memory_.observer, joints_))))
    reset();
  else if (memory_.started != 0.0)
    observer_.reload(memory_.observer);
}

template <int kMech>
PositionControlState PositionControlRenderer::ControllerOf<kMech>::state() const noexcept {
  const typename Observer::State& s = memory_.observer;
  const bool isStarted = memory_.started != 0.0;
  return {std::exp(s.scale),
          isStarted ? std::sqrt(s.scaleVariance) : Observer::kScalePrior,
          std::exp(s.cable),
          kMech == 2  ? 0.0
          : isStarted ? std::sqrt(s.cableVariance)
                      : Observer::kCablePrior,
          memory_.push,
          memory_.ignored,
          memory_.merged,
          delay().low,
          delay().low + delay().pending};
}

template <int kMech>
ControlledModes PositionControlRenderer::ControllerOf<kMech>::modes() const noexcept {
  const typename Observer::State& s = memory_.observer;
  const JointVector unseen = unseenOf(options_.encoderStep, options_.effort);
  ControlledModes m{observer_.data(s), unseen,        joints_, memory_.step, {}, s.inertia, s.step, s.tremor,
                    s.readingVariance, s.largestStep, s.joint};
  std::memcpy(m.axes, memory_.axes, sizeof m.axes);
  return m;
}

// Rotate the modes towards the eigenvectors of the links' inertia (Jacobi's method): the most coupled pair, or all
// pairs if `whole`. Then describe the hand's forces and the encoder steps in each mode.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::decouple(const TickFrame& frame, bool whole) noexcept {
  constexpr double kCoupled = 0.01, kDecoupled = 1e-9;
  constexpr int kMostRotations = 150;
  const int n = joints_;
  auto& V = memory_.axes;
  double half[kMaxJoints][kLanes] = {}, L[kLanes][kLanes] = {};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < kLanes; ++k)
        half[i][k] += frame.kinematics.inertia(std::max(i, j), std::min(i, j)) * V[j][k];  // only the lower triangle
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < kLanes; ++k) L[i][k] += V[j][i] * half[j][k];
  for (int turn = 0; turn < (whole ? kMostRotations : 1); ++turn) {
    int p = -1, q = -1;
    double worst = whole ? kDecoupled : kCoupled;
    for (int i = 1; i < n; ++i)
      for (int j = 0; j < i; ++j) {
        const double coupled = std::abs(L[i][j]) / std::sqrt(L[i][i] * L[j][j]);
        if (!(coupled > worst)) continue;
        worst = coupled;
        p = j;
        q = i;
      }
    if (p < 0) break;
    const double t = 0.5 * (L[q][q] - L[p][p]) / L[p][q];
    const double tangent = std::copysign(1.0, t) / (std::abs(t) + std::hypot(1.0, t));
    const double cosine = 1.0 / std::hypot(1.0, tangent), sine = tangent * cosine;
    const auto turned = [&](double& a, double& b) {
      const double before = a;
      a = cosine * a - sine * b;
      b = sine * before + cosine * b;
    };
    for (int i = 0; i < n; ++i) {
      turned(L[i][p], L[i][q]);
      turned(V[i][p], V[i][q]);
    }
    for (int i = 0; i < n; ++i) turned(L[p][i], L[q][i]);
    if (!whole) observer_.rotate(memory_.observer, p, q, cosine, sine);
  }
  const double grip = kGrip * options_.scale;
  for (int k = 0; k < n; ++k) {
    double hand = 0.0;
    typename Observer::Rounding reading;
    for (int i = 0; i < 6; ++i) {
      double arm = 0.0;
      for (int j = 0; j < n; ++j) arm += frame.kinematics.jacobian(i, j) * V[j][k];
      hand += (i < 3 ? 1.0 : grip * grip) * arm * arm;
    }
    for (int j = 0; j < n; ++j) {
      const double step = std::abs(V[j][k]) * options_.encoderStep[j];
      reading.variance += step * step / 12.0;
      if (step > reading.largest) reading.largest = step, reading.joint = j;
    }
    const double force = memory_.step * std::sqrt(hand);
    observer_.describe(memory_.observer, k, std::max(1e-9, L[k][k] - options_.drive.rotorInertia), force,
                       kTremorShare * force, reading);
  }
}

template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::start(const TickFrame& frame, const JointRow& reading) noexcept {
  const Kinematics& k = frame.kinematics;
  const double ignored = memory_.ignored;
  const DelayEstimator::State delay = memory_.started != 0.0 ? memory_.delay : delays_.start();
  const int likeliest = static_cast<int>(memory_.observer.design);
  memory_ = Memory{};
  memory_.ignored = ignored;
  memory_.delay = delay;
  observer_.use(memory_.observer, likeliest);
  double force = 0.0;  // mean over the axes
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 along = Vec3::Unit(axis);
    const double both = largestForce(k, frame.maxTorque, k.pose.position, along) +
                        largestForce(k, frame.maxTorque, k.pose.position, -along);
    if (std::isfinite(both)) force += both / 6.0;
  }
  memory_.step = std::min(kStepForce / options_.scale, kStepShare * std::max(0.0, force));
  for (int j = 0; j < joints_; ++j) memory_.axes[j][j] = 1.0;
  decouple(frame, true);
  memory_.lastReading = memory_.lastEstimate = reading;
  observer_.start(memory_.observer, joints_, toModes(memory_.lastReading));
  memory_.started = 1.0;
}

// Advance the observer to this tick, and correct it if there is a new sample.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::observe(const TickFrame& frame, const JointRow& reading) noexcept {
  Memory& m = memory_;
  const double T = options_.period, elapsed = frame.time - m.lastTime;
  const int ticks = static_cast<int>(std::lround(elapsed / T));
  m.ticks += 1.0;
  if (m.ticks >= kRefreshTicks) {
    m.ticks = 0.0;
    decouple(frame, false);
  }
  observer_.refresh(m.observer);
  // Others may have changed the answer: an effect, the guard, a renderer around this one.
  if (!frame.applied && frame.command.size() == joints_)
    for (int j = 0; j < joints_; ++j)
      m.sent[0][j] = frame.maxTorque[j] > 0.0 ? frame.command[j] - frame.kinematics.gravity[j] : 0.0;
  for (int j = 0; frame.applied && frame.added.size() == joints_ && j < joints_; ++j)
    if (frame.maxTorque[j] > 0.0) m.sent[0][j] += frame.added[j];
  JointRow acted = acting(delay(), 0), rates{};
  if (frame.applied)
    for (int j = 0; j < joints_; ++j) acted[j] = (*frame.applied)[j] - frame.kinematics.gravity[j];
  const Lane command = toModes(acted), y = toModes(reading);
  Lane variance{};  // each command that may have acted is equally likely
  const LoopDelay& likeliest = delay();
  for (int d = 0; !frame.applied && d <= likeliest.pending; ++d) {
    const Lane other = toModes(m.sent[likeliest.low + d]);
    for (int k = 0; k < joints_; ++k)
      variance[k] += (other[k] - command[k]) * (other[k] - command[k]) / (likeliest.pending + 1);
  }
  if (frame.applied && m.observer.delays > 0.0) std::memset(m.observer.byDelay, 0, sizeof m.observer.byDelay);
  m.observer.delays = frame.applied ? 0.0 : delays_.count();
  for (int t = 0; t < ticks; ++t) {
    if (t > 0) observer_.merge(m.observer);
    observer_.predict(m.observer, command, variance);
    for (int i = 0; i < static_cast<int>(m.observer.delays); ++i) {
      if (i == static_cast<int>(m.observer.design)) continue;  // the prediction's own
      Lane more = toModes(acting(delays_[i], 0));
      for (int k = 0; k < kLanes; ++k) more[k] -= command[k];
      observer_.advance(more, m.observer.byDelay[i]);
    }
  }
  if (const double rest = elapsed - ticks * T; std::abs(rest) > 1e-6 * T) observer_.shift(m.observer, rest);
  if (frame.age == 0) {
    if (ticks == 1) learnDelay(frame, y);
    const bool contradicts = observer_.surprise(m.observer, y) > kContradicts;
    if (contradicts && m.contradictions == 0.0) {
      m.ignored += 1.0;
    } else if (contradicts) {
      for (int j = 0; j < joints_; ++j) rates[j] = (reading[j] - m.lastReading[j]) / elapsed;
      observer_.believe(m.observer, y, toModes(rates));
    } else {
      observer_.correct(m.observer, y);
    }
    m.contradictions = contradicts && m.contradictions == 0.0 ? 1.0 : 0.0;
    m.doubts = m.doubts * std::max(0.0, 1.0 - elapsed / kDoubtTime) + (contradicts ? 1.0 : 0.0);
  }
  observer_.merge(m.observer);
}

// Return the mean of the commands that may act under a delay, so many ticks after the last one, at most its lowest.
template <int kMech>
JointRow PositionControlRenderer::ControllerOf<kMech>::acting(const LoopDelay& d, int ahead) const noexcept {
  JointRow mean{};
  for (int i = 0; i <= d.pending; ++i)
    for (int j = 0; j < joints_; ++j) mean[j] += memory_.sent[d.low + i - ahead][j] / (d.pending + 1);
  return mean;
}

// Evidence of a report: one of the commands, with an error, or wrong.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::compareReport(const TickFrame& frame,
                                                                 DelayEstimator::Evidence& evidence) const noexcept {
  for (int d = delays_.shortest(); d <= delays_.longest(); ++d) {
    double square = 0.0;
    for (int j = 0; j < joints_; ++j) {
      const double report = (*frame.applied)[j] - frame.kinematics.gravity[j], error = report - memory_.sent[d][j],
                   share = kReportScale * report, noise = kReportFloor * frame.maxTorque[j];
      if (noise > 0.0) square += error * error / (share * share + noise * noise);
    }
    const double likelihood = std::log((1.0 - kFalseReport) * std::exp(-0.5 * square) + kFalseReport);
    for (int i = 0; i < delays_.count(); ++i) evidence[i][d] = likelihood;
  }
}

// Evidence of a reading: its difference from the prediction with the commands of each delay. Averaging readings does
// not remove the rounding of encoders. So a mode counts only as far as the delays change its reading by more. Returns
// the weight of the evidence: modes are not independent, so their information is averaged.
template <int kMech>
double PositionControlRenderer::ControllerOf<kMech>::compareReading(const Lane& reading,
                                                                    DelayEstimator::Evidence& evidence) const noexcept {
  const typename Observer::State& s = memory_.observer;
  Lane difference, variance, information{}, moved[kMostDelays][kMaxLoopDelay + 1];
  observer_.innovation(s, reading, difference, variance);
  const auto& effect = observer_.commandEffect();
  const auto forEach = [&](auto&& visit) {
    for (int i = 0; i < delays_.count(); ++i)
      for (int d = delays_[i].low; d <= delays_[i].low + delays_[i].pending; ++d) visit(i, d, moved[i][d]);
  };
  forEach([&](int i, int d, Lane& m) {
    JointRow more{};  // over the mean, if the delay is random
    if (const LoopDelay& delay = delays_[i]; delay.pending > 0) {
      more = acting(delay, 0);
      for (int j = 0; j < joints_; ++j) more[j] = memory_.sent[d][j] - more[j];
    }
    const Lane change = toModes(more);
    for (int k = 0; k < joints_; ++k) {
      m[k] = s.byDelay[i][observer_.readState()][k] + effect[k] * change[k];
      information[k] += std::max(0.0, m[k] * m[k] - s.readingVariance[k]) / variance[k];
    }
  });
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < joints_; ++k) {
    sum += information[k];
    squares += information[k] * information[k];
  }
  if (!(sum > 0.0)) return 0.0;
  double least = kLargestTorque;
  forEach([&](int i, int d, const Lane& m) {
    double scatter = 0.0;
    for (int k = 0; k < joints_; ++k) {
      const double error = difference[k] - m[k], square = error * error / variance[k];
      if (information[k] > 0.0) evidence[i][d] -= 0.5 * square;
      scatter += information[k] / sum * square;
    }
    least = std::min(least, scatter);
  });
  return squares / (sum * sum * std::max(1.0, least));
}

// Learn the delay from a report of the torque, or else from the reading.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::learnDelay(const TickFrame& frame, const Lane& reading) noexcept {
  Memory& m = memory_;
  DelayEstimator::Evidence evidence = {};
  double weight = 1.0;
  if (frame.applied)
    compareReport(frame, evidence);
  else
    weight = compareReading(reading, evidence);
  const int before = static_cast<int>(m.observer.design), likeliest = delays_.learn(m.delay, before, evidence, weight);
  if (likeliest == before) return;
  observer_.use(m.observer, likeliest);
  observer_.refresh(m.observer);
}

template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::predict(const TickFrame& frame, const JointRow& reading,
                                                           Ahead& a) const noexcept {
  const typename Observer::State& s = memory_.observer;
  const double T = options_.period, scale = std::exp(s.scale);
  std::memcpy(a.x, s.mean, sizeof a.x);
  std::memset(a.sensitivity, 0, sizeof a.sensitivity);
  for (int ahead = 1; ahead <= delay().low; ++ahead) {
    const Lane command = toModes(acting(delay(), ahead));
    observer_.advanceSensitivity(command, a.x, a.sensitivity);
    observer_.advance(command, a.x);
  }
  for (int d = 0; d < delay().pending; ++d) a.pending[d] = toModes(memory_.sent[d]);
  PredictedModes& m = a.modes;
  m = {};
  m.axes = &memory_.axes;
  m.count = joints_;
  m.period = T;
  m.handStep = memory_.step;
  m.tremor = kTremorShare * memory_.step;
  m.seconds = (delay().low + frame.age) * T;
  m.now = toModes(reading);
  m.readingVariance = s.readingVariance;
  m.inertia.fill(1.0);
  for (int k = 0; k < joints_; ++k) {
    m.inertia[k] = s.inertia[k] * scale + options_.drive.rotorInertia;
    m.estimate[k] = s.mean[kLink][k];
    m.place[k] = a.x[kLink][k];
    m.rate[k] = a.x[kLink + 1][k];
  }
  observer_.law(s, a.x, a.pending, m.law);
}

// Add a torque g that acts beside the contact forces. The total command K (r - w) contains it: the rest is
// K (r - (w + g / K)).
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::addTorque(const JointRow& torque, Ahead& a) const noexcept {
  const Lane more = toModes(torque);
  for (int k = 0; k < joints_; ++k) {
    a.beside[k] += more[k];
    a.modes.law.wouldBe[k] += more[k] / a.modes.law.stiffness[k];
  }
}

// Predict the tick in which the command acts, without contact forces.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::act(Ahead& a) const noexcept {
  observer_.advanceSensitivity(a.beside, a.x, a.sensitivity);
  std::memcpy(a.next, a.x, sizeof a.next);
  observer_.advance(a.beside, a.next);
  for (int k = 0; k < joints_; ++k) {
    const double rotor = kMech == 4 ? options_.drive.rotorInertia / a.modes.inertia[k] : 0.0;
    a.modes.next[k] = a.next[kLink][k];
    a.modes.nextRate[k] = (1.0 - rotor) * a.next[kLink + 1][k] + (kMech == 4 ? rotor * a.next[1][k] : 0.0);
  }
}

// Largest force along a row of the modes that does not throw the tool out. The push must stop the outward motion within
// the rebound: the distance that the push, at most a step of the hand, covers before an answer. Without a push the tool
// leaves the wall within kGrowthTime. `speed`: outward, a tick after the command acts, without force. `step`: of the
// reading.
template <int kMech>
double PositionControlRenderer::ControllerOf<kMech>::largestSafe(const Ahead& a, const Lane& row, double step,
                                                                 double speed, double depth) noexcept {
  const double T = options_.period;
  const LoopDelay& late = delay();
  double inverse = 0.0;
  for (int k = 0; k < joints_; ++k) inverse += row[k] * row[k] / a.modes.inertia[k];
  const double mass = 1.0 / inverse;
  States outward{}, push{};  // rows that give the speed and the push from the present states
  for (int k = 0; k < joints_; ++k) {
    push[kPush][k] = -row[k] / a.modes.inertia[k] * mass;
    const double rotor = kMech == 4 ? options_.drive.rotorInertia / a.modes.inertia[k] : 0.0;
    if (kMech == 4) outward[1][k] = row[k] * rotor;
    outward[kLink + 1][k] = row[k] * (1.0 - rotor);
  }
  // An error of the mass changes the speed in proportion to the net force until then.
  double byMass = 0.0, byCommand = 0.0;  // per unit of ln(mass): without a command, and its reduction by a unit command
  for (int i = 0; i < kMech; ++i)
    for (int k = 0; k < joints_; ++k) {
      byMass += outward[i][k] * a.sensitivity[i][k];
      byCommand -= outward[i][k] * observer_.commandSensitivity(i)[k] * row[k];
    }
  for (int d = 0; d <= late.low; ++d) observer_.pullBack(outward);
  auto force = observer_.moments(memory_.observer, push);
  const auto uncertain = observer_.moments(memory_.observer, outward);
  for (int k = 0; k < joints_; ++k) force.mean += push[kPush][k] * a.beside[k];
  const double sure = std::max(0.0, force.mean - kSureDeviations * force.deviation);
  memory_.push = force.mean;
  const double turnsBack = std::sqrt(2.0 * rebound().distance(std::min(sure, memory_.step), mass, step) * sure / mass),
               comesOut = std::min(depth / kGrowthTime, memory_.step * late.reaction / mass);
  // Largest change of speed z by this command for which speed + z plus its deviations stays below a limit. The
  // deviations are that of the present speed, and that of ln(mass) times (byMass - h z).
  // The pending commands that may act later, above the push that they meet: as often as is likely.
  double other = 0.0;
  for (int d = 0; d < late.pending; ++d) {
    double sum = 0.0;
    for (int k = 0; k < joints_; ++k) sum += row[k] * a.pending[d][k] / a.modes.inertia[k] * mass;
    speed += (sum - sure) * T / mass * (late.pending - d) / (late.pending + 1);
    other += sum / late.pending;
  }
  const double h = byCommand * mass / T, kappa = kSpeedDeviations * std::sqrt(memory_.observer.scaleVariance);
  const auto change = [&](double limit, double deviation) {
    const double most = limit - speed, own = kSpeedDeviations * deviation, left = 1.0 - kappa * kappa * h * h;
    return (most - kappa * kappa * h * byMass -
            std::sqrt(kappa * kappa * (h * most - byMass) * (h * most - byMass) + left * own * own)) /
           left;
  };
  const double safe = std::max({0.0, change(turnsBack, uncertain.deviation), change(comesOut, 0.0)}) * mass / T;
  if (late.pending == 0) return safe;
  // A command may act in more than one tick, in place of the pending ones.
  return std::min(safe, std::max(0.0, other + (safe - other) / late.acts));
}

// The applied share of the forces, limited by the cap and by the motors.
template <int kMech>
double PositionControlRenderer::ControllerOf<kMech>::share(const TickFrame& frame, const Ahead& a, const Wall* walls,
                                                           const Target* targets, int count, const double* force,
                                                           TickOutput& output) noexcept {
  double total = 0.0, speed = 0.0, depth = 0.0, most = kLargestTorque;
  Lane row{};
  JointRow normal{};
  for (int i = 0; i < count; ++i) {
    total += force[i];
    for (int j = 0; j < joints_; ++j) normal[j] += force[i] * walls[targets[i].wall].row[j];
    speed -= force[i] * walls[targets[i].wall].after;
    depth -= force[i] * walls[targets[i].wall].gap;
    for (int k = 0; k < kLanes; ++k) row[k] += force[i] * targets[i].row[k];
  }
  memory_.push = 0.0;
  if (!(total > 0.0)) return 0.0;
  speed /= total;
  depth /= total;
  for (int k = 0; k < kLanes; ++k) row[k] /= total;
  for (int k = 0; k < joints_; ++k) speed += row[k] * a.modes.nextRate[k];
  const JointRow joint = a.modes.toJoints(row);
  for (int j = 0; j < joints_; ++j)
    if (frame.maxTorque[j] > 0.0 && joint[j] != 0.0) {
      const double left =
          frame.maxTorque[j] - std::copysign(frame.kinematics.gravity[j], joint[j] * frame.kinematics.gravity[j]);
      most = std::min(most, std::max(0.0, left) / std::abs(joint[j]));
    }
  if (!(most > 0.0)) return 0.0;
  const double asked = std::min(total, largestSafe(a, row, rebound().readingStep(normal) / total, speed, depth));
  output.saturated = asked > most;
  return std::min(asked, most) / total;
}

// Torque of the guides at driven joints.
template <int kMech>
JointRow PositionControlRenderer::ControllerOf<kMech>::guideOf(const TickFrame& frame) const noexcept {
  JointRow guide{};
  for (int j = 0; frame.guide.size() == joints_ && j < joints_; ++j)
    if (frame.maxTorque[j] > 0.0) guide[j] = frame.guide[j];
  return guide;
}

// Give the last answer again.
template <int kMech>
void PositionControlRenderer::ControllerOf<kMech>::repeat(const Kinematics& now, const JointRow& guide,
                                                          TickOutput& output) const noexcept {
  output.mode = memory_.lastNormal > 0.0 ? RenderMode::contact : RenderMode::free;
  output.normalForce = memory_.lastNormal;
  output.torque.resize(joints_);
  for (int j = 0; j < joints_; ++j) output.torque[j] = now.gravity[j] + (memory_.sent[0][j] - guide[j]);
}

template <int kMech>
Status PositionControlRenderer::ControllerOf<kMech>::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& kin = frame.kinematics;
  Memory& m = memory_;
  const int n = joints_;
  if (kin.q.size() != n || frame.rows.count != frame.contacts.count) return Status::outOfRange;
  const double elapsed = frame.time - m.lastTime;
  const JointRow guide = guideOf(frame);
  output.saturated = false;
  output.cables = m.observer.cable;
  output.delay = delay().pending == 0 ? delay().low : -1;
  if (m.started != 0.0 && elapsed >= 0.0 && elapsed < kEarly * options_.period) {
    repeat(kin, guide, output);
    return Status::ok;
  }
  JointRow reading{};
  for (int j = 0; j < n; ++j) reading[j] = kin.q[j];
  if (m.started == 0.0 || elapsed < 0.0 || elapsed > kMostTicks * options_.period)
    start(frame, reading);
  else
    observe(frame, reading);
  m.lastTime = frame.time;
  if (m.doubts > kMostDoubts) return Status::outOfRange;  // no tool moves like this

  Ahead a;
  predict(frame, reading, a);
  addTorque(guide, a);
  Wall walls[kMostWalls];
  Target targets[kMostWalls];
  double force[kMaxWalls] = {};
  const double near = kNear * options_.scale;
  const int count = collectWalls(frame, a.modes, m.lastReading, m.walls, walls);
  const JointRow held = frictionTorque(frame, a.modes, walls, m.lastEstimate, m.friction);
  addTorque(held, a);
  act(a);
  double sum = 0.0;
  for (int k = 0; k < n; ++k) sum += a.modes.next[k] + a.modes.law.wouldBe[k];
  if (!std::isfinite(sum)) return Status::notFinite;
  const int placed = placeTargets(frame, a.modes, rebound(), near, walls, count, targets);
  if (placed > 0) contactForces(frame, a.modes, walls, targets, placed, force);
  const double given = share(frame, a, walls, targets, placed, force, output);
  JointRow torque = held;
  m.merged = 0.0;
  output.mode = RenderMode::free;
  output.normalForce = 0.0;
  for (int c = 0; c < frame.contacts.count; ++c)
    if (walls[c].gap <= near || frame.contacts.contacts[c].grip > 0.0) output.mode = RenderMode::contact;
  for (int i = 0; i < placed; ++i) {
    Wall& w = walls[targets[i].wall];
    w.force = force[i] *= given;
    if (!(force[i] > 0.0)) {
      m.merged += 1.0;
      if (targets[i].gap > 0.0) w.holds = 0.0;  // the hand would take the tool off
      continue;
    }
    output.mode = RenderMode::contact;
    if (w.contact == 0.0) output.normalForce = force[i];
    if (w.contact >= 0.0) output.normalForces[static_cast<std::size_t>(w.contact)] = force[i];
    for (int j = 0; j < n; ++j) torque[j] += force[i] * w.row[j];
  }
  m.walls.count = count;
  std::copy_n(walls, count, m.walls.wall.begin());
  output.torque.resize(n);
  for (int j = 0; j < n; ++j) {
    if (!std::isfinite(torque[j])) return Status::notFinite;
    output.torque[j] = kin.gravity[j] + torque[j];
  }
  output.saturated = saturate(output.torque, kin.gravity, frame.maxTorque) || output.saturated;
  m.lastReading = reading;
  m.lastNormal = output.normalForce;
  for (int i = kMaxLoopDelay; i > 0; --i) m.sent[i] = m.sent[i - 1];
  for (int j = 0; j < n; ++j)
    m.sent[0][j] = frame.maxTorque[j] > 0.0 ? output.torque[j] - kin.gravity[j] + guide[j] : 0.0;
  return Status::ok;
}

PositionControlRenderer::PositionControlRenderer(const PositionControlOptions& options) : period_(options.period) {
  checkPositionControl(options);
  if (options.drive.stiffness > 0.0)
    controller_ = std::make_unique<ControllerOf<4>>(options);
  else
    controller_ = std::make_unique<ControllerOf<2>>(options);
}

PositionControlRenderer::~PositionControlRenderer() = default;

PositionControlState PositionControlRenderer::state() const noexcept { return controller_->state(); }
Delay PositionControlRenderer::delay() const noexcept {
  const LoopDelay& d = controller_->delay();
  return {d.low, d.low + d.pending};
}
ControlledModes modesOf(const PositionControlRenderer& renderer) noexcept { return renderer.controller_->modes(); }

void PositionControlRenderer::prepare(double period) {
  if (period != period_)
    throw Error("position control: is for ticks of " + formatNumber(period_) + " s, the period here is " +
                formatNumber(period) + " s");
}

Status PositionControlRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  return controller_->render(frame, output);
}

void PositionControlRenderer::resetState() noexcept { controller_->reset(); }
Renderer::StateBlock PositionControlRenderer::stateBlock() noexcept { return controller_->stateBlock(); }
void PositionControlRenderer::stateLoaded() noexcept {
  if (!isFinite(stateBlock())) controller_->reset();
  controller_->stateLoaded();
}

}  // namespace enamel
