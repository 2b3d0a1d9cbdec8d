// Energy accounts of the guard: one from its own commands, one from the torque that the device reports.
#include <algorithm>
#include <cmath>

#include "enamel/render/guard.hpp"
#include "render/exponential.hpp"
#include "render/mode_table.hpp"

namespace enamel {
namespace {

constexpr double kForgets = 0.2;        // s, decay time of the largest recent force
constexpr double kLeastForce = 1e-3;    // N; smaller forces count as zero
constexpr double kLargestEnergy = 1e6;  // J
constexpr double kLinkError = 0.2;      // share of the energy of rotors and cables
constexpr double kLever = 0.05;         // m, lever that converts a moment to a force
// Reported torque: filter time, s; least share of the commands' power; noise and maximum, of the motor's limit.
constexpr double kReportTime = 0.01, kReportShare = 0.75, kReportNoise = 0.03, kLargestReport = 1.5;

}  // namespace

void Guard::describeTransmission() {
  const Drive& d = options_.drive;
  lag_ = lagOf(d);
  for (int joint = 0; joint < n_; ++joint) {
    // m' = w (u - m),  stretch'' = m / J - (k stretch + b stretch') (1 / J + 1 / L)
    const double J = d.rotorInertia, L = options_.linkInertia[joint], inverse = 1.0 / J + 1.0 / L;
    Matrix<4> A;
    A << -lag_, 0.0, 0.0, lag_, 0.0, 0.0, 1.0, 0.0, 1.0 / J, -d.stiffness * inverse, -d.damping * inverse, 0.0, 0.0,
        0.0, 0.0, 0.0;
    const Matrix<4> step = exponential<4>(A * options_.period);
    Transmission& t = transmission_[joint];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) t.kept[i][j] = step(i, j);
      t.command[i] = step(i, 3);
    }
    t.share = 1.0 / (1.0 + J / L);
    // A full torque step stretches the cable twice as far as the same torque at rest.
    mostHeld_ += 2.0 * options_.torque[joint] * options_.torque[joint] / d.stiffness;
  }
}

// Returns the first joint with an implausible report, or -1.
int Guard::unlikelyJoint(const JointVector& applied) const noexcept {
  for (int i = 0; i < n_; ++i) {
    const double noise = kReportNoise * most_[i];
    if (isDriven(i) && (!(std::abs(applied[i]) <= kLargestReport * most_[i]) ||
                        state_.match[i] < kReportShare * state_.power[i] - noise * noise))
      return i;
  }
  return -1;
}

bool Guard::believes(const JointVector& applied) const noexcept { return unlikelyJoint(applied) < 0; }

