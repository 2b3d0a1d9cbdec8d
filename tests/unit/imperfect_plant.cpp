// The imperfect plant: its limit without imperfections, and each imperfection compared with its formula.
#include "enamel/sim/imperfect_plant.hpp"

#include <cmath>

#include "enamel/core/error.hpp"
#include "enamel/sim/virtual_device.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_imperfect_plant {

namespace {

constexpr double kTick = 1e-3;  // s

const auto spring = [](double time, const Pose& pose, const Vec6& twist) {
  Vec6 wrench = Vec6::Zero();
  wrench.head<3>() = -300.0 * pose.position - 2.0 * twist.head<3>();
  wrench[2] += 3.0 * std::sin(50.0 * time);
  return wrench;
};
const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };

// Return the state after `ticks` with slightly more than gravity's torque.
DeviceState after(Plant& plant, int ticks) {
  REQUIRE(plant.start(Pose()) == Status::ok);
  JointVector torque = plant.mechanism().home().gravity;
  for (Eigen::Index i = 0; i < torque.size(); ++i) torque[i] += 0.01 * (i % 2 == 0 ? 1.0 : -0.7);
  for (int i = 0; i < ticks; ++i) REQUIRE(plant.advance(i * kTick, kTick, torque, spring) == Status::ok);
  return plant.state();
}

double distance(const DeviceState& a, const DeviceState& b) {
  return (a.position - b.position).norm() + 0.1 * angleBetween(a.pose().rotation, b.pose().rotation);
}

TauParameters with(const Imperfections& imperfections) {
  TauParameters device = test::nominal();
  device.imperfections = imperfections;
  return device;
}

Imperfections cable(double stiffness, double damping = 0.0) {
  Imperfections e;
  e.cableStiffness = stiffness;
  e.cableDamping = damping;
  return e;
}

// Return the present reading of the encoders.
Measurement readOf(const Plant& plant) {
  Kinematics truth;
  REQUIRE(plant.mechanism().reach(plant.state().pose(), plant.state().twist, false, truth) == Status::ok);
  Measurement m;
  plant.read(truth, m.q, m.rates);
  return m;
}

}  // namespace

TEST_CASE("imperfect plant: without imperfections it comes to the closed form as the square of its step",
          "[imperfect_plant]") {
  for (const DeviceParameters& parameters :
       {DeviceParameters(test::nominal()), loadDevice(test::deviceFile("delta.toml"))}) {
    DeviceParameters ideal = parameters;
    if (auto* delta = std::get_if<DeltaParameters>(&ideal)) delta->imperfections = {};
    const ImperfectDevice device = makeImperfectDevice(ideal, 1);
    CHECK(device.offset.cwiseAbs().maxCoeff() == 0.0);
    ClosedFormPlant closed(*device.mechanism, Integrator::rungeKutta4, 20);
    const DeviceState end = after(closed, 100);
    const auto error = [&](double step) {
      ImperfectPlant imperfect(device, step);
      return distance(after(imperfect, 100), end);
    };
    const double whole = error(2.5e-4), half = error(1.25e-4), fine = error(1e-5);
    INFO(whole << " " << half << " " << fine);
    CHECK(whole < 3e-7);  // m, after 100 ms
    CHECK(whole / half == Approx(4.0).epsilon(0.05));
    CHECK(whole / fine == Approx(625.0).epsilon(0.05));
  }
}

TEST_CASE("imperfect plant: a stiff cable comes to a rigid one as 1 / k", "[imperfect_plant]") {
  const ImperfectDevice rigid = makeImperfectDevice(with({}), 1);
  ImperfectPlant reference(rigid, 1e-5);
  const DeviceState end = after(reference, 30);
  // Damped by a fifth of critical, so that the ringing has decayed.
  const auto error = [&](double k) {
    const ImperfectDevice device = makeImperfectDevice(with(cable(k, 0.4 * std::sqrt(k * 1e-4))), 1);
    ImperfectPlant plant(device, 1e-5);
    return distance(after(plant, 30), end);
  };
  const double soft = error(1e3), stiff = error(4e3);
  INFO(soft << " " << stiff);
  CHECK(soft < 1e-3);
  CHECK(soft / stiff == Approx(4.0).epsilon(0.3));  // the next term has the order of the remaining difference
}

