#include "enamel/sim/imperfect_plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enamel/core/cholesky.hpp"
#include "enamel/core/error.hpp"
#include "enamel/sim/random.hpp"

namespace enamel {
namespace {

constexpr double kPresliding = 2e-4;  // z_c, rad
constexpr double kPhase = 0.25;       // of the resonance in a step, rad, at most

// Draws the tolerances of a device.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint32_t number) : random_(seed, number) {}
  // Uniform in +- `most`.
  double operator()(double most) { return most * (2.0 * random_.uniform(RandomStream::Purpose::build, next_++) - 1.0); }
  void scale(double& value, double error) { value *= 1.0 + (*this)(error); }
  void scale(Vec3& value, double error) {
    for (double& x : value) scale(x, error);
  }

 private:
  RandomStream random_;
  std::uint64_t next_ = 0;
};

struct Build {
  Draw& draw;
  const Imperfections& e;

  void operator()(LinkParameters& link) {
    double length = 1.0, mass = 1.0;
    draw.scale(length, e.lengthError);
    draw.scale(mass, e.massError);
    link.length *= length;
    link.com *= length;
    link.mass *= mass;
    link.inertia *= mass * length * length;
  }
  void operator()(TauParameters& p) {
    for (ChainParameters& chain : p.chain) {
      draw.scale(chain.base, e.lengthError);
      draw.scale(chain.platform, e.lengthError);
      (*this)(chain.link1);
      (*this)(chain.link2);
    }
    double mass = 1.0;
    draw.scale(mass, e.massError);
    p.platform.mass *= mass;
    p.platform.inertia *= mass;
    draw.scale(p.platform.com, e.lengthError);
    draw.scale(p.motor.rotorInertia, e.massError);
  }
  void operator()(DeltaParameters& p) {
    DeltaGeometry& g = p.geometry;
    for (double* length : {&g.a, &g.b, &g.c, &g.d, &g.e, &g.f, &g.r, &g.s, &p.upperLink.com})
      draw.scale(*length, e.lengthError);
    for (double* mass : {&p.upperLink.mass, &p.upperLink.inertia, &p.bar.mass, &p.platform.mass, &p.motor.rotorInertia})
      draw.scale(*mass, e.massError);
  }
  void operator()(CartesianParameters& p) {
    double mass = 1.0;
    draw.scale(mass, e.massError);
    p.mass *= mass;
    for (double& m : p.massTable.mass) m *= mass;
    p.inertia *= mass;
    p.rotorMass *= mass;
  }
};

// Rotor angles that hold `torque` through cables, relative to the joints.
JointVector windUp(const Imperfections& e, const JointVector& torque) {
  JointVector angle = JointVector::Zero(torque.size());
  if (e.cableStiffness > 0.0)
    for (Eigen::Index i = 0; i < torque.size(); ++i)
      if (torque[i] != 0.0) angle[i] = torque[i] / e.cableStiffness + std::copysign(0.5 * e.backlash, torque[i]);
  return angle;
}

double cableTorque(const Imperfections& e, double stretch, double rate) {
  const double pull = std::abs(stretch) - 0.5 * e.backlash;
  return pull > 0.0 ? std::copysign(e.cableStiffness * pull, stretch) + e.cableDamping * rate : 0.0;
}

// A vector of the joints, and zeros up to the size of a padded one.
template <typename Padded>
Padded padded(const JointVector& v) noexcept {
  Padded p = Padded::Zero();
  p.head(v.size()) = v;
  return p;
}

// The inverse of a mass matrix. Returns false if it is not positive definite.
template <typename Matrix>
bool invert(const JointMatrix& inertia, Matrix& inverse) noexcept {
  const int n = static_cast<int>(inertia.rows());
  double lower[kMaxJoints][kMaxJoints];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) lower[i][j] = inertia(i, j);
  Cholesky<kMaxJoints> factor;
  if (!factor.factor(lower, n)) return false;
  inverse.setZero();
  for (int j = 0; j < n; ++j) {
    inverse(j, j) = 1.0;
    factor.solve(&inverse(0, j));
  }
  return true;
}

// Move a platform by `way`, [m; rad].
DeviceState shifted(const DeviceState& from, const Vec6& way) noexcept {
  DeviceState to = from;
  to.position += way.head<3>();
  // The quaternion of a small rotation, normalised: its angle is atan(|way| / 2) * 2.
  to.orientation.coeffs() += detail::orientationRate(from, way);
  to.orientation.normalize();
  return to;
}

}  // namespace

