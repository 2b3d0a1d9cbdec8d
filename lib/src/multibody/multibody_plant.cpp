#include "enamel/multibody/multibody_plant.hpp"

#include <Simbody.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/message.hpp"

namespace enamel {
namespace {

using SimTK::MobilizedBody;

SimTK::Vec3 toSim(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 fromSim(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
SimTK::Rotation rotationOf(const Mat3& m) {
  return SimTK::Rotation(SimTK::Mat33(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)),
                         true);
}
// Enamel's vectors have linear before angular parts, Simbody's the reverse.
SimTK::SpatialVec spatial(const Vec6& v) { return {toSim(v.tail<3>()), toSim(v.head<3>())}; }
Vec6 fromSpatial(const SimTK::SpatialVec& v) {
  Vec6 result;
  result << fromSim(v[1]), fromSim(v[0]);
  return result;
}
Mat3 fromSim(const SimTK::Rotation& r) {
  Mat3 m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = r[i][j];
  return m;
}

// Mass properties about the origin of the body.
SimTK::MassProperties massOf(double mass, const Vec3& com, const Mat3& aboutCom) {
  const Mat3 I = aboutCom + mass * (com.squaredNorm() * Mat3::Identity() - com * com.transpose());
  return {mass, toSim(com), SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2))};
}
SimTK::MassProperties pointMass(double mass, const Vec3& at) { return massOf(mass, at, Mat3::Zero()); }
// A thin disc. Simbody rejects an inertia about one axis alone: a disc has half of it about every perpendicular axis.
Mat3 disc(const Vec3& axis, double inertia) { return 0.5 * inertia * (Mat3::Identity() + axis * axis.transpose()); }

// A hinge about an axis of the parent. At angle 0 the child has the parent's axes. The child's origin is on the hinge.
MobilizedBody::Pin hinge(MobilizedBody& parent, const SimTK::Rotation& turn, const Vec3& at, const Vec3& axis,
                         const SimTK::MassProperties& mass) {
  const SimTK::Rotation toAxis(SimTK::UnitVec3(toSim(axis)), SimTK::ZAxis);
  return MobilizedBody::Pin(parent, SimTK::Transform(turn * toAxis, toSim(at)), SimTK::Body::Rigid(mass),
                            SimTK::Transform(toAxis));
}

// Acting forces: motors minus friction, load minus damping.
struct Acting {
  std::vector<MobilizedBody> driven;  // hinges with motors
  MobilizedBody platform;
  double friction = 0.0;
  Vec6 damping = Vec6::Zero();
  const Mechanism* cartesian = nullptr;  // set if the motors act on the platform itself

  JointVector torque;
  const ExternalWrench* load = nullptr;
  double timeAhead = 0.0;  // the caller's time minus that of the state
};

class ActingForce final : public SimTK::Force::Custom::Implementation {
 public:
  explicit ActingForce(const Acting& acting) : acting_(acting) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& bodies, SimTK::Vector_<SimTK::Vec3>&,
                 SimTK::Vector& mobilities) const override {
    const Acting& a = acting_;
    const SimTK::Transform& at = a.platform.getBodyTransform(state);
    const Pose pose{fromSim(at.p()), fromSim(at.R())};
    const Vec6 twist = fromSpatial(a.platform.getBodyVelocity(state));
    Vec6 wrench = -a.damping.cwiseProduct(twist);
    if (a.load != nullptr) wrench += (*a.load)(state.getTime() + a.timeAhead, pose, twist);
    if (a.cartesian != nullptr && a.torque.size() > 0) {
      Kinematics k;
      if (a.cartesian->reach(pose, twist, false, k) == Status::ok) wrench += wrenchOf(k, a.torque);
    }
    a.platform.applyBodyForce(state, spatial(wrench), bodies);
    for (std::size_t i = 0; i < a.driven.size(); ++i) {
      const double rate = a.driven[i].getOneU(state, 0);
      const double torque = a.torque.size() > 0 ? a.torque[static_cast<Eigen::Index>(i)] : 0.0;
      a.driven[i].applyOneMobilityForce(state, 0, torque - a.friction * rate, mobilities);
    }
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0.0; }