TEST_CASE("imperfect plant: a cable without damping keeps the energy", "[imperfect_plant]") {
  TauParameters parameters = with(cable(220.0));
  parameters.gravity.setZero();
  const ImperfectDevice device = makeImperfectDevice(parameters, 1);
  ImperfectPlant plant(device, 1e-5);
  REQUIRE(plant.start(Pose()) == Status::ok);
  JointVector push = device.mechanism->home().gravity;
  for (Eigen::Index i = 0; i < push.size(); ++i) push[i] = i % 2 == 0 ? 0.5 : -0.4;
  for (int i = 0; i < 5; ++i) REQUIRE(plant.advance(i * kTick, kTick, push, nothing) == Status::ok);
  const JointVector none = JointVector::Zero(push.size());
  const auto energy = [&] {
    Kinematics k;
    REQUIRE(device.mechanism->reach(plant.state().pose(), plant.state().twist, true, k) == Status::ok);
    const Measurement m = readOf(plant);
    const JointVector stretch = m.q - device.offset - k.q;
    return 0.5 * k.rates.dot(k.inertia * k.rates) + 0.5 * device.rotorInertia * m.rates.squaredNorm() +
           0.5 * 220.0 * stretch.squaredNorm();
  };
  const double before = energy();
  REQUIRE(before > 1e-4);
  // The stretch rings: the motion is not rigid.
  double turns = 0.0, last = 0.0;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(plant.advance(i * kTick, kTick, none, nothing) == Status::ok);
    const Kinematics k = [&] {
      Kinematics at;
      REQUIRE(device.mechanism->reach(plant.state().pose(), plant.state().twist, false, at) == Status::ok);
      return at;
    }();
    const double rate = readOf(plant).rates[0] - k.rates[0];
    turns += rate * last < 0.0 ? 1.0 : 0.0;
    last = rate;
  }
  CHECK(turns > 10.0);
  CHECK(energy() == Approx(before).epsilon(1e-6));  // RK4 at 100 steps a period: 1e-8 of the amplitude each
}

TEST_CASE("imperfect plant: friction holds below its limit and takes limit times way beyond it", "[imperfect_plant]") {
  TauParameters parameters = with({});
  parameters.imperfections.coulombFriction = 0.02;
  parameters.gravity.setZero();
  const ImperfectDevice device = makeImperfectDevice(parameters, 1);
  ImperfectPlant plant(device);
  const auto pushed = [&](double torque, int ticks) {
    REQUIRE(plant.start(Pose()) == Status::ok);
    const JointVector each = JointVector::Constant(6, torque);
    const JointVector home = device.mechanism->home().q;
    double farthest = 0.0;
    for (int i = 0; i < ticks; ++i) {
      REQUIRE(plant.advance(i * kTick, kTick, each, nothing) == Status::ok);
      farthest = std::max(farthest, (readOf(plant).q - home).cwiseAbs().maxCoeff());
    }
    return farthest;
  };
  // Half of the limit only moves into the presliding range of 2e-4 rad; six coupled joints swing further than one.
  // While they swing, Dahl's law creeps. Without friction they would be 10 mrad away after 40 ms.
  CHECK(pushed(0.01, 200) < 1.2e-3);
  CHECK(pushed(0.01, 1000) < 2.4e-3);
  CHECK(pushed(0.03, 20) > 4e-3);
  // The motors' work minus the friction's is the kinetic energy.
  REQUIRE(plant.start(Pose()) == Status::ok);
  const JointVector torque = JointVector::Constant(6, 0.05);
  JointVector way = JointVector::Zero(6), last = device.mechanism->home().q;
  for (int i = 0; i < 20; ++i) {
    REQUIRE(plant.advance(i * kTick, kTick, torque, nothing) == Status::ok);
    const JointVector now = readOf(plant).q;
    way += (now - last).cwiseAbs();
    last = now;
  }
  Kinematics k;
  REQUIRE(device.mechanism->reach(plant.state().pose(), plant.state().twist, true, k) == Status::ok);
  const double moved = 0.5 * k.rates.dot(k.inertia * k.rates), done = torque.dot(last - device.mechanism->home().q);
  // Before it slides, each joint's friction takes less: up to 0.02 N m times 2e-4 rad.
  CHECK(done - moved == Approx(0.02 * way.sum()).margin(6 * 0.02 * 2e-4 + 1e-3 * done));
}