ImperfectDevice makeImperfectDevice(const DeviceParameters& parameters, std::uint64_t seed, std::uint32_t number) {
  DeviceParameters built = parameters;
  ImperfectDevice device;
  device.imperfections = imperfectionsOf(parameters);
  Draw draw(seed, number);
  std::visit(Build{draw, device.imperfections}, built);
  device.rotorInertia = rotorInertiaOf(built);
  if (device.imperfections.cableStiffness > 0.0) {
    imperfectionsOf(built) = {};
    removeRotors(built);
  }
  device.mechanism = makeMechanism(built);
  const Kinematics& home = device.mechanism->home();
  device.offset = makeMechanism(parameters)->home().q - home.q - windUp(device.imperfections, home.gravity);
  for (double& offset : device.offset) offset += draw(device.imperfections.encoderOffset);
  return device;
}

ImperfectPlant::ImperfectPlant(ImperfectDevice device, double step) noexcept
    : Plant(*device.mechanism), device_(std::move(device)), step_(step) {
  const JointVector& effort = mechanism().limits().effort;
  const auto complete = [&effort](JointVector& values, double common) {
    if (values.size() == effort.size()) return;
    values = JointVector::Constant(effort.size(), common);
    for (Eigen::Index i = 0; i < values.size(); ++i)
      if (effort[i] == 0.0) values[i] = 0.0;  // no motor
  };
  complete(device_.torqueConstant, 1.0);
  complete(device_.coulombFriction, device_.imperfections.coulombFriction);
  complete(device_.cogging, device_.imperfections.cogging);
  complete(device_.coggingPhase, 0.0);
  const double cable = device_.imperfections.cableStiffness,
               friction = device_.coulombFriction.maxCoeff() / kPresliding,
               link = mechanism().home().inertia.inverse().norm();
  resonance_ = std::sqrt(isRigid() ? friction * link : cable * link + (cable + friction) / device_.rotorInertia);
}

Status ImperfectPlant::start(const Pose& pose) {
  Kinematics kinematics;
  if (const Status status = rest(pose, kinematics); status != Status::ok) return status;
  Motion motion;
  if (const Status status = linearize(state_, kinematics, motion.linear); status != Status::ok) return status;
  const Padded q = padded<Padded>(kinematics.q), none = Padded::Zero();
  motion.drives = {q, none, q + padded<Padded>(windUp(device_.imperfections, kinematics.gravity)), none};
  motion.current = padded<Padded>(kinematics.gravity);
  motion.presliding = none;
  motion_ = motion;
  return Status::ok;
}

void ImperfectPlant::read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept {
  const Eigen::Index n = device_.offset.size();
  q = truth.q;
  rates = truth.rates;
  if (!isRigid()) {
    q = motion_.drives.angle.head(n);
    rates = motion_.drives.speed.head(n);
  }
  q += device_.offset;
}

Status ImperfectPlant::advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept {
  if (!(duration > 0.0)) return Status::ok;
  if (torque.size() != mechanism().joints()) return Status::outOfRange;
  if (!torque.allFinite()) return Status::notFinite;
  const double parts = std::ceil(duration / step_ - 1e-9), part = duration / parts;
  JointVector asked = torque;
  if (const double step = device_.imperfections.torqueStep; step > 0.0)
    for (double& t : asked) t = step * std::nearbyint(t / step);
  asked.array() *= device_.torqueConstant.array();
  const Padded constant = padded<Padded>(asked);
  DeviceState platform = state_;
  Motion motion = motion_;
  for (int i = 0; i < parts; ++i) {
    if (const Status s = movePart(time + i * part, part, constant, load, platform, motion); s != Status::ok) return s;
    if (!isWithinSpeedLimits(platform)) return Status::outOfRange;
  }
  state_ = platform;
  motion_ = motion;
  return Status::ok;
}

Status ImperfectPlant::linearize(const DeviceState& state, Kinematics& kinematics, Linear& linear) const noexcept {
  const Pose pose = state.pose();
  const JointVector none = JointVector::Zero(mechanism().joints());
  Vec6 free;
  if (const Status s = mechanism().reach(pose, state.twist, true, kinematics); s != Status::ok) return s;
  if (const Status s = mechanism().accelerate(pose, state.twist, none, Vec6::Zero(), free); s != Status::ok) return s;
  const Eigen::Index n = kinematics.q.size();
  linear.jacobian.setZero();
  linear.jacobian.leftCols(n) = kinematics.jacobian;
  linear.free = padded<Padded>(kinematics.inverseTransposed.transpose().lazyProduct(free));
  return invert(kinematics.inertia, linear.mobility) ? Status::ok : Status::singular;
}