 private:
  const Acting& acting_;
};

}  // namespace

struct MultibodyPlant::Model {
  DeviceParameters parameters;
  double accuracy;
  std::shared_ptr<const Mechanism> mechanism;
  Acting acting;
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  std::vector<MobilizedBody> hinges;  // of all chains in turn, from the base
  std::unique_ptr<SimTK::RungeKuttaMersonIntegrator> integrator;
  SimTK::State state;
  bool goesOn = false;  // the integrator has this state and needs no initialisation

  Model(const DeviceParameters& given, double relative)
      : parameters(given), accuracy(relative), mechanism(makeMechanism(given)) {
    require(accuracy >= 1e-13 && accuracy <= 1e-2,
            "accuracy is " + formatNumber(accuracy) + ", must be in 1e-13 to 1e-2");
    std::visit([this](const auto& device) { build(device); }, parameters);
    const SimTK::Force::Custom acts(forces, new ActingForce(acting));  // Simbody owns it
    state = system.realizeTopology();
    system.realizeModel(state);
    integrator = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
    integrator->setAccuracy(accuracy);
    integrator->setConstraintTolerance(1e-11);
    integrator->setReturnEveryInternalStep(false);
  }

  void setGravity(const Vec3& gravity) { SimTK::Force::UniformGravity(forces, matter, toSim(gravity)); }

  void build(const TauParameters& device) {
    setGravity(device.gravity);
    acting.friction = device.motor.viscousFriction;
    acting.damping = device.platform.damping;
    const PlatformParameters& p = device.platform;
    const SimTK::Body::Rigid body(massOf(p.mass, p.com, p.inertia));
    const SimTK::Rotation none;
    for (const ChainParameters& chain : device.chain) {
      const double rotor = device.motor.rotorInertia;
      const LinkParameters &l1 = chain.link1, &l2 = chain.link2;
      // The lift's rotor also turns with the yaw, with half of its inertia. So the yaw's disc has only the other half.
      // The mass of 1 kg does not move; without a mass Simbody drops the inertia.
      MobilizedBody yaw = hinge(matter.Ground(), none, chain.base, Vec3::UnitY(),
                                massOf(1.0, Vec3::Zero(), disc(Vec3::UnitY(), 0.5 * rotor)));
      MobilizedBody lift = hinge(yaw, none, Vec3::Zero(), -Vec3::UnitX(),
                                 massOf(l1.mass, l1.com, l1.inertia + disc(Vec3::UnitX(), rotor)));
      MobilizedBody elbow =
          hinge(lift, none, Vec3(0.0, 0.0, l1.length), -Vec3::UnitX(), massOf(l2.mass, l2.com, l2.inertia));
      const SimTK::Vec3 tip(0.0, 0.0, l2.length);
      if (hinges.empty())  // the first chain carries the platform; constraints close the others
        acting.platform =
            MobilizedBody::Ball(elbow, SimTK::Transform(tip), body, SimTK::Transform(toSim(chain.platform)));
      else
        SimTK::Constraint::Ball(acting.platform, toSim(chain.platform), elbow, tip);
      acting.driven.insert(acting.driven.end(), {yaw, lift});
      hinges.insert(hinges.end(), {yaw, lift, elbow});
    }
  }