// Compare a report with the commands. The power is that of the oldest command: a late report is not a missing one.
void Guard::compareReport(const JointVector& applied, const Row& command, double elapsed) noexcept {
  State& s = state_;
  const double share = std::min(1.0, elapsed / kReportTime);
  for (int i = 0; i < n_; ++i) {
    const double most = kLargestReport * most_[i], old = s.sent.back()[i];
    s.match[i] += share * (std::clamp(applied[i], -most, most) * command[i] - s.match[i]);
    s.power[i] += share * (old * old - s.power[i]);
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
  return state_.reports ? std::max(state_.commanded.energy, state_.reported.energy) : state_.commanded.energy;
}

// Convert a motor's torque and its encoder's motion to the torque and motion of the link. The rest turns the rotor and
// stretches the cable. Without this, a single strong command that winds up the cable would count as energy of the tool.
void Guard::reachLink(int joint, double elapsed, Account& s, double& torque, double& way) const noexcept {
  const Transmission& t = transmission_[joint];
  const double command = torque, before = s.stretch[joint], rateBefore = s.stretchRate[joint],
               lagBefore = s.lagged[joint];
  const int ticks = std::clamp(static_cast<int>(std::lround(elapsed / options_.period)), 1, options_.longestGap);
  for (int tick = 0; tick < ticks; ++tick) {
    const double now[3] = {s.lagged[joint], s.stretch[joint], s.stretchRate[joint]};
    double next[3];
    for (int i = 0; i < 3; ++i) {
      next[i] = t.command[i] * command;
      for (int j = 0; j < 3; ++j) next[i] += t.kept[i][j] * now[j];
    }
    s.lagged[joint] = next[0];
    s.stretch[joint] = next[1];
    s.stretchRate[joint] = next[2];
  }
  // Mean over the elapsed time, from the momentum balance of motor and rotor. The link moves independently.
  const double time = ticks * options_.period, motor = command - (s.lagged[joint] - lagBefore) / (lag_ * time);
  torque = t.share * (motor - options_.drive.rotorInertia * (s.stretchRate[joint] - rateBefore) / time);
  if (!options_.drive.encoderOnLink) way -= s.stretch[joint] - before;
}

// Add the work of a torque since the last sample to its account. Returns the force of the torque at the TCP, N.
double Guard::book(const Measurement& m, const Kinematics& k, const Row& torque, Account& account) const noexcept {
  const State& s = state_;
  const GuardOptions& o = options_;
  const double elapsed = m.time - s.sampleTime;
  double work = 0.0, held = 0.0;
  Vec6 way = Vec6::Zero(), wrench = Vec6::Zero();
  for (int i = 0; i < n_; ++i) {
    double step = m.q[i] - s.q[i], beyond = torque[i] - s.gravity[i];
    way += k.jacobian.col(i) * step;
    if (o.drive.stiffness > 0.0) {
      reachLink(i, elapsed, account, beyond, step);
      held += 0.5 * o.drive.stiffness * account.stretch[i] * account.stretch[i] +
              0.5 * o.drive.rotorInertia * account.stretchRate[i] * account.stretchRate[i];
    }
    wrench += k.inverseTransposed.col(i) * beyond;
    // Rounding to counts can feign at most half a count times the change of torque (summation by parts). Subtract it,
    // so that the energy is a lower bound.
    work += beyond * step - 0.5 * o.encoderStep[i] * std::abs(beyond - account.beyond[i]);
    account.beyond[i] = beyond;
  }
  // The energy that rotors and cables exchange with the links is only as accurate as the links' inertia.
  held = std::min(held, mostHeld_);
  work -= kLinkError * std::abs(held - account.held);
  account.held = held;
  const double force = std::sqrt(wrench.head<3>().squaredNorm() + wrench.tail<3>().squaredNorm() / (kLever * kLever));
  const double peak = std::max(force, s.peak);
  if (peak > kLeastForce) {
    if (damped_) work -= way.dot(o.damping * way) / elapsed;
    work -= wrench.head<3>().dot(s.surface) * elapsed;
    account.energy += work;
  }
  if (account.energy > 0.0) account.energy = std::max(0.0, account.energy - o.power * elapsed);
  account.energy = std::max(account.energy, -0.5 * peak * peak / o.softest);
  if (!(std::abs(account.energy) <= kLargestEnergy)) account.energy = kLargestEnergy;  // meaningless numbers
  return force;
}

// Check workspace, speed and energy of the motion since the last sample, and store its twist.
GuardReason Guard::moved(const Measurement& m, const Kinematics& k) noexcept {
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
  Row commanded = s.ticks == 1.0 ? s.sent[o.delay] : s.acting, reported = commanded;
  if (m.applied && s.ticks == 1.0) {
    const int unlikely = unlikelyJoint(*m.applied);
    const Row& nearest = nearestCommand(*m.applied);
    compareReport(*m.applied, nearest, elapsed);
    if (unlikely < 0) {
      reported = commanded = nearest;
      for (int i = 0; i < n_; ++i)
        if (isDriven(i)) reported[i] = (*m.applied)[i];
    } else {
      ++ignored_;
      ignoredJoint_ = unlikely;
    }
  }
  double force = book(m, k, commanded, s.commanded);
  if (s.reports) force = std::max(force, book(m, k, reported, s.reported));
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
