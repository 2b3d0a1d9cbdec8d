#include "enamel/render/position_control.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "enamel/collision/scene.hpp"
#include "enamel/core/cholesky.hpp"
#include "render/contact_forces.hpp"

namespace enamel {
namespace {

constexpr double kNear = 2e-5;  // a contact that stays this far outside for a tick carries no force, m
// Under a random delay a contact counts when the push alone would bring it that near within these ticks more, or after
// a jump the fall from a bounce: a command that is left out while the tool hovers is missed when it falls back.
constexpr double kHover = 3.0;
// There a command that acts more often than once sends the tool out: with what may yet act it stays below the outward
// speed by this many standard deviations. That speed is what the push turns back from the depth, at most this one, m,
// and beyond: a tool that is deep and waits for its commands falls on.
constexpr double kCautious = 1.5, kDeepest = 8e-4;
// A device lighter than the model hops no higher than this, m, for what its scale may yet turn out to be.
constexpr double kHop = 1e-4;
constexpr double kRegularisation = 1e-3;  // of the contact's own inverse inertia
// Largest force of a contact, of what all would need if each were alone: walls that face each other and are too near by
// a micrometre would push each other with hundreds of newtons, and hold the tool by friction. In a wedge of 30 deg it
// is 3.7.
constexpr double kMostShare = 5.0;
constexpr double kDivergedInnovation = 1e4;  // an innovation that no push explains, counts
constexpr double kRepeats = 3.0;   // counts that a tool must have moved for readings that repeat to be old ones
constexpr int kJumpDeadTicks = 3;  // ticks after a jump in which no other is looked for
// Every jump makes the next one need to be larger by this share, which fades by the other a tick: a loop with delay
// whose model is wrong would else take its own answers for jumps for ever, and nothing is learnt near a jump.
constexpr double kThresholdRise = 0.5, kThresholdRiseKept = 0.98;
// A jump just above the threshold may be none, and a strong answer to none throws the tool out of the wall: it has the
// full gains and outward speed from this much above, and at the threshold this share of the gains and no such speed.
constexpr double kFullGainExcess = 0.3, kThresholdGainShare = 0.2;
// Ages of a jump, ticks. An innovation needs a push that falls with the age squared, and weak pushes are rare: the
// density of the age falls with its 10th power, down to a floor, without which a weak push that has built up for some
// ticks passes for a strong new one, and the answer throws the tool out by half a millimetre. The innovation before has
// this deviation, of the threshold.
constexpr std::array<double, 17> kAges = {1.0,  1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35, 1.4,
                                          1.45, 1.5,  2.0, 2.5,  3.0, 4.0,  5.0, 6.0};
constexpr double kOldJumps = 1e-3, kAgeDeviation = 0.2;
// A hand that lets go does so over some ticks: a jump outward is a push that has been falling for these ticks, with
// this deviation of its growth, counts/tick^3. One that was a sudden step costs a little depth, and no bounce.
constexpr double kFallTicks = 1.5, kFall = 2.0;
// What stays of a push's growth from tick to tick: people do not press harder for ever.
constexpr double kGrowthKept = 0.95;
// An innovation that a scale wrong by this much explains may be the model's error: without, a model that is 30 % too
// heavy takes its own commands for jumps.
constexpr double kModelError = 0.15;

// Estimation of the scale: weight of the first guess (s = 1), what is forgotten in a tick, ticks after a jump in which
// nothing is learnt, largest innovation and slope, counts (an equation with a steeper slope is made smaller: what the
// model leaves out grows with the command). Less weight or steeper slopes learn a wrong scale from the first touch.
// What is slow is taken out of both, by a mean that follows with the last share: a press that grows, answered by a
// command that grows, else looks like a wrong scale (s at its lower end within 10 ticks, and a tool that hammers).
constexpr double kFirstWeight = 30.0, kForgotten = 1e-3, kLearnAfter = 8.0, kLargestInnovation = 3.0,
                 kLargestSlope = 1.0, kMeanFollows = 0.3;
// A tool at rest flickers by a count or two, which the servo answers, and nothing else moves: a correlation that tells
// of no inertia. A joint teaches in the ticks after its reading left a band of twice these counts.
constexpr double kRestBand = 1.25, kTeachingTicks = 5.0;
// A strong command, as after an impact, teaches at once. What it does to the joints must be this many times what a push
// may do in a tick: these counts, or this share of what the motors can.
constexpr double kStrongCommand = 3.0, kPushCounts = 10.0, kPushShare = 0.1;

void requireWithin(double value, double low, double high, const char* name, const char* unit) {
  require(value >= low && value <= high, std::string("position control: ") + name + " is " + formatNumber(value) +
                                             ", must be in " + formatNumber(low) + " to " + formatNumber(high) + unit);
}

double dot(const std::array<double, kMaxJoints>& a, const std::array<double, kMaxJoints>& b, int n) noexcept {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

// Mean of one over a jump's age in ticks, by the innovations along the contact now and before, counts. A push of age t
// has moved the tool by t^2 / 2, and by (t - 1)^2 / 2 a tick ago.
double inverseAgeOf(double now, double before, double deviation) noexcept {
  double weights = 0.0, sum = 0.0;
  for (const double age : kAges) {
    const double perAge = 1.0 / age, share = (1.0 - perAge) * (1.0 - perAge);
    const double miss = (before - share * now) / deviation;
    const double p2 = perAge * perAge, p4 = p2 * p2, weight = (p4 * p4 * p2 + kOldJumps) * std::exp(-0.5 * miss * miss);
    weights += weight;
    sum += weight * perAge;
  }
  return weights > 0.0 ? sum / weights : 1.0;
}

// Motion of the platform when the joints move by `way`.
Vec6 motionOf(const Kinematics& k, const std::array<double, kMaxJoints>& way) noexcept {
  return twistOf(k.jacobian, Eigen::Map<const JointVector>(way.data(), k.q.size()));
}

}  // namespace

// Inertia and gravity at a tick.
struct PositionControlRenderer::Inertia {
  int n;
  double perTick;  // T^2
  const Cholesky<kMaxJoints>& factors;
  Row gravity{};