TEST_CASE("imperfect plant: amplifier, current loop and cogging", "[imperfect_plant]") {
  // With a cable of almost no stiffness, only the rotor turns: J w' = m + a sin N th.
  Imperfections e = cable(1e-9);
  e.currentBandwidth = 100.0;
  e.torqueStep = 0.01;
  TauParameters parameters = with(e);
  parameters.gravity.setZero();
  const ImperfectDevice device = makeImperfectDevice(parameters, 1);
  ImperfectPlant plant(device, 1e-6);
  REQUIRE(plant.start(Pose()) == Status::ok);
  const JointVector torque = JointVector::Constant(6, 0.0243);  // rounds to 0.02
  const double duration = 2e-3, rate = 2.0 * M_PI * 100.0;
  REQUIRE(plant.advance(0.0, duration, torque, nothing) == Status::ok);
  const double expected = 0.02 / 1e-4 * (duration - (1.0 - std::exp(-rate * duration)) / rate);
  // The current of a step is that at its end: first order in a step of 1 us, 6e-4 of the time constant.
  CHECK(readOf(plant).rates[2] == Approx(expected).epsilon(2e-3));

  // Cogging conserves J w^2 / 2 + (a / N) cos N th.
  Imperfections cogged = cable(1e-9);
  cogged.cogging = 0.01;
  cogged.periods = 40.0;
  parameters.imperfections = cogged;
  const ImperfectDevice other = makeImperfectDevice(parameters, 1);
  ImperfectPlant rotor(other, 1e-5);
  REQUIRE(rotor.start(Pose()) == Status::ok);
  const auto energy = [&] {
    const Measurement m = readOf(rotor);
    return 0.5e-4 * m.rates[1] * m.rates[1] + 0.01 / 40.0 * std::cos(40.0 * (m.q[1] - other.offset[1]));
  };
  const double before = energy();
  const JointVector none = JointVector::Zero(6);
  double most = 0.0;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(rotor.advance(i * kTick, kTick, none, nothing) == Status::ok);
    most = std::max(most, std::abs(readOf(rotor).rates[1]));
  }
  CHECK(most > 0.1);
  CHECK(energy() == Approx(before).epsilon(1e-8));
}

TEST_CASE("imperfect plant: nothing pulls within the backlash", "[imperfect_plant]") {
  Imperfections e = cable(200.0);
  e.backlash = 0.01;
  TauParameters parameters = with(e);
  parameters.gravity.setZero();
  const ImperfectDevice device = makeImperfectDevice(parameters, 1);
  ImperfectPlant plant(device, 1e-5);
  REQUIRE(plant.start(Pose()) == Status::ok);
  const JointVector torque = JointVector::Constant(6, 0.01);
  // A rotor alone reaches the end of half the play after sqrt(b J / tau) = 10 ms.
  for (int i = 0; i < 9; ++i) REQUIRE(plant.advance(i * kTick, kTick, torque, nothing) == Status::ok);
  CHECK(plant.state().twist == Vec6::Zero());
  CHECK(readOf(plant).rates[0] == Approx(0.01 / 1e-4 * 9e-3).epsilon(1e-9));
  for (int i = 9; i < 12; ++i) REQUIRE(plant.advance(i * kTick, kTick, torque, nothing) == Status::ok);
  CHECK(plant.state().twist.norm() > 1e-3);
}

