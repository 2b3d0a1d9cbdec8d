#include "enamel/sim/real_plant.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/core/error.hpp"
#include "enamel/sim/random.hpp"

namespace enamel {
namespace {

constexpr double kPresliding = 2e-4;  // z_c, rad

// Of a device's tolerances.
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
  void operator()(CartesianParameters&) {}
};

// A mechanism whose rotors hang on cables.
struct TakeRotors {
  template <typename Device>
  void operator()(Device& p) const {
    p.motor.rotorInertia = 0.0;
    p.imperfections = {};
  }
  void operator()(CartesianParameters&) const {}
};

MotorParameters* motorOf(DeviceParameters& parameters) {
  if (auto* tau = std::get_if<TauParameters>(&parameters)) return &tau->motor;
  if (auto* delta = std::get_if<DeltaParameters>(&parameters)) return &delta->motor;
  return nullptr;
}

// Rotor angles that hold `torque` through cables, seen from the joints.
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

}  // namespace

RealDevice makeRealDevice(const DeviceParameters& parameters, std::uint64_t seed, std::uint32_t number) {
  DeviceParameters built = parameters;
  MotorParameters* const motor = motorOf(built);
  if (motor == nullptr)
    throw Error("device \"" + nameOf(parameters) + "\": nothing is known of the drives of a Cartesian device");
  RealDevice device;
  device.imperfections = imperfectionsOf(parameters);
  Draw draw(seed, number);
  std::visit(Build{draw, device.imperfections}, built);
  device.rotorInertia = motor->rotorInertia;
  if (device.imperfections.cableStiffness > 0.0) std::visit(TakeRotors{}, built);
  device.mechanism = makeMechanism(built);
  const Kinematics& home = device.mechanism->home();
  device.offset = makeMechanism(parameters)->home().q - home.q - windUp(device.imperfections, home.gravity);
  for (double& offset : device.offset) offset += draw(device.imperfections.encoderOffset);
  return device;
}

Status RealPlant::start(const Pose& pose) {
  Kinematics kinematics;
  if (const Status status = mechanism().reach(pose, Vec6::Zero(), false, kinematics); status != Status::ok)
    return status;
  state_ = DeviceState();
  state_.position = pose.position;
  state_.orientation = pose.rotation;
  angle_ = kinematics.q + windUp(device_.imperfections, kinematics.gravity);
  speed_ = presliding_ = JointVector::Zero(angle_.size());
  current_ = kinematics.gravity;
  return Status::ok;
}

void RealPlant::read(const Kinematics&, JointVector& q, JointVector& rates) const noexcept {
  q = angle_ + device_.offset;
  rates = speed_;
}

Status RealPlant::advance(double time, double duration, const JointVector& torque, const Load& load) noexcept {
  if (!(duration > 0.0)) return Status::ok;
  const double steps = std::ceil(duration / step_ - 1e-9), h = duration / steps;
  State state{state_, angle_, speed_, current_, presliding_};
  for (int i = 0; i < steps; ++i) {
    if (const Status s = step(time + i * h, h, torque, load, state); s != Status::ok) return s;
    if (!(state.link.twist.head<3>().norm() <= kFastest && state.link.twist.tail<3>().norm() <= kFastestTurn))
      return Status::outOfRange;
  }
  state_ = state.link;
  angle_ = state.angle;
  speed_ = state.speed;
  current_ = state.current;
  presliding_ = state.presliding;
  return Status::ok;
}

// Current and friction after h at constant speeds.
void RealPlant::relax(double h, const JointVector& command, State& state) const noexcept {
  const Imperfections& e = device_.imperfections;
  const double lag = e.currentBandwidth > 0.0 ? -std::expm1(-2.0 * M_PI * e.currentBandwidth * h) : 1.0;
  for (Eigen::Index i = 0; i < command.size(); ++i) {
    const double asked = e.torqueStep > 0.0 ? e.torqueStep * std::nearbyint(command[i] / e.torqueStep) : command[i];
    state.current[i] += lag * (asked - state.current[i]);
    const double limit = std::copysign(kPresliding, state.speed[i]);
    state.presliding[i] = limit + (state.presliding[i] - limit) * std::exp(-std::abs(state.speed[i]) * h / kPresliding);
  }
}