  Inertia(const TickFrame& frame, double period) noexcept
      : n(static_cast<int>(frame.kinematics.q.size())), perTick(period * period), factors(frame.rows.inertia) {
    std::copy_n(frame.kinematics.gravity.data(), n, gravity.begin());
  }

  // T^2 M^-1 torque: what a torque beyond gravity does to the joints, rad/tick^2.
  Row response(Row torque) const noexcept {
    factors.solve(torque.data());
    for (int i = 0; i < n; ++i) torque[i] *= perTick;
    return torque;
  }

  // The same for torques with gravity.
  Row responseOf(Row torque) const noexcept {
    for (int i = 0; i < n; ++i) torque[i] -= gravity[i];
    return response(torque);
  }
};

// The frame's rows and responses along the normals, with time in ticks.
struct PositionControlRenderer::Normals {
  const ContactRow* rows;
  Row response[kMaxContacts];  // T^2 M^-1 D N_k^T

  Normals(const TickFrame& frame, double perTick) noexcept : rows(frame.rows.row.data()) {
    for (int c = 0; c < frame.rows.count; ++c)
      for (int i = 0; i < kMaxJoints; ++i) response[c][i] = rows[c].response[i] * perTick;
  }
};

// The contacts that may carry force, as the quadratic program sees them.
struct PositionControlRenderer::Pushing {
  ContactProblem problem;
  int contact[kMaxActiveContacts];  // number in the snapshot
  ContactSolution solution;
};

// Joints and push when the command of this tick acts.
struct PositionControlRenderer::Ahead {
  Row q, rate, push;
  Row byCommands{};  // of the rate: what commands under way will have brought
};

const std::array<PositionControlParameter, 13>& positionControlParameters() noexcept {
  using O = PositionControlOptions;
  static constexpr std::array<PositionControlParameter, 13> parameters = {{
      {"pole", &O::pole, 0.0, 0.999, ""},
      {"damping", &O::damping, 0.0, 10.0, ""},
      {"jump_pole", &O::jumpPole, 0.0, 0.999, ""},
      {"jump_ticks", &O::jumpTicks, 0.0, 24.0, " ticks"},
      {"outward_speed", &O::outwardSpeed, 0.0, 1.0, " m/s"},
      {"outward_distance", &O::outwardDistance, 0.0, 0.01, " m"},
      {"tremor", &O::tremor, 0.0, 1e3, " counts/tick^2"},
      {"wander", &O::wander, 1e-6, 1e3, " counts/tick^2"},
      {"growth", &O::growth, 0.0, 1e3, " counts/tick^3"},
      {"jump_threshold", &O::jumpThreshold, 1.0, 1e6, " counts"},
      {"jump_age", &O::jumpAge, 0.0, 0.999, " ticks"},
      {"jump_size", &O::jumpSize, 0.0, 1e4, " counts/tick^2"},
      {"jump_growth", &O::jumpGrowth, 0.0, 1e4, " counts/tick^3"},
  }};
  return parameters;
}

PositionControlOptions positionControlFor(const JointVector& encoderStep, double period, int delayLow, int delayHigh) {
  // In the order of positionControlParameters(), for delays of 1, 2 and 3 ticks and for random ones of 0 to 3.
  static constexpr double values[4][13] = {
      {0.3775, 0.9812, 0.1465, 5.978, 0.002585, 2.114e-5, 0.5505, 0.275, 0.01, 5.035, 0.95, 59.31, 0.25},
      {0.4596, 0.8894, 0.6415, 8.609, 0.003, 8e-6, 0.55, 0.17, 0.006, 6.095, 0.6458, 162.8, 0.3},
      {0.5217, 0.9228, 0.6563, 6.432, 0.008, 2.5e-5, 0.5427, 0.055, 0.004, 5.028, 0.5619, 12.26, 0.03},
      {0.5, 1.15, 0.3, 6.0, 0.08, 3e-5, 0.5427, 0.1, 0.004, 4.0, 0.95, 12.0, 0.03},
  };
  PositionControlOptions options;
  options.period = period;
  options.encoderStep = encoderStep;
  options.delayLow = delayLow;
  options.delayHigh = delayHigh;
  options.horizon = (delayLow + delayHigh) / 2;
  if (delayHigh <= 0) return options;
  const double* row = values[delayLow < delayHigh ? 3 : std::min(delayHigh, 3) - 1];
  for (const PositionControlParameter& p : positionControlParameters()) options.*p.value = *row++;
  return options;
}

PositionControlRenderer::PositionControlRenderer(const PositionControlOptions& o)
    : options_(o), joints_(static_cast<int>(o.encoderStep.size())) {
  require(joints_ >= 1, "position control: no encoder count is given");
  for (int i = 0; i < joints_; ++i) requireWithin(o.encoderStep[i], 1e-12, 1.0, "an encoder's count", " rad or m");
  requireWithin(o.delayLow, 0, o.delayHigh, "the smallest delay", " ticks");
  requireWithin(o.delayHigh, 0, kMaxLoopDelay, "the largest delay", " ticks");
  requireWithin(o.horizon, 0, kMaxLoopDelay, "the horizon", " ticks");
  requireWithin(o.period, 1e-5, 0.1, "the period", " s");
  for (const PositionControlParameter& p : positionControlParameters())
    requireWithin(o.*p.value, p.low, p.high, p.name, p.unit);
}

// The observer's gains, in counts and ticks: position x, rate v, push a and its growth b, x'' = a, a' = b, encoder
// counts of variance 1/12.
void PositionControlRenderer::prepare(double period) {
  require(std::abs(period - options_.period) <= 1e-9 * options_.period,
          "position control: activated for a period of " + formatNumber(period) + " s, but it was designed for " +
              formatNumber(options_.period) + " s");
  using Mat4 = Eigen::Matrix4d;
  using Vec4 = Eigen::Vector4d;
  constexpr double kCountVariance = 1.0 / 12.0;
  Mat4 F;
  F << 1.0, 1.0, 0.5, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, kGrowthKept;
  const Vec4 kick(0.5, 1.0, 0.0, 0.0);
  Mat4 Q = options_.tremor * options_.tremor * kick * kick.transpose();
  Q(2, 2) += options_.wander * options_.wander;
  Q(3, 3) += options_.growth * options_.growth;
  Mat4 P = Mat4::Identity();  // covariance before a measurement
  const auto gainOf = [](const Mat4& prior) { return Vec4(prior.col(0) / (prior(0, 0) + kCountVariance)); };
  const auto advance = [&](const Mat4& prior) {
    const Vec4 gain = gainOf(prior);
    const Mat4 left = Mat4::Identity() - gain * Vec4::UnitX().transpose();
    const Mat4 after = left * prior * left.transpose() + kCountVariance * gain * gain.transpose();
    return Mat4(F * after * F.transpose() + Q);
  };
  constexpr int kEnough = 5000;  // far beyond the slowest filter's memory
  for (int i = 0; i < kEnough; ++i) P = advance(P);
  if (isRandom()) {
    lateGain_ = lateGain(options_.pole);
    lateJumpGain_ = lateGain(options_.jumpPole);
  }
  const double slow = std::sqrt(P(0, 0) + kCountVariance);
  const auto scheduleFrom = [&](Mat4 prior) {
    Schedule schedule;
    for (int tick = 0; tick <= kSchedule; ++tick) {
      if (tick == kSchedule) prior = P;
      const Vec4 gain = gainOf(prior);
      schedule.gains[tick] = {gain[0], gain[1], gain[2], gain[3]};
      schedule.deviations[tick] = std::sqrt(prior(0, 0) + kCountVariance) / slow;
      prior = advance(prior);
    }
    return schedule;
  };
  // A push that began t ticks ago, t uniform in jumpAge to 1, has moved by a (t^2/2, t, 1).
  const double age = options_.jumpAge;
  const auto moment = [age](int k) { return (1.0 - std::pow(age, k + 1)) / ((k + 1) * (1.0 - age)); };
  Mat3 jump;
  jump << moment(4) / 4, moment(3) / 2, moment(2) / 2, moment(3) / 2, moment(2), moment(1), moment(2) / 2, moment(1), 1;
  Mat4 pushed = P;
  pushed.topLeftCorner<3, 3>() += options_.jumpSize * options_.jumpSize * jump;
  pushed(3, 3) += options_.jumpGrowth * options_.jumpGrowth;
  inwardSchedule_ = scheduleFrom(pushed);
  // Without a sample the covariance grows, and so do the gains of the next one.
  Mat4 missed = P;
  for (int tick = 0; tick <= kMostMissing; ++tick) {
    const Vec4 gain = gainOf(missed);
    missed_.gains[tick] = {gain[0], gain[1], gain[2], gain[3]};
    missed_.deviations[tick] = std::sqrt(missed(0, 0) + kCountVariance) / slow;
    missed = F * missed * F.transpose() + Q;
  }
  const Vec4 fall(kFallTicks * kFallTicks * kFallTicks / 6.0, kFallTicks * kFallTicks / 2.0, kFallTicks, 1.0);
  outwardSchedule_ = scheduleFrom(P + kFall * kFall * fall * fall.transpose());
}

// The gains that minimise the expected sum of g^2 + weight g'^2 + price w^2, where each of the last commands w acts by
// chance (de Koning, Infinite horizon optimal control of linear discrete time systems with stochastic parameters,
// Automatica 1982), on the gap g, its rate, and what the commands that wait would do. In continuous time and without
// delay they are the double pole's k1 and k2 for a damping of at least 1 / sqrt(2).
PositionControlRenderer::LateGain PositionControlRenderer::lateGain(double pole) const {
  constexpr int kMost = 2 + kMaxLoopDelay;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
  const int n = 2 + options_.delayHigh;
  const double likely = 1.0 / delays();
  const double stiffness = (1.0 - pole) * (1.0 - pole), price = 1.0 / (stiffness * stiffness);
  Matrix Q = Matrix::Zero(n, n);
  Q(0, 0) = 1.0;
  Q(1, 1) = std::max(0.0, 4.0 * options_.damping * options_.damping - 2.0) / stiffness;
  Matrix P = Q;
  Vector gain = Vector::Zero(n);
  constexpr int kMostSteps = 20000;
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix APA = Matrix::Zero(n, n);
    Vector BPA = Vector::Zero(n);
    double BPB = 0.0;
    for (int delay = options_.delayLow; delay <= options_.delayHigh; ++delay) {
      Matrix A = Matrix::Zero(n, n);
      Vector B = Vector::Zero(n);
      A(0, 0) = A(0, 1) = A(1, 1) = 1.0;
      B[2] = 1.0;
      for (int k = 3; k < n; ++k) A(k, k - 1) = 1.0;
      (delay == 0 ? B[0] : A(0, 1 + delay)) = 0.5;
      (delay == 0 ? B[1] : A(1, 1 + delay)) = 1.0;
      APA += likely * A.transpose() * P * A;
      BPA += likely * A.transpose() * (P * B);
      BPB += likely * B.dot(P * B);
    }
    const Vector before = gain;
    gain = BPA / (price + BPB);
    P = Q + APA - BPA * gain.transpose();
    // A command that acts after `delayLow` ticks at the earliest has no price before.
    if (step > options_.delayLow && (gain - before).norm() <= 1e-12 * gain.norm()) break;
  }
  LateGain late{};
  std::copy_n(gain.data(), n, late.begin());
  return late;
}

void PositionControlRenderer::stateLoaded() noexcept {
  if (!isFinite(stateBlock()) ||
      !(state_.sinceJump >= 0.0 && state_.sinceJump <= kSchedule && state_.recentJumps >= 0.0) ||
      !(state_.missing >= 0.0 && state_.missing <= kMostMissing) ||
      !(state_.jumpProbability >= 0.0 && state_.jumpProbability <= 1.0) ||
      !(state_.scale >= kLowestScale && state_.scale <= kHighestScale))
    resetState();
}

void PositionControlRenderer::Motion::advance(int joint, double byTorque, double ticks) noexcept {
  const double acceleration = byTorque + push[joint];
  q[joint] += ticks * (rate[joint] + 0.5 * ticks * acceleration);
  rate[joint] += ticks * acceleration;
  push[joint] += ticks * growth[joint];
  growth[joint] *= ticks == 1.0 ? kGrowthKept : std::pow(kGrowthKept, ticks);
}

void PositionControlRenderer::Motion::correct(int joint, const Gain& gain, double innovation) noexcept {
  q[joint] += gain[0] * innovation;
  rate[joint] += gain[1] * innovation;
  push[joint] += gain[2] * innovation;
  growth[joint] += gain[3] * innovation;
}

void PositionControlRenderer::start(const TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  State fresh;
  fresh.scale = state_.scale;
  fresh.information = state_.information;
  fresh.jumps = state_.jumps;
  fresh.started = 1.0;
  for (int i = 0; i < joints_; ++i) {
    fresh.estimate.q[i] = fresh.lastAngles[i] = fresh.lastReading[i] = fresh.rest[i] = k.q[i];
    fresh.lastRates[i] = k.rates[i];
    fresh.sinceMoved[i] = kTeachingTicks;
    fresh.estimate.rate[i] = k.rates[i] * options_.period;
    for (Row& command : fresh.commands) command[i] = k.gravity[i];
  }
  state_ = fresh;
}

// Prediction of observer and derivatives by `ticks` under a torque.
void PositionControlRenderer::advance(const Row& torque, const Inertia& inertia, double ticks) noexcept {
  State& s = state_;
  const Row response = inertia.responseOf(torque);
  const Row expected = isRandom() ? inertia.responseOf(underWay(-1).torque) : Row{};
  for (int i = 0; i < joints_; ++i) {
    s.estimate.advance(i, s.scale * response[i], ticks);
    s.sensitivity.advance(i, response[i], ticks);
    s.instrument.advance(i, response[i] - expected[i], ticks);
  }
}

// Ticks that never came: the last command acted on. Leaves of `ticks` what has passed since.
void PositionControlRenderer::passOver(const TickFrame& frame, const Inertia& inertia, double& ticks) noexcept {
  for (; ticks >= 1.5; ticks -= 1.0) {
    advance(acted(frame), inertia, 1.0);
    rememberCommand(Row(state_.commands[0]));
    state_.missing += 1.0;
  }
}

// Whether a device gave its last sample again: not a bit has changed, though the tool has moved by counts.
bool PositionControlRenderer::isRepeated(const Kinematics& k) const noexcept {
  const State& s = state_;
  bool moved = false;
  for (int i = 0; i < joints_; ++i) {
    if (k.q[i] != s.lastReading[i] || k.rates[i] != s.lastRates[i]) return false;
    moved = moved || std::abs(s.estimate.q[i] + s.estimate.rate[i] - k.q[i]) > kRepeats * options_.encoderStep[i];
  }
  return moved && s.missing < kMostMissing;
}

void PositionControlRenderer::rememberCommand(const Row& command) noexcept {
  for (int d = kMaxLoopDelay; d > 0; --d) state_.commands[d] = state_.commands[d - 1];
  state_.commands[0] = command;
}

// Of the commands that were given, what may act `ahead` ticks from now, each delay being as likely.
PositionControlRenderer::UnderWay PositionControlRenderer::underWay(int ahead) const noexcept {
  UnderWay sum;
  const double likely = 1.0 / delays();
  for (int delay = std::max(options_.delayLow, ahead + 1); delay <= options_.delayHigh; ++delay) {
    for (int i = 0; i < joints_; ++i) sum.torque[i] += likely * state_.commands[delay - ahead - 1][i];
    sum.share += likely;
  }
  return sum;
}

// The torque that has acted since the last tick.
PositionControlRenderer::Row PositionControlRenderer::acted(const TickFrame& frame) const noexcept {
  if (!frame.applied) return underWay(-1).torque;
  Row torque{};
  for (int i = 0; i < joints_; ++i) torque[i] = (*frame.applied)[i];
  return torque;
}

PositionControlRenderer::Jump PositionControlRenderer::jumpOf(int contacts, const Normals& normals,
                                                              const Row& innovation) const noexcept {
  const State& s = state_;
  if (s.sinceJump < kJumpDeadTicks) return {};
  const double deviation = (1.0 + kThresholdRise * s.recentJumps) *
                           scheduleNow().deviations[static_cast<int>(s.sinceJump)] *
                           missed_.deviations[static_cast<int>(s.missing)];
  Row now{}, last{}, sensitivity{};  // counts
  for (int i = 0; i < joints_; ++i) {
    const double count = options_.encoderStep[i];
    now[i] = innovation[i] / count;
    last[i] = s.lastInnovation[i] / count;
    sensitivity[i] = s.sensitivity.q[i] / count;
  }
  double strongest = 0.0, before = 0.0, over = 0.0;
  bool outward = false;
  for (int c = 0; c < contacts; ++c) {
    Row direction = normals.response[c];
    for (int i = 0; i < joints_; ++i) direction[i] /= options_.encoderStep[i];
    const double size = std::sqrt(dot(direction, direction, joints_));
    const double along = dot(direction, now, joints_);
    const double threshold =
        options_.jumpThreshold * deviation * size + kModelError * std::abs(dot(direction, sensitivity, joints_));
    if (std::abs(along) > threshold && std::abs(along) > strongest * size) {
      strongest = std::abs(along) / size;
      before = std::copysign(1.0, along) * dot(direction, last, joints_) / size;
      over = std::abs(along) / threshold - 1.0;
      outward = along > 0.0;
    }
  }
  if (strongest == 0.0) return {};
  const double inverseAge = outward ? 1.0 : inverseAgeOf(strongest, before, kAgeDeviation * options_.jumpThreshold);
  return {true, outward, std::min(over / kFullGainExcess, 1.0), inverseAge};
}

// The scale as one more state of the observer: a wrong one has moved the others, and explains the innovation. `most`:
// what the motors can move the joints by in a tick, counts.
void PositionControlRenderer::learnFromStrongCommand(double most, Row& innovation) noexcept {
  State& s = state_;
  double slopes = 0.0, slopeTimesError = 0.0;  // counts^2
  for (int i = 0; i < joints_; ++i) {
    const double count = options_.encoderStep[i], slope = s.sensitivity.q[i] / count;
    slopes += slope * slope;
    slopeTimesError += slope * innovation[i] / count;
  }
  const double pushed = std::max(kPushCounts, kPushShare * most), weight = 1.0 / (pushed * pushed), before = s.scale;
  if (!(slopes * weight >= kStrongCommand * kStrongCommand)) return;
  s.information += weight * slopes;
  s.scale = std::clamp(before + weight * slopeTimesError / (kFirstWeight + s.information), kLowestScale, kHighestScale);
  const double change = s.scale - before;
  for (int i = 0; i < joints_; ++i) {
    s.estimate.q[i] += change * s.sensitivity.q[i];
    s.estimate.rate[i] += change * s.sensitivity.rate[i];
    s.estimate.push[i] += change * s.sensitivity.push[i];
    s.estimate.growth[i] += change * s.sensitivity.growth[i];
    innovation[i] -= change * s.sensitivity.q[i];
  }
}

void PositionControlRenderer::observe(const TickFrame& frame, const Inertia& inertia, const Normals& normals,
                                      double ticks) noexcept {
  State& s = state_;
  const int n = joints_;
  const Row torque = acted(frame), response = inertia.responseOf(torque);
  advance(torque, inertia, ticks);
  Row innovation{};
  double strength = 0.0, moved = 0.0;  // share of the motors' limits; counts^2 in this tick
  bool diverged = false;
  for (int i = 0; i < n; ++i) {
    innovation[i] = frame.kinematics.q[i] - s.estimate.q[i];
    if (frame.maxTorque[i] > 0.0)
      strength = std::max(strength, std::abs(torque[i] - inertia.gravity[i]) / frame.maxTorque[i]);
    moved += 0.25 * response[i] * response[i] / (options_.encoderStep[i] * options_.encoderStep[i]);
    diverged = diverged || !(std::abs(innovation[i]) < kDivergedInnovation * options_.encoderStep[i]);
  }
  if (diverged) return start(frame);
  if (strength > 0.0) learnFromStrongCommand(std::sqrt(moved) / strength, innovation);
  const Jump jump = jumpOf(frame.contacts.count, normals, innovation);
  s.jumpProbability = jump.seen ? jump.probability : 1.0;
  s.recentJumps *= kThresholdRiseKept;
  if (jump.seen) {
    s.sinceJump = 0.0;
    s.lastJumpOutward = jump.outward ? 1.0 : 0.0;
    s.jumps += 1.0;
    s.recentJumps += 1.0;
  } else {
    s.sinceJump = std::min<double>(s.sinceJump + 1.0, kSchedule);
  }
  const Schedule& schedule = scheduleNow();
  Gain gain = schedule.gains[static_cast<int>(s.sinceJump)];
  if (s.sinceJump == kSchedule && s.missing > 0.0) gain = missed_.gains[static_cast<int>(s.missing)];
  if (jump.seen) {
    gain[1] *= jump.inverseAge;
    gain[2] *= jump.inverseAge * jump.inverseAge;
    gain[3] *= jump.inverseAge * jump.inverseAge;
    const double share = kThresholdGainShare + (1.0 - kThresholdGainShare) * jump.probability;
    for (int i = 0; i < 4; ++i)
      gain[i] = schedule.gains[kSchedule][i] + share * (gain[i] - schedule.gains[kSchedule][i]);
  }
  double slopeTimesError = 0.0, slopes = 0.0;
  for (int i = 0; i < n; ++i) {
    const double e = innovation[i], count = options_.encoderStep[i];
    const double quickError = e - s.meanInnovation[i], quickSlope = s.instrument.q[i] - s.meanInstrument[i];
    s.meanInnovation[i] += kMeanFollows * quickError;
    s.meanInstrument[i] += kMeanFollows * quickSlope;
    const double weight = std::min(1.0, kLargestSlope * count / std::abs(quickSlope));
    const double reading = frame.kinematics.q[i], band = kRestBand * count;
    const double rest = std::clamp(s.rest[i], reading - band, reading + band);
    s.sinceMoved[i] = rest != s.rest[i] ? 0.0 : std::min(s.sinceMoved[i] + 1.0, kTeachingTicks);
    s.rest[i] = rest;
    const double slope = s.sinceMoved[i] < kTeachingTicks ? weight * quickSlope / count : 0.0;
    slopeTimesError += slope * std::clamp(weight * quickError / count, -kLargestInnovation, kLargestInnovation);
    slopes += slope * slope;
    s.estimate.correct(i, gain, e);
    s.sensitivity.correct(i, gain, -s.sensitivity.q[i]);
    s.instrument.correct(i, gain, -s.instrument.q[i]);
  }
  if (s.pushes != 0.0 && s.sinceJump > kLearnAfter) {
    s.information = (1.0 - kForgotten) * s.information + slopes;
    s.scale = std::clamp(s.scale + slopeTimesError / (kFirstWeight + s.information), kLowestScale, kHighestScale);
  }
  s.lastInnovation = innovation;
  s.missing = 0.0;
}

// What is yet to be commanded balances the push: it accelerates nothing.
PositionControlRenderer::Ahead PositionControlRenderer::predict(const Inertia& inertia) const noexcept {
  Ahead a{state_.estimate.q, state_.estimate.rate, state_.estimate.push};
  Row growth = state_.estimate.growth;
  for (int ahead = 0; ahead < options_.horizon; ++ahead) {
    UnderWay commands = underWay(ahead);
    for (int i = 0; i < joints_; ++i) commands.torque[i] -= commands.share * inertia.gravity[i];
    const Row response = inertia.response(commands.torque);
    for (int i = 0; i < joints_; ++i) {
      const double own = state_.scale * response[i], acceleration = own + commands.share * a.push[i];
      a.byCommands[i] += own;
      a.q[i] += a.rate[i] + 0.5 * acceleration;
      a.rate[i] += acceleration;
      a.push[i] += growth[i];
      growth[i] *= kGrowthKept;
    }
  }
  return a;
}

PositionControlRenderer::Pushing PositionControlRenderer::pushing(const TickFrame& frame, const Inertia& inertia,
                                                                  const Normals& normals,
                                                                  const Ahead& ahead) const noexcept {
  const State& s = state_;
  const int n = joints_;
  const bool random = isRandom(), jumps = s.sinceJump < options_.jumpTicks;
  const double T = options_.period, z = jumps ? options_.jumpPole : options_.pole;
  // All that the scale may be, until it is learnt.
  const double doubt = (kHighestScale - 1.0) * kFirstWeight / (kFirstWeight + s.information);
  const LateGain& late = jumps ? lateJumpGain_ : lateGain_;
  const double k1 = random ? late[0] : (1.0 - z) * (1.0 - z);
  const double k2 = random ? late[1] : 0.5 * options_.damping * (1.0 - z) * (3.0 + z);
  Row wayNow{}, way{};
  for (int i = 0; i < n; ++i) {
    wayNow[i] = s.estimate.q[i] - frame.kinematics.q[i];
    way[i] = ahead.q[i] - frame.kinematics.q[i];
  }
  const double likely = 1.0 / delays(), cautious = 1.0 + kCautious * std::sqrt(1.0 - likely);
  Row waiting[kMaxLoopDelay];  // what each command that may yet act does to the joints
  for (int i = 0; random && i < options_.delayHigh; ++i) waiting[i] = inertia.responseOf(s.commands[i]);

  Pushing pushing;
  ContactProblem& p = pushing.problem;
  double alone = 0.0;  // of each contact as if there were no other, their sum, N
  for (int c = 0; c < frame.contacts.count && p.contacts < kMaxActiveContacts; ++c) {
    const Contact& contact = frame.contacts.contacts[c];
    const Row& row = normals.rows[c].normal;
    const double obstacle = T * contact.normal.dot(contact.obstacleVelocity);
    const double gap = contact.gap + dot(row, way, n) - (options_.horizon + s.missing) * obstacle;
    const double speed = dot(row, ahead.rate, n) - obstacle, pushed = dot(row, ahead.push, n);
    const double falling = s.sinceJump < kSchedule ? speed : std::max(0.0, speed);  // back from a bounce, or towards it
    const bool hovers = random && gap + kHover * falling + 0.5 * kHover * kHover * pushed < kNear;
    if (gap + speed + 0.5 * pushed > kNear && !hovers) continue;
    const double turned = options_.outwardDistance + (random ? std::clamp(-gap, 0.0, kDeepest) : 0.0);
    const double outward =
        T * options_.outwardSpeed + std::sqrt(2.0 * std::max(0.0, -pushed) * s.jumpProbability * turned);
    const int m = p.contacts++;
    pushing.contact[m] = c;
    for (int other = 0; other <= m; ++other)
      p.G[m][other] = p.G[other][m] = s.scale * dot(row, normals.response[pushing.contact[other]], n);
    // The speed's limit is on what the force does to the device, whatever gives way beside it.
    const double rigid = (1.0 + kRegularisation) * p.G[m][m];
    p.G[m][m] = rigid + k1 / contact.material.stiffness;
    double wish = -k1 * gap - k2 * speed - pushed;
    const double hop = std::sqrt(2.0 * std::max(0.0, -pushed) * kHop);
    double most =
        std::min(outward - speed, (outward + hop - speed - doubt * dot(row, ahead.byCommands, n)) / (1.0 + doubt)) -
        pushed;
    if (random) {  // from where the tool is now; a pull is not relied upon to stop it
      const double push = dot(row, s.estimate.push, n), pressed = std::min(0.0, push);
      const double rate = dot(row, s.estimate.rate, n) - obstacle;
      double sent = 0.0, variance = 0.0;  // rate that commands under way will bring
      wish = -k1 * (contact.gap + dot(row, wayNow, n) - s.missing * obstacle) - k2 * rate - push;
      for (int i = 0; i < options_.delayHigh; ++i) {
        const double response = s.scale * dot(row, waiting[i], n), beyond = response + pressed;
        const double acts = likely * std::min(delays(), options_.delayHigh - i);
        wish -= late[2 + i] * (response + push);
        sent += acts * beyond;
        variance += acts * (1.0 - likely) * beyond * beyond;
      }
      most = (outward - rate - sent - kCautious * std::sqrt(variance)) / cautious - pressed;
    }
    p.r[m] = std::min(wish, most * p.G[m][m] / rigid);
    alone += std::max(0.0, p.r[m] / p.G[m][m]);
  }
  if (alone > 0.0) p.most = std::min(p.most, kMostShare * alone);
  p.motors = n;
  for (int i = 0; i < n; ++i) {
    const bool isDriven = frame.maxTorque[i] > 0.0;
    for (int m = 0; m < p.contacts; ++m) p.motor[i][m] = !isDriven ? 0.0 : normals.rows[pushing.contact[m]].normal[i];
    p.low[i] = std::min(0.0, -frame.maxTorque[i] - inertia.gravity[i]);
    p.high[i] = std::max(0.0, frame.maxTorque[i] - inertia.gravity[i]);
    if (!isDriven) p.low[i] = p.high[i] = 0.0;
  }
  pushing.solution = solveContacts(p);
  return pushing;
}

// Friction at the contacts that carry force, as torques; the normal forces are found anew beside it.
PositionControlRenderer::Row PositionControlRenderer::addFriction(const TickFrame& frame, const Inertia& inertia,
                                                                  const Normals& normals, const Ahead& ahead,
                                                                  double sinceSample, Pushing& pushing) noexcept {
  const Kinematics& k = frame.kinematics;
  // Slower than the wall's: what sticks need not stand at the edge, and counts are felt less. A firmer grip creeps:
  // what a light tool goes while it hops is then more than the load holds.
  const double T = options_.period, z = 0.6 + 0.4 * options_.pole;
  Row moved{}, toCome{}, torque{};
  for (int i = 0; i < joints_; ++i) {
    moved[i] = k.q[i] - state_.lastAngles[i];
    state_.lastAngles[i] = k.q[i];
    toCome[i] = ahead.q[i] - k.q[i];
  }
  const Vec6 way = motionOf(k, moved), wayAhead = motionOf(k, toCome), velocity = motionOf(k, ahead.rate) / T;
  ContactProblem& problem = pushing.problem;
  state_.friction.begin();
  bool any = false;
  int solved = 0;
  for (int index = 0; index < frame.contacts.count; ++index) {
    const Contact& contact = frame.contacts.contacts[index];
    // One that is not near carries nothing, but may do so again at once: a light tool hops.
    const bool near = solved < problem.contacts && pushing.contact[solved] == index;
    const double normalForce = near ? pushing.solution.force[solved++] : 0.0;
    if (!(contact.material.friction > 0.0)) continue;
    any = any || normalForce > 0.0;
    // The largest inverse inertia along the surface.
    const ContactRow& row = normals.rows[index];
    const Row &first = row.tangent[0], &second = row.tangent[1];
    const double a = dot(first, row.tangentResponse[0], joints_), b = dot(second, row.tangentResponse[0], joints_),
                 c = dot(second, row.tangentResponse[1], joints_);
    const double largest = state_.scale * inertia.perTick * (0.5 * (a + c) + std::hypot(0.5 * (a - c), b));
    const TangentialGains gains{(1.0 - z) * (1.0 - z) / largest,
                                0.5 * T * options_.damping * (1.0 - z) * (3.0 + z) / largest};
    const Vec3 arm = contact.point - k.pose.position;
    const SurfaceMotion slide{
        translationAt(way, arm) - sinceSample * T * contact.obstacleVelocity,
        translationAt(wayAhead, arm) - (options_.horizon + state_.missing) * T * contact.obstacleVelocity,
        translationAt(velocity, arm) - contact.obstacleVelocity};
    const Vec3 force = state_.friction.force(contact, slide, gains, normalForce);
    const double along[2] = {row.axes.col(0).dot(force), row.axes.col(1).dot(force)};
    for (int i = 0; i < joints_; ++i) torque[i] += along[0] * first[i] + along[1] * second[i];
  }
  state_.friction.end();
  if (!any) return torque;
  for (int m = 0; m < problem.contacts; ++m)
    problem.r[m] -= state_.scale * dot(normals.response[pushing.contact[m]], torque, joints_);
  for (int i = 0; i < joints_; ++i) {
    problem.low[i] = std::min(0.0, problem.low[i] - torque[i]);
    problem.high[i] = std::max(0.0, problem.high[i] - torque[i]);
  }
  pushing.solution = solveContacts(problem);
  return torque;
}

Status PositionControlRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& k = frame.kinematics;
  if (k.q.size() != joints_ || frame.rows.count != frame.contacts.count) return Status::outOfRange;
  const Inertia inertia(frame, options_.period);
  const Normals normals(frame, inertia.perTick);
  State& s = state_;
  double ticks = (frame.time - s.lastTime) / options_.period;  // since the last one
  if (std::abs(ticks - 1.0) < 1e-6) ticks = 1.0;
  double sinceSample = 0.0;  // ticks; 0 without a new one
  if (s.started == 0.0 || ticks > kMostMissing || s.missing + ticks > kMostMissing + 0.5) {
    start(frame);
  } else {
    passOver(frame, inertia, ticks);
    if (frame.age > 0 || isRepeated(k)) {
      advance(acted(frame), inertia, ticks);
      s.missing = std::min(s.missing + 1.0, double{kMostMissing});
    } else {
      sinceSample = s.missing + ticks;
      observe(frame, inertia, normals, ticks);
      for (int i = 0; i < joints_; ++i) {
        s.lastReading[i] = k.q[i];
        s.lastRates[i] = k.rates[i];
      }
    }
  }
  s.lastTime = frame.time;

