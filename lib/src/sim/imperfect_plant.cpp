#include "enamel/sim/imperfect_plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enamel/core/error.hpp"
#include "enamel/sim/random.hpp"

namespace enamel {
namespace {

constexpr double kPresliding = 2e-4;  // z_c, rad

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
  void operator()(CartesianParameters&) {}
};

// Removes the rotors from the mechanism: they are behind cables.
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

}  // namespace

ImperfectDevice makeImperfectDevice(const DeviceParameters& parameters, std::uint64_t seed, std::uint32_t number) {
  DeviceParameters built = parameters;
  MotorParameters* const motor = motorOf(built);
  if (motor == nullptr)
    throw Error("device \"" + nameOf(parameters) +
                "\": a Cartesian device has no drive parameters; use the plant closed-form");
  ImperfectDevice device;
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

ImperfectPlant::ImperfectPlant(ImperfectDevice device, double step) noexcept
    : Plant(*device.mechanism), device_(std::move(device)), step_(step) {
  const auto complete = [n = mechanism().joints()](JointVector& values, double common) {
    if (values.size() != n) values = JointVector::Constant(n, common);
  };
  complete(device_.torqueConstant, 1.0);
  complete(device_.coulombFriction, device_.imperfections.coulombFriction);
  complete(device_.cogging, device_.imperfections.cogging);
  complete(device_.coggingPhase, 0.0);
}

ImperfectPlant::State moved(const ImperfectPlant::State& state, const ImperfectPlant::Slope& slope, double h) noexcept {
  ImperfectPlant::State s = state;
  s.link = detail::moved(state.link, slope.link, h);
  s.rotors.angle += h * slope.speed;
  s.rotors.speed += h * slope.acceleration;
  return s;
}

ImperfectPlant::Slope weighted(const ImperfectPlant::Slope& k1, const ImperfectPlant::Slope& k2,
                               const ImperfectPlant::Slope& k3, const ImperfectPlant::Slope& k4) noexcept {
  return {detail::weighted(k1.link, k2.link, k3.link, k4.link), k1.speed + 2.0 * (k2.speed + k3.speed) + k4.speed,
          k1.acceleration + 2.0 * (k2.acceleration + k3.acceleration) + k4.acceleration};
}

Status ImperfectPlant::start(const Pose& pose) {
  Kinematics kinematics;
  if (const Status status = rest(pose, kinematics); status != Status::ok) return status;
  rotors_.angle = kinematics.q + windUp(device_.imperfections, kinematics.gravity);
  rotors_.speed = rotors_.presliding = JointVector::Zero(kinematics.q.size());
  rotors_.current = kinematics.gravity;
  return Status::ok;
}

void ImperfectPlant::read(const Kinematics&, JointVector& q, JointVector& rates) const noexcept {
  q = rotors_.angle + device_.offset;
  rates = rotors_.speed;
}

Status ImperfectPlant::advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept {
  if (!(duration > 0.0)) return Status::ok;
  const double steps = std::ceil(duration / step_ - 1e-9), h = duration / steps;
  State state{state_, rotors_};
  for (int i = 0; i < steps; ++i) {
    if (const Status s = step(time + i * h, h, torque, load, state); s != Status::ok) return s;
    if (!isWithinSpeedLimits(state.link)) return Status::outOfRange;
  }
  state_ = state.link;
  rotors_ = state.rotors;
  return Status::ok;
}

// Advance current and friction by h at constant speeds.
void ImperfectPlant::relax(double h, const JointVector& command, Rotors& rotors) const noexcept {
  const Imperfections& e = device_.imperfections;
  const double lag = e.currentBandwidth > 0.0 ? -std::expm1(-2.0 * M_PI * e.currentBandwidth * h) : 1.0;
  for (Eigen::Index i = 0; i < command.size(); ++i) {
    const double asked = e.torqueStep > 0.0 ? e.torqueStep * std::nearbyint(command[i] / e.torqueStep) : command[i];
    rotors.current[i] += lag * (device_.torqueConstant[i] * asked - rotors.current[i]);
    const double limit = std::copysign(kPresliding, rotors.speed[i]);
    rotors.presliding[i] =
        limit + (rotors.presliding[i] - limit) * std::exp(-std::abs(rotors.speed[i]) * h / kPresliding);
  }
}

// Torque of the motors minus friction.
JointVector ImperfectPlant::torqueOf(const Rotors& rotors) const noexcept {
  const Imperfections& e = device_.imperfections;
  JointVector torque = rotors.current;
  for (Eigen::Index i = 0; i < torque.size(); ++i)
    torque[i] += (e.torqueRipple * torque[i] + device_.cogging[i]) *
                     std::sin(e.periods * rotors.angle[i] + device_.coggingPhase[i]) -
                 device_.coulombFriction[i] * rotors.presliding[i] / kPresliding;
  return torque;
}

Status ImperfectPlant::step(double time, double h, const JointVector& command, const ExternalWrench& load,
                            State& state) const noexcept {
  relax(0.5 * h, command, state.rotors);
  const Status status = isRigid() ? moveRigidly(time, h, load, state) : move(time, h, load, state);
  relax(0.5 * h, command, state.rotors);
  return status;
}

Status ImperfectPlant::moveRigidly(double time, double h, const ExternalWrench& load, State& state) const noexcept {
  if (const Status s = stepRungeKutta4(mechanism(), time, h, torqueOf(state.rotors), load, state.link); s != Status::ok)
    return s;
  Kinematics kinematics;
  if (const Status s = mechanism().reach(state.link.pose(), state.link.twist, false, kinematics); s != Status::ok)
    return s;
  state.rotors.angle = kinematics.q;
  state.rotors.speed = kinematics.rates;
  return Status::ok;
}

Status ImperfectPlant::move(double time, double h, const ExternalWrench& load, State& state) const noexcept {
  const auto slopeAt = [&](double t, const State& s, Slope& slope) { return this->slopeAt(t, s, load, slope); };
  const Status status = detail::rungeKutta4<Slope>(time, h, slopeAt, state);
  if (status == Status::ok) state.link.orientation.normalize();
  return status;
}

Status ImperfectPlant::slopeAt(double time, const State& state, const ExternalWrench& load,
                               Slope& slope) const noexcept {
  Kinematics kinematics;
  const Pose pose{state.link.position, state.link.orientation.normalized().toRotationMatrix()};
  if (const Status s = mechanism().reach(pose, state.link.twist, false, kinematics); s != Status::ok) return s;
  JointVector cable = kinematics.q;
  for (Eigen::Index i = 0; i < cable.size(); ++i)
    cable[i] = cableTorque(device_.imperfections, state.rotors.angle[i] - kinematics.q[i],
                           state.rotors.speed[i] - kinematics.rates[i]);
  slope.speed = state.rotors.speed;
  slope.acceleration = (torqueOf(state.rotors) - cable) / device_.rotorInertia;
  return detail::slopeAt(mechanism(), time, state.link, cable, load, slope.link);
}

}  // namespace enamel