TEST_CASE("imperfect plant: devices differ by their seed within the tolerances", "[imperfect_plant]") {
  const DeviceParameters parameters = test::detailed();
  const auto nominal = makeMechanism(parameters);
  const ImperfectDevice one = makeImperfectDevice(parameters, 1), same = makeImperfectDevice(parameters, 1),
                        two = makeImperfectDevice(parameters, 2);
  CHECK(one.mechanism->home().q == same.mechanism->home().q);
  CHECK(one.offset == same.offset);
  CHECK(one.mechanism->home().q != two.mechanism->home().q);
  CHECK(one.rotorInertia == Approx(1.35e-4).epsilon(0.01));
  for (const ImperfectDevice* device : {&one, &two}) {
    // At rest at home the encoders read the file's values, except for their offsets.
    ImperfectPlant plant(*device);
    REQUIRE(plant.start(Pose()) == Status::ok);
    CHECK((readOf(plant).q - nominal->home().q).cwiseAbs().maxCoeff() <= 0.001 + 1e-12);
    CHECK((readOf(plant).q - nominal->home().q).cwiseAbs().maxCoeff() > 1e-5);
  }
}

TEST_CASE("imperfect plant: a Cartesian device with cables and friction", "[imperfect_plant]") {
  CartesianParameters device;
  device.name = "cables";
  device.mass = 0.15;
  device.rotorMass = 0.03;
  device.halfWidths = Vec3::Constant(0.1);
  device.maxForce = 20.0;
  device.positionStep = 1e-5;
  device.imperfections.cableStiffness = 2e5;
  ImperfectPlant plant(makeImperfectDevice(device, 1));
  REQUIRE(plant.start(Pose()) == Status::ok);
  // Rotor and link swing against each other about a common motion, which the whole mass has.
  const double resonance = std::sqrt(2e5 * (1.0 / 0.03 + 1.0 / 0.12)), step = 1e-5;
  JointVector force = JointVector::Zero(3);
  force[1] = 3.0;
  const auto swing = [](double w, double t) { return (1.0 - std::cos(w * t)) / (w * w); };
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(plant.advance(i * step, step, force, nothing) == Status::ok);
    const double t = (i + 1) * step, common = 0.5 * 3.0 / 0.15 * t * t;
    const double rotor = common + 3.0 / 0.03 * 0.12 / 0.15 * swing(resonance, t);
    REQUIRE(readOf(plant).q[1] == Approx(rotor).margin(1e-10));
    REQUIRE(plant.state().position.y() == Approx(common - 3.0 / 0.15 * swing(resonance, t)).margin(1e-10));
  }

  // Friction below its limit holds every axis that has a motor.
  device.imperfections = {};
  device.imperfections.coulombFriction = 0.5;
  device.driven[2] = false;
  ImperfectPlant rubbing(makeImperfectDevice(device, 1));
  REQUIRE(rubbing.start(Pose()) == Status::ok);
  const auto push = [](double, const Pose&, const Vec6&) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>().setConstant(0.2);
    return wrench;
  };
  for (int i = 0; i < 200; ++i) REQUIRE(rubbing.advance(i * kTick, kTick, JointVector::Zero(3), push) == Status::ok);
  CHECK(rubbing.state().position.head<2>().cwiseAbs().maxCoeff() < 1e-3);
  CHECK(rubbing.state().position.z() == Approx(0.5 * 0.2 / 0.15 * 0.04));
}

TEST_CASE("imperfect plant: stiffened cables leave every other imperfection") {
  DeviceParameters device = test::detailed();
  const Imperfections before = imperfectionsOf(device);
  REQUIRE(before.cableStiffness > 0.0);
  stiffenCables(device);
  const Imperfections after = imperfectionsOf(device);
  CHECK(after.cableStiffness == 0.0);
  CHECK(after.cableDamping == 0.0);
  CHECK(after.backlash == 0.0);
  CHECK(after.coulombFriction == before.coulombFriction);
  CHECK(after.massError == before.massError);
}