  void build(const DeltaParameters& device) {
    setGravity(device.gravity);
    acting.friction = device.motor.viscousFriction;
    acting.damping.head<3>() = device.platform.damping;
    MobilizedBody::Translation platform(matter.Ground(),
                                        SimTK::Body::Rigid(pointMass(device.platform.mass, Vec3::Zero())));
    acting.platform = platform;
    const DeltaGeometry& g = device.geometry;
    const double bars = 2.0 * device.bar.mass;
    const Vec3 across = -Vec3::UnitY();  // axis of a rotation towards the user
    for (const double phi : g.phi) {
      const SimTK::Rotation leg(phi, SimTK::ZAxis), none;
      const Mat3 turn = fromSim(leg);
      const UpperLinkParameters& u = device.upperLink;
      MobilizedBody upper =
          hinge(matter.Ground(), leg, turn * Vec3(g.r, g.s, 0.0) - device.homeDistance * Vec3::UnitZ(), across,
                massOf(u.mass, u.com * Vec3::UnitX(), disc(across, u.inertia + device.motor.rotorInertia)));
      // A uniform rod moves like a sixth of its mass at each end and the rest in the middle.
      MobilizedBody near = hinge(upper, none, g.a * Vec3::UnitX(), across, pointMass(bars / 6.0, g.e * Vec3::UnitX()));
      MobilizedBody bar =
          hinge(near, none, g.e * Vec3::UnitX(), Vec3::UnitZ(), pointMass(bars * 2.0 / 3.0, 0.5 * g.b * Vec3::UnitX()));
      MobilizedBody far =
          hinge(platform, leg, turn * Vec3(g.c, g.f, 0.0), across, pointMass(bars / 6.0, -g.d * Vec3::UnitX()));
      const SimTK::Constraint::Ball joint(bar, SimTK::Vec3(g.b, 0.0, 0.0), far, SimTK::Vec3(-g.d, 0.0, 0.0));
      // The crossbars stay parallel.
      SimTK::Array_<SimTK::MobilizedBodyIndex> bodies;
      for (const MobilizedBody* body : {&upper, &near, &far}) bodies.push_back(body->getMobilizedBodyIndex());
      const SimTK::Constraint::CoordinateCoupler parallel(
          matter, new SimTK::Function::Linear(SimTK::Vector(SimTK::Vec4(1.0, 1.0, -1.0, 0.0))), bodies,
          SimTK::Array_<SimTK::MobilizerQIndex>(3, SimTK::MobilizerQIndex(0)));
      acting.driven.push_back(upper);
      hinges.insert(hinges.end(), {upper, near, bar, far});
    }
  }

  void build(const CartesianParameters& device) {
    setGravity(device.gravity);
    acting.damping = device.damping;
    acting.cartesian = mechanism.get();
    const SimTK::Body::Rigid body(massOf(device.mass, Vec3::Zero(), device.inertia));
    if (device.axes == 6)
      acting.platform = MobilizedBody::Free(matter.Ground(), body);
    else
      acting.platform =
          MobilizedBody::Translation(matter.Ground(), SimTK::Body::Rigid(pointMass(device.mass, Vec3::Zero())));
  }