Status ImperfectPlant::movePart(double time, double duration, const Padded& asked, const ExternalWrench& load,
                                DeviceState& platform, Motion& motion) const noexcept {
  Drives& drives = motion.drives;
  Linear& linear = motion.linear;
  const auto pushed = [&](double t, const DeviceState& at) {
    const Padded effort = linear.jacobian.transpose().lazyProduct(load(t, at.pose(), at.twist));
    return Padded(linear.free + linear.mobility.lazyProduct(effort));
  };
  // The state in the middle follows from that at the beginning, with the mechanism of the part before.
  const double half = 0.5 * duration;
  const Padded torque = torqueAt(drives.angle, motion.current, motion.presliding);
  const Padded begin = slopeOf(drives, torque, pushed(time, platform), linear).rates;
  Vec6 acceleration = linear.jacobian.lazyProduct(begin);
  const Vec6 way = half * (platform.twist + 0.5 * half * acceleration);
  DeviceState middle = shifted(platform, way);
  middle.twist += half * acceleration;
  Kinematics kinematics;
  if (const Status s = linearize(middle, kinematics, linear); s != Status::ok) return s;

  const Eigen::Index n = kinematics.q.size();
  drives.q.head(n) = kinematics.q - kinematics.inverseTransposed.transpose().lazyProduct(way);
  drives.rates.head(n) = kinematics.inverseTransposed.transpose().lazyProduct(platform.twist);
  if (isRigid()) {
    drives.angle = drives.q;
    drives.speed = drives.rates;
  }
  const double steps = std::max(1.0, std::ceil(resonance_ * duration / kPhase)), h = duration / steps;
  for (int i = 0; i < steps; ++i) {
    slide(i == 0 ? 0.5 * h : h, motion);
    middle = shifted(platform, 0.5 * h * platform.twist);
    middle.twist += 0.5 * h * acceleration;
    const Padded mean = meanCurrent(h, asked, motion.current), before = drives.q;
    const Padded motor = torqueAt(drives.angle + 0.5 * h * drives.speed, mean, motion.presliding),
                 other = pushed(time + (i + 0.5) * h, middle);
    if (isRigid()) {
      const Drives slope = slopeOf(drives, motor, other, linear);
      drives.q += h * (drives.rates + 0.5 * h * slope.rates);
      drives.rates += h * slope.rates;
      drives.angle = drives.q;
      drives.speed = drives.rates;
    } else {
      const auto slopeAt = [&](double, const Drives& s, Drives& slope) {
        slope = slopeOf(s, motor, other, linear);
        return Status::ok;
      };
      (void)detail::rungeKutta4<Drives>(0.0, h, slopeAt, drives);
    }
    const Vec6 twist = linear.jacobian.lazyProduct(drives.rates);
    acceleration = (twist - platform.twist) / h;
    platform = shifted(platform, linear.jacobian.lazyProduct(drives.q - before));
    platform.twist = twist;
  }
  slide(0.5 * h, motion);
  return Status::ok;
}

// Advance the currents by h. Return their mean in that time.
ImperfectPlant::Padded ImperfectPlant::meanCurrent(double h, const Padded& asked, Padded& current) const noexcept {
  const double rate = 2.0 * M_PI * device_.imperfections.currentBandwidth;
  if (rate == 0.0) return current = asked;
  const double share = -std::expm1(-rate * h);
  const Padded mean = asked + share / (rate * h) * (current - asked);
  current += share * (asked - current);
  return mean;
}

// Advance the friction by h at constant speeds.
void ImperfectPlant::slide(double h, Motion& motion) const noexcept {
  for (Eigen::Index i = 0; i < device_.offset.size(); ++i) {
    if (device_.coulombFriction[i] == 0.0) continue;
    const double speed = motion.drives.speed[i], limit = std::copysign(kPresliding, speed);
    motion.presliding[i] = limit + (motion.presliding[i] - limit) * std::exp(-std::abs(speed) * h / kPresliding);
  }
}

// Torque of the motors minus friction.
ImperfectPlant::Padded ImperfectPlant::torqueAt(const Padded& angle, const Padded& current,
                                                const Padded& presliding) const noexcept {
  const Imperfections& e = device_.imperfections;
  Padded torque = current;
  for (Eigen::Index i = 0; i < device_.cogging.size(); ++i) {
    if (const double amplitude = e.torqueRipple * torque[i] + device_.cogging[i]; amplitude != 0.0)
      torque[i] += amplitude * std::sin(e.periods * angle[i] + device_.coggingPhase[i]);
    torque[i] -= device_.coulombFriction[i] * presliding[i] / kPresliding;
  }
  return torque;
}

ImperfectPlant::Drives ImperfectPlant::slopeOf(const Drives& drives, const Padded& torque, const Padded& pushed,
                                               const Linear& linear) const noexcept {
  Drives slope{drives.rates, pushed, drives.speed, pushed};
  if (isRigid()) {
    slope.rates += linear.mobility.lazyProduct(torque);
    slope.speed = slope.rates;
    return slope;
  }
  Padded pull = drives.q;
  for (Eigen::Index i = 0; i < pull.size(); ++i)
    pull[i] = cableTorque(device_.imperfections, drives.angle[i] - drives.q[i], drives.speed[i] - drives.rates[i]);
  slope.rates += linear.mobility.lazyProduct(pull);
  slope.speed = (torque - pull) / device_.rotorInertia;
  return slope;
}

}  // namespace enamel