TEST_CASE("imperfect plant: steps converge, and what fails changes nothing", "[imperfect_plant]") {
  const ImperfectDevice device = makeImperfectDevice(test::detailed(), 3);
  const auto end = [&](double step) {
    ImperfectPlant plant(device, step);
    return after(plant, 50);
  };
  const DeviceState fine = end(1.25e-6);
  const double whole = distance(end(2.5e-4), fine), tenth = distance(end(2.5e-5), fine);
  INFO(whole << " " << tenth);
  CHECK(whole < 1e-7);  // m, after 50 ms
  CHECK(tenth < 0.2 * whole);

  ImperfectPlant plant(device);
  REQUIRE(plant.start(Pose()) == Status::ok);
  const auto blow = [](double, const Pose&, const Vec6&) { return Vec6(1e6 * Vec6::Unit(2)); };
  const DeviceState before = plant.state();
  const Measurement read = readOf(plant);
  CHECK(plant.advance(0.0, kTick, device.mechanism->home().gravity, blow) != Status::ok);
  CHECK(plant.advance(0.0, kTick, JointVector::Zero(5), nothing) == Status::outOfRange);
  CHECK(plant.advance(0.0, kTick, JointVector::Constant(6, std::nan("")), nothing) == Status::notFinite);
  CHECK(plant.state().position == before.position);
  CHECK(plant.state().twist == before.twist);
  CHECK(readOf(plant).q == read.q);
  Pose away;
  away.position.x() = 1.0;
  CHECK(plant.start(away) != Status::ok);
}

TEST_CASE("virtual device: ticks jitter and samples get lost as the setup says", "[imperfect_plant]") {
  const auto device = makeMechanism(test::nominal());
  VirtualDeviceSetup setup;
  setup.jitter = 0.2;
  setup.lostSamples = 0.1;
  VirtualDevice plant(*device, setup);
  Measurement m;
  int lost = 0;
  double shortest = 1.0, longest = 0.0, last = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Status status = plant.measure(m);
    REQUIRE((status == Status::ok || status == Status::stale));
    lost += status == Status::stale ? 1 : 0;
    const double now = plant.time();
    if (i > 0) shortest = std::min(shortest, now - last), longest = std::max(longest, now - last);
    CHECK(now >= i * 1e-3);
    CHECK(now <= (i + 0.2) * 1e-3);
    last = now;
    REQUIRE(plant.actuate({plant.kinematics().gravity}) == Status::ok);
    REQUIRE(plant.advance(nothing) == Status::ok);
  }
  CHECK(lost > 140);  // 200 on average, four standard deviations
  CHECK(lost < 260);
  CHECK(shortest < 0.9e-3);
  CHECK(longest > 1.1e-3);
  setup.jitter = 1.5;
  CHECK_THROWS_WITH(VirtualDevice(*device, setup), test::ContainsSubstring("jitter is 1.5"));
  setup.jitter = 0.0;
  setup.lostSamples = -0.1;
  CHECK_THROWS_WITH(VirtualDevice(*device, setup), test::ContainsSubstring("lost samples are -0.1"));
}

TEST_CASE("plants: a copy of a plant in motion moves on bit for bit", "[imperfect_plant]") {
  const auto nominal = makeMechanism(test::nominal());
  Imperfections imperfections = cable(220.0, 0.01);
  imperfections.coulombFriction = 0.01;
  imperfections.currentBandwidth = 400.0;
  imperfections.encoderOffset = 1e-4;
  std::vector<std::unique_ptr<Plant>> plants;
  for (const Integrator integrator : {Integrator::rungeKutta4, Integrator::semiImplicitEuler})
    plants.push_back(std::make_unique<ClosedFormPlant>(*nominal, integrator, 3));
  plants.push_back(std::make_unique<ImperfectPlant>(makeImperfectDevice(with(imperfections), 1)));
  for (const auto& plant : plants) {
    (void)after(*plant, 20);
    const auto copy = plant->clone();
    const JointVector torque = 1.1 * plant->mechanism().home().gravity;
    const auto drive = [&](Plant& driven) {
      for (int i = 20; i < 40; ++i) REQUIRE(driven.advance(i * kTick, kTick, torque, spring) == Status::ok);
    };
    const DeviceState before = copy->state();
    drive(*plant);
    CHECK(copy->state().position == before.position);  // it has its own state
    CHECK(plant->state().position != before.position);
    drive(*copy);
    CHECK(copy->state().position == plant->state().position);
    CHECK(copy->state().orientation.coeffs() == plant->state().orientation.coeffs());
    CHECK(copy->state().twist == plant->state().twist);
    const Measurement expected = readOf(*plant), read = readOf(*copy);
    CHECK(read.q == expected.q);
    CHECK(read.rates == expected.rates);
  }
}

}  // namespace enamel::test_imperfect_plant