  // Set angles and rates of the hinges, chain by chain.
  void setHinges(const TauParameters& device, const Kinematics& k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const ChainParameters& chain = device.chain[i];
      const auto j = static_cast<Eigen::Index>(2 * i);
      const double a = k.q[j], b = k.q[j + 1];
      const Vec3 u(std::sin(a), 0.0, std::cos(a)), t(std::cos(a), 0.0, -std::sin(a)), y = Vec3::UnitY();
      const Vec3 arm = k.pose.rotation * chain.platform, tip = k.pose.position + arm;
      const Vec3 l1 = std::cos(b) * u + std::sin(b) * y, knee = chain.base + chain.link1.length * l1;
      const double w = std::atan2((tip - knee).dot(y), (tip - knee).dot(u));
      const Vec3 tipRate = k.twist.head<3>() + k.twist.tail<3>().cross(arm);
      const Vec3 kneeRate = (k.rates[j] * y - k.rates[j + 1] * t).cross(knee - chain.base);
      const Vec3 rise = -std::sin(w) * u + std::cos(w) * y;  // of link 2
      set(3 * i, a, k.rates[j]);
      set(3 * i + 1, b, k.rates[j + 1]);
      set(3 * i + 2, w - b, (tipRate - kneeRate).dot(rise) / chain.link2.length - k.rates[j + 1]);
    }
  }
  void setHinges(const DeltaParameters& device, const Kinematics& k) {
    const DeltaGeometry& g = device.geometry;
    for (std::size_t i = 0; i < 3; ++i) {
      const Mat3 turn = fromSim(SimTK::Rotation(g.phi[i], SimTK::ZAxis));
      const double t1 = k.q[static_cast<Eigen::Index>(i)], rate = k.rates[static_cast<Eigen::Index>(i)];
      const Vec3 p = turn.transpose() * k.pose.position, v = turn.transpose() * k.twist.head<3>();
      const Vec3 across(0.0, 1.0, 0.0), l1(std::cos(t1), 0.0, std::sin(t1)), up(-std::sin(t1), 0.0, std::cos(t1));
      const Vec3 lower = p + Vec3(g.c - g.r, g.f - g.s, device.homeDistance) - g.a * l1;
      const Vec3 lowerRate = v - g.a * rate * up;
      const double t2 = std::atan2(lower.z(), lower.x()), reach = std::hypot(lower.x(), lower.z());
      const double lateral = std::asin(lower.y() / g.b);  // of the bar, from l2
      const Vec3 rise(-std::sin(t2), 0.0, std::cos(t2));
      const double t2Rate = lowerRate.dot(rise) / reach;
      set(4 * i, t1, rate);
      set(4 * i + 1, t2 - t1, t2Rate - rate);
      set(4 * i + 2, lateral, lowerRate.y() / (g.b * std::cos(lateral)));
      set(4 * i + 3, t2, t2Rate);
    }
  }
  void setHinges(const CartesianParameters&, const Kinematics&) {}

  void set(std::size_t hinge, double angle, double rate) {
    hinges[hinge].setOneQ(state, 0, angle);
    hinges[hinge].setOneU(state, 0, rate);
  }

  void set(const Kinematics& k) {
    goesOn = false;
    state.setTime(0.0);
    std::visit([&](const auto& device) { setHinges(device, k); }, parameters);
    // The platform's joint: from frame F of its parent to its own frame M.
    const MobilizedBody &platform = acting.platform, &parent = platform.getParentMobilizedBody();
    const SimTK::Transform body(rotationOf(k.pose.rotation), toSim(k.pose.position));
    const SimTK::Transform M = body * platform.getOutboardFrame(state);
    system.realize(state, SimTK::Stage::Position);
    const SimTK::Transform F = parent.getBodyTransform(state) * platform.getInboardFrame(state);
    platform.setQToFitTransform(state, ~F * M);
    system.realize(state, SimTK::Stage::Velocity);
    const SimTK::SpatialVec twist = spatial(k.twist), carried = parent.getBodyVelocity(state);
    const SimTK::Vec3 turn = twist[0] - carried[0], way = twist[1] + twist[0] % (M.p() - body.p()) - carried[1] -
                                                          carried[0] % (M.p() - parent.getBodyOriginLocation(state));
    platform.setUToFitVelocity(state, SimTK::SpatialVec(~F.R() * turn, ~F.R() * way));
  }

  // Continue the motion of another model of the same device, with the next step size of its integrator.
  void takeMotion(const Model& from) {
    state.updQ() = from.state.getQ();
    state.updU() = from.state.getU();
    state.setTime(from.state.getTime());
    goesOn = from.goesOn;
    if (!goesOn) return;
    integrator->setInitialStepSize(from.integrator->getPredictedNextStepSize());
    integrator->initialize(state);
    integrator->setInitialStepSize(-1.0);  // the default
    // initialize() projects onto the constraints, which changes the last bits.
    integrator->updAdvancedState().updY() = from.integrator->getAdvancedState().getY();
  }

  DeviceState platformOf(const SimTK::State& moving) const {
    system.realize(moving, SimTK::Stage::Velocity);
    const SimTK::Transform& at = acting.platform.getBodyTransform(moving);
    DeviceState now;
    now.position = fromSim(at.p());
    now.orientation = Eigen::Quaternion<double>(fromSim(at.R()));
    now.twist = fromSpatial(acting.platform.getBodyVelocity(moving));
    return now;
  }
};