  const Ahead ahead = predict(inertia);
  Pushing found = pushing(frame, inertia, normals, ahead);
  Row torque = addFriction(frame, inertia, normals, ahead, sinceSample, found);

  output.mode = RenderMode::free;
  output.saturated = found.solution.limited;
  for (int m = 0; m < found.problem.contacts; ++m) {
    const double force = found.solution.force[m];
    if (force > 0.0) output.mode = RenderMode::contact;
    if (found.contact[m] == 0) output.normalForce = force;
    for (int i = 0; i < joints_; ++i) torque[i] += force * normals.rows[found.contact[m]].normal[i];
  }
  s.pushes = output.mode == RenderMode::contact ? 1.0 : 0.0;
  output.torque.resize(joints_);
  bool finite = true;
  for (int i = 0; i < joints_; ++i) {
    finite = finite && std::isfinite(torque[i]);
    for (const Motion* m : {&s.estimate, &s.sensitivity, &s.instrument})
      finite = finite && std::isfinite(m->q[i] + m->rate[i] + m->push[i] + m->growth[i]);
  }
  if (!finite) return Status::notFinite;  // numbers that are finite one by one can overflow together
  for (int i = 0; i < joints_; ++i) output.torque[i] = k.gravity[i] + torque[i];
  output.saturated = saturate(output.torque, k.gravity, frame.maxTorque) || output.saturated;
  Row command{};
  for (int i = 0; i < joints_; ++i)
    if (frame.maxTorque[i] > 0.0) command[i] = output.torque[i];
  rememberCommand(command);
  return Status::ok;
}

}  // namespace enamel
