// Energy accounts of the guard: one from its own commands, one from the torque that the device reports.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "device/inertia.hpp"
#include "enamel/render/guard.hpp"
#include "render/exponential.hpp"
#include "render/mode_table.hpp"

namespace enamel {
namespace {

constexpr double kForgets = 0.2;        // s, decay time of the largest recent force
constexpr double kLeastForce = 1e-3;    // N; smaller forces count as zero
constexpr double kLargestEnergy = 1e6;  // J
constexpr double kTorqueError = 0.05;   // share of the largest torque of a motor: deviation of its errors in a tick
constexpr double kPushChange = 0.001;   // the same of the change of the hand's push in a tick
constexpr double kMisfitTime = 0.1;     // s, of the mean of the squared errors of prediction
constexpr double kSure = 3.0;           // standard deviations by which this mean must exceed the model's value
// Models over the learnt stiffness of cables: even steps of its logarithm.
constexpr int kOfFile = 5, kStiffnesses = 2 * kOfFile + 1;
constexpr double kStiffnessStep = 0.1;
constexpr double kLever = 0.05;  // m, lever that converts a moment to a force
// Reported torque: filter time, s; least share of the commands' power; noise and maximum, of the motor's limit.
constexpr double kReportTime = 0.01, kReportShare = 0.75, kReportNoise = 0.03, kLargestReport = 1.5;

// Covariance of the prediction by a Kalman filter in the steady state: x becomes A x with noise Q, and each reading is
// x[read] with variance R. Doubling: B. Anderson, "Second-order convergent algorithms for the steady-state Riccati
// equation", 1978.
template <int n>
Matrix<n> steadyCovariance(const Matrix<n>& A, const Matrix<n>& Q, int read, double R) {
  constexpr int kMostDoublings = 60;
  Matrix<n> a = A.transpose(), b = Matrix<n>::Zero(), P = Q;
  b(read, read) = 1.0 / R;
  for (int i = 0; i < kMostDoublings; ++i) {
    const Matrix<n> left = (Matrix<n>::Identity() + b * P).inverse(), step = a.transpose() * P * left * a;
    b = (b + a * left * b * a.transpose()).eval();
    a = (a * left * a).eval();
    P += step;
    if (step.norm() <= 1e-14 * P.norm()) break;
  }
  return P;
}

}  // namespace

// Modes of the links, and the gains of their Kalman filters (lib/docs/guard.md). A filter starts with exact states.
Guard::Modes Guard::modesOf(const Mechanism& device, const Drive& d) const {
  Modes modes;
  JointMatrix links = device.home().inertia, axes;
  links.diagonal().array() -= d.rotorInertia;
  const JointVector inertia = eigenvaluesOf(links, axes);
  require(inertia.minCoeff() > 0.0, "guard: the inertia of the links without the rotors is not positive definite");
  for (int k = 0; k < n_; ++k) {
    const ModeMotion<4> motion = modeMotion<4>(d, inertia[k], options_.period);
    Mode& mode = modes[k];
    mode.inertia = inertia[k];
    double torque = 0.0, rounding = 0.0;  // variances
    for (int j = 0; j < n_; ++j) {
      const double axis = mode.axis[j] = axes(j, k), error = axis * kTorqueError * most_[j];
      torque += error * error;
      rounding += axis * axis * options_.encoderStep[j] * options_.encoderStep[j] / 12.0;
    }
    Matrix<kMotion> step = Matrix<kMotion>::Identity();
    for (int i = 0; i < kPush; ++i) {
      mode.command[i] = motion.command[i];
      step(i, kPush) = motion.push[i];
      for (int j = 0; j < kPush; ++j) step(i, j) = motion.state[i][j];
    }
    for (int i = 0; i < kMotion; ++i)
      for (int j = 0; j < kMotion; ++j) mode.kept[j][i] = step(i, j);
    const Matrix<kMotion, 1> impulse = step.col(kRotorRate) * (std::sqrt(torque) * options_.period / d.rotorInertia),
                             push = step.col(kPush) * (std::sqrt(torque) * kPushChange / kTorqueError);
    const Matrix<kMotion> noise = impulse * impulse.transpose() + push * push.transpose();
    const Matrix<kMotion> P = steadyCovariance(step, noise, read(), rounding);
    mode.variance = P(read(), read()) + rounding;
    const Matrix<kMotion, 1> gain = P.col(read()) / mode.variance;
    for (int i = 0; i < kMotion; ++i) mode.gain[i] = gain[i];
  }
  return modes;
}

void Guard::describeCables(const Mechanism& device) {
  for (int i = 0; i < kStiffnesses; ++i) {
    Drive drive = options_.drive;
    drive.stiffness *= std::exp((i - kOfFile) * kStiffnessStep);
    modes_.push_back(modesOf(device, drive));
  }
  lag_ = lagOf(options_.drive);
  // Variance of the mean: a change of normal errors, squared, has the variance 2 and a correlation of 1/4 with the
  // next.
  mostMisfit_ = 1.0 + kSure * std::sqrt(1.5 * options_.period / (kMisfitTime * n_));
}

// A change of the stiffness by less than a step may be noise.
void Guard::learn(const TickOutput& output) noexcept {
  delay_ = output.delay < 0 ? options_.delay : std::min(output.delay, kMostGuardDelay);
  const double steps = std::isfinite(output.cables) ? output.cables / kStiffnessStep : 0.0;
  stiffness_ = static_cast<std::size_t>(kOfFile + static_cast<int>(std::clamp(steps, -1.0 * kOfFile, 1.0 * kOfFile)));
}

// Returns the first joint with an implausible report, or -1.
int Guard::unlikelyJoint(const JointVector& applied) const noexcept {
  const State& s = state_;
  for (int i = 0; i < n_; ++i) {
    const double noise = kReportNoise * kReportNoise * most_[i] * most_[i];
    if (isDriven(i) && (!(std::abs(applied[i]) <= kLargestReport * most_[i]) ||
                        (s.match[i] < kReportShare * s.power[i] - noise && s.error[i] > noise)))
      return i;
  }
  return -1;
}

bool Guard::believes(const JointVector& applied) const noexcept { return unlikelyJoint(applied) < 0; }

// Compare a report with the commands. The power is that of the oldest command: a late report is not a missing one. At a
// random delay, commands repeat or are skipped, and the power varies; then the report has no error.
void Guard::compareReport(const JointVector& applied, const Row& command, double elapsed) noexcept {
  State& s = state_;
  const double share = std::min(1.0, elapsed / kReportTime);
  for (int i = 0; i < n_; ++i) {
    const double most = kLargestReport * most_[i], old = s.sent.back()[i], report = std::clamp(applied[i], -most, most),
                 error = report - command[i];
    s.match[i] += share * (report * command[i] - s.match[i]);
    s.power[i] += share * (old * old - s.power[i]);
    s.error[i] += share * (error * error - s.error[i]);
  }
}

// Returns the recent command that is closest to the report. The delay may change from tick to tick.
const Guard::Row& Guard::nearestCommand(const JointVector& applied) const noexcept {
  const Row* best = nullptr;
  double least = kUnlimited;
  for (const Row& sent : state_.sent) {
    double sum = 0.0;
    for (int i = 0; i < n_; ++i) sum += weight_[i] * (applied[i] - sent[i]) * (applied[i] - sent[i]);
    if (sum >= least) continue;
    best = &sent;
    least = sum;
  }
  return best != nullptr ? *best : state_.acting;
}

double Guard::energy() const noexcept {
  const double commanded = std::min(state_.commanded.energy, state_.learnt.energy);
  return state_.reports ? std::max(commanded, state_.reported.energy) : commanded;
}

// Return the work of the cables on the links since the last sample, J. Kalman filters of the modes estimate the motion
// of rotors and links from the torques above gravity and the steps of the readings. A push of the hand that changes
// fast shifts the errors of prediction. So only the changes of these errors show whether the model is right.
double Guard::workOnLinks(const Row& torque, const Row& step, double elapsed, Account& account) const noexcept {
  const int ticks = std::clamp(static_cast<int>(std::lround(elapsed / options_.period)), 1, options_.longestGap);
  const double perTime = 1.0 / (ticks * options_.period), perLag = perTime / lag_,
               rotor = perTime * options_.drive.rotorInertia;
  double work = 0.0, misfit = 0.0;
  for (int k = 0; k < n_; ++k) {
    const Mode& mode = modes_[stiffness_][k];
    double command = 0.0, reading = 0.0;
    for (int j = 0; j < n_; ++j) {
      command += mode.axis[j] * torque[j];
      reading += mode.axis[j] * step[j];
    }
    const Motion before = account.modes[k];
    Motion x = before;
    for (int tick = 0; tick < ticks; ++tick) {
      Motion next;
      for (int i = 0; i < kMotion; ++i)
        next[i] = mode.command[i] * command + mode.kept[kMotor][i] * x[kMotor] + mode.kept[kPush][i] * x[kPush];
      for (int j = 0; j < kMotor; ++j)  // motor and push do not depend on these
        for (int i = 0; i < kMotor; ++i) next[i] += mode.kept[j][i] * x[j];
      x = next;
    }
    const auto change = [&](int i) { return x[i] - before[i]; };
    // The momentum of motor and rotor gives the mean torque of the cable. Mean torque times motion of the link lacks
    // the oscillation within a tick: the predicted change of kinetic energy minus this product in the prediction.
    const double middle = 0.5 * (x[kLinkRate] + before[kLinkRate]);
    work += mode.inertia * change(kLinkRate) * (middle - change(kLink) * perTime);
    const double surprise = reading - x[read()], motor = command - change(kMotor) * perLag,
                 jump = surprise - account.surprise[k];
    misfit += jump * jump / (2.0 * n_ * mode.variance);
    account.surprise[k] = surprise;
    for (int i = 0; i < kMotion; ++i) x[i] += mode.gain[i] * surprise;
    work += (motor - rotor * change(kRotorRate)) * change(kLink);
    x[kRotor] -= reading;
    x[kLink] -= reading;
    account.modes[k] = x;
  }
  const bool single = ticks == 1;
  if (single && account.single)
    account.misfit += std::min(1.0, options_.period / kMisfitTime) * (misfit - account.misfit);
  account.single = single;
  return work;
}

// Add the work of a torque since the last sample to its account. Returns the force of the torque at the TCP, N.
double Guard::book(const Measurement& m, const TickFrame& frame, const Row& torque, Account& account) const noexcept {
  const Kinematics& k = frame.kinematics;
  const State& s = state_;
  const GuardOptions& o = options_;
  const double elapsed = m.time - s.sampleTime;
  double work = 0.0;
  Vec6 way = Vec6::Zero(), wrench = Vec6::Zero();
  Row beyond{}, steps{};
  for (int i = 0; i < n_; ++i) {
    const double step = steps[i] = m.q[i] - s.q[i];
    beyond[i] = torque[i] - s.gravity[i];
    way += k.jacobian.col(i) * step;
    wrench += k.inverseTransposed.col(i) * beyond[i];
    // Rounding to counts can feign at most half a count times the change of torque (summation by parts). Subtract it,
    // so that the energy is a lower bound.
    work += beyond[i] * step - 0.5 * o.encoderStep[i] * std::abs(beyond[i] - account.beyond[i]);
  }
  account.beyond = beyond;
  if (o.drive.stiffness > 0.0) {
    const double onLinks = workOnLinks(beyond, steps, elapsed, account);
    if (account.misfit <= mostMisfit_) work = onLinks;  // otherwise the readings refute the model of the cables
  }
  const double force = std::sqrt(wrench.head<3>().squaredNorm() + wrench.tail<3>().squaredNorm() / (kLever * kLever));
  const double peak = std::max(force, s.peak);
  if (peak > kLeastForce) {
    if (damped_) work -= way.dot(o.damping * way) / elapsed;
    work -= wrench.head<3>().dot(s.surface) * elapsed;
    work -= way.head<3>().dot(frame.guided);
    account.energy += work;
  }
  if (account.energy > 0.0) account.energy = std::max(0.0, account.energy - o.power * elapsed);
  account.energy = std::max(account.energy, -0.5 * peak * peak / o.softest);
  if (!(std::abs(account.energy) <= kLargestEnergy)) account.energy = kLargestEnergy;  // meaningless numbers
  return force;
}

// Check workspace, speed and energy of the motion since the last sample, and store its twist.
GuardReason Guard::moved(const Measurement& m, const TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  State& s = state_;
  const GuardOptions& o = options_;
  const double elapsed = m.time - s.sampleTime;
  Vec6 way = Vec6::Zero();
  for (int i = 0; i < n_; ++i) way += k.jacobian.col(i) * (m.q[i] - s.q[i]);
  s.twist = way / std::max(elapsed, 0.5 * o.period);

  s.peak *= std::max(0.0, 1.0 - elapsed / kForgets);
  if (m.applied && !s.reports) s.reported = s.commanded;
  s.reports = s.reports || m.applied.has_value();
  // A report covers one tick. After lost samples the mean of the commands is used instead.
  const auto sent = [&](int delay) { return s.ticks == 1.0 ? s.sent[delay] : s.acting; };
  Row commanded = sent(o.delay), reported = commanded;
  bool isAssumed = true;
  if (m.applied && s.ticks == 1.0) {
    const int unlikely = unlikelyJoint(*m.applied);
    const Row& nearest = nearestCommand(*m.applied);
    compareReport(*m.applied, nearest, elapsed);
    if (unlikely < 0) {
      reported = commanded = nearest;
      isAssumed = false;
      for (int i = 0; i < n_; ++i)
        if (isDriven(i)) reported[i] = (*m.applied)[i];
    } else {
      ++ignored_;
      ignoredJoint_ = unlikely;
    }
  }
  double force = book(m, frame, commanded, s.commanded);
  // The renderer may be wrong for a while. So its delay has an account of its own, and the smaller one counts.
  if (isAssumed && delay_ != o.delay)
    book(m, frame, sent(delay_), s.learnt);
  else
    s.learnt = s.commanded;
  if (s.reports) force = std::max(force, book(m, frame, reported, s.reported));
  s.peak = std::max(s.peak, force);
  if (!(s.peak <= kLargestEnergy)) s.peak = 0.0;  // meaningless numbers

  for (int i = 0; i < 3; ++i)
    if (!(std::abs(k.pose.position[i]) <= o.workspace[i] + o.margin)) return GuardReason::workspace;
  if (!(s.twist.head<3>().squaredNorm() <= o.stopSpeed * o.stopSpeed &&
        s.twist.tail<3>().squaredNorm() <= o.stopTurn * o.stopTurn))
    return GuardReason::speed;
  return energy() <= o.energy ? GuardReason::none : GuardReason::energy;
}

}  // namespace enamel