MultibodyPlant::MultibodyPlant(const DeviceParameters& parameters, double accuracy)
    : MultibodyPlant(std::make_unique<Model>(parameters, accuracy)) {}

MultibodyPlant::MultibodyPlant(std::unique_ptr<Model> model) : Plant(*model->mechanism), model_(std::move(model)) {}

MultibodyPlant::~MultibodyPlant() = default;

std::unique_ptr<Plant> MultibodyPlant::clone() const {
  auto model = std::make_unique<Model>(model_->parameters, model_->accuracy);
  model->takeMotion(*model_);
  std::unique_ptr<MultibodyPlant> copy(new MultibodyPlant(std::move(model)));
  copy->state_ = state_;
  return copy;
}

Status MultibodyPlant::start(const Pose& pose) {
  Kinematics k;
  if (const Status status = mechanism().reach(pose, Vec6::Zero(), false, k); status != Status::ok) return status;
  model_->set(k);
  state_ = model_->platformOf(model_->state);
  return Status::ok;
}

Status MultibodyPlant::advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept {
  if (torque.size() != mechanism().joints()) return Status::outOfRange;
  if (!torque.allFinite()) return Status::notFinite;
  if (!(duration > 0.0)) return Status::ok;
  Model& m = *model_;
  m.acting.torque = torque;
  m.acting.load = &load;
  try {
    if (!m.goesOn) m.integrator->initialize(m.state);
    m.goesOn = false;  // until the tick is finished
    const double end = m.integrator->getTime() + duration;
    m.acting.timeAhead = time - m.integrator->getTime();
    m.integrator->updAdvancedState().invalidateAllCacheAtOrAbove(SimTK::Stage::Dynamics);  // new torque and load
    m.integrator->reinitialize(SimTK::Stage::Dynamics, false);
    while (m.integrator->getTime() < end)  // stop at the end of the tick: the next torque is unknown
      if (m.integrator->stepTo(end, end) == SimTK::Integrator::EndOfSimulation) return Status::notConverged;
    const SimTK::State& moved = m.integrator->getAdvancedState();
    const DeviceState now = m.platformOf(moved);
    if (!isWithinSpeedLimits(now)) return Status::outOfRange;
    m.state.updQ() = moved.getQ();
    m.state.updU() = moved.getU();
    m.state.setTime(moved.getTime());
    m.goesOn = true;
    state_ = now;
  } catch (...) {  // Simbody throws if steps become too short
    return Status::notConverged;
  }
  return Status::ok;
}

void MultibodyPlant::read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept {
  Plant::read(truth, q, rates);
  const std::vector<MobilizedBody>& driven = model_->acting.driven;
  for (std::size_t i = 0; i < driven.size(); ++i) {
    q[static_cast<Eigen::Index>(i)] = driven[i].getOneQ(model_->state, 0);
    rates[static_cast<Eigen::Index>(i)] = driven[i].getOneU(model_->state, 0);
  }
}

Status MultibodyPlant::accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) {
  Kinematics k;
  if (const Status status = mechanism().reach(pose, twist, false, k); status != Status::ok) return status;
  Model& m = *model_;
  m.set(k);
  m.acting.torque = torque;
  const auto constant = [&](double, const Pose&, const Vec6&) { return wrench; };
  const ExternalWrench load(constant);
  m.acting.load = &load;
  m.system.realize(m.state, SimTK::Stage::Acceleration);
  acceleration = fromSpatial(m.acting.platform.getBodyAcceleration(m.state));
  state_ = m.platformOf(m.state);
  return Status::ok;
}

double MultibodyPlant::closureError() const {
  double largest = 0.0;
  model_->system.realize(model_->state, SimTK::Stage::Position);
  const SimTK::Vector& errors = model_->state.getQErr();
  for (int i = 0; i < errors.size(); ++i) largest = std::max(largest, std::abs(errors[i]));
  return largest;
}

MakePlant multibodyPlants(const DeviceParameters& parameters) {
  return [parameters](std::uint32_t) { return std::make_unique<MultibodyPlant>(parameters); };
}

}  // namespace enamel