// Of the motors, less friction.
JointVector RealPlant::torqueOf(const State& state) const noexcept {
  const Imperfections& e = device_.imperfections;
  JointVector torque = state.current;
  for (Eigen::Index i = 0; i < torque.size(); ++i)
    torque[i] += (e.torqueRipple * torque[i] + e.cogging) * std::sin(e.periods * state.angle[i]) -
                 e.coulombFriction * state.presliding[i] / kPresliding;
  return torque;
}

Status RealPlant::step(double time, double h, const JointVector& command, const Load& load,
                       State& state) const noexcept {
  relax(0.5 * h, command, state);
  const Status status = isRigid() ? moveRigidly(time, h, load, state) : move(time, h, load, state);
  relax(0.5 * h, command, state);
  return status;
}

Status RealPlant::moveRigidly(double time, double h, const Load& load, State& state) const noexcept {
  if (const Status s = stepRungeKutta4(mechanism(), time, h, torqueOf(state), load, state.link); s != Status::ok)
    return s;
  Kinematics kinematics;
  if (const Status s = mechanism().reach(state.link.pose(), state.link.twist, false, kinematics); s != Status::ok)
    return s;
  state.angle = kinematics.q;
  state.speed = kinematics.rates;
  return Status::ok;
}

Status RealPlant::move(double time, double h, const Load& load, State& state) const noexcept {
  const auto moved = [&state](const State& at, const Slope& slope, double by) {
    State s = state;
    s.link = detail::moved(state.link, slope.link, by);
    s.angle += by * at.speed;
    s.speed += by * slope.acceleration;
    return s;
  };
  Slope k1, k2, k3, k4;
  if (const Status s = slopeAt(time, state, load, k1); s != Status::ok) return s;
  const State s2 = moved(state, k1, 0.5 * h);
  if (const Status s = slopeAt(time + 0.5 * h, s2, load, k2); s != Status::ok) return s;
  const State s3 = moved(s2, k2, 0.5 * h);
  if (const Status s = slopeAt(time + 0.5 * h, s3, load, k3); s != Status::ok) return s;
  const State s4 = moved(s3, k3, h);
  if (const Status s = slopeAt(time + h, s4, load, k4); s != Status::ok) return s;
  const double sixth = h / 6.0;
  state.link.position += sixth * (k1.link.position + 2.0 * (k2.link.position + k3.link.position) + k4.link.position);
  state.link.orientation.coeffs() +=
      sixth * (k1.link.orientation + 2.0 * (k2.link.orientation + k3.link.orientation) + k4.link.orientation);
  state.link.orientation.normalize();
  state.link.twist += sixth * (k1.link.twist + 2.0 * (k2.link.twist + k3.link.twist) + k4.link.twist);
  state.angle += sixth * (state.speed + 2.0 * (s2.speed + s3.speed) + s4.speed);
  state.speed += sixth * (k1.acceleration + 2.0 * (k2.acceleration + k3.acceleration) + k4.acceleration);
  return Status::ok;
}

Status RealPlant::slopeAt(double time, const State& state, const Load& load, Slope& slope) const noexcept {
  Kinematics kinematics;
  const Pose pose{state.link.position, state.link.orientation.normalized().toRotationMatrix()};
  if (const Status s = mechanism().reach(pose, state.link.twist, false, kinematics); s != Status::ok) return s;
  JointVector cable = kinematics.q;
  for (Eigen::Index i = 0; i < cable.size(); ++i)
    cable[i] =
        cableTorque(device_.imperfections, state.angle[i] - kinematics.q[i], state.speed[i] - kinematics.rates[i]);
  slope.acceleration = (torqueOf(state) - cable) / device_.rotorInertia;
  return detail::slopeAt(mechanism(), time, state.link, cable, load, slope.link);
}

}  // namespace enamel
