// A tool rests on a wall, and one fault occurs: the expected behaviour, case by case.
#include "support/pressed_wall.hpp"

#include "support/catch.hpp"

namespace enamel::test_pressed_wall {

using test::PressedWall;
using test::PressResult;
using test::run;

namespace {

PressedWall withDriver(std::function<Status(int, Measurement&)> driver) {
  PressedWall press;
  press.driver = std::move(driver);
  return press;
}

PressedWall withHost(double force, std::function<void(int, Scene&)> host) {
  PressedWall press;
  press.force = force;
  press.host = std::move(host);
  return press;
}

Vec6 upward(double speed) {
  Vec6 twist = Vec6::Zero();
  twist[2] = speed;
  return twist;
}

// The driver reports that no torque acted, whatever the motors did.
PressedWall appliedZero() {
  return withDriver([](int tick, Measurement& sample) {
    if (tick >= 0) sample.applied->setZero();
    return Status::ok;
  });
}

// The wall stays in place, but the host reports a velocity.
PressedWall restingWallClaims(double speed) {
  return withHost(8.0, [=](int tick, Scene& scene) {
    if (tick >= 0) (void)scene.move(0, scene.obstacles()[0].pose, upward(speed));
  });
}

PressedWall samplesEvery(double period) {
  PressedWall press;
  press.period = period;
  return press;
}

PressedWall oneSampleWith(Status status) {
  return withDriver([=](int tick, Measurement&) { return tick == 0 ? status : Status::ok; });
}

// In one sample, joint 0 is wrong by this number of counts.
PressedWall oneSampleOff(const std::string& device, double force, double counts) {
  const double step = makeMechanism(loadDevice(test::deviceFile(device)))->limits().encoderStep[0];
  PressedWall press = withDriver([=](int tick, Measurement& sample) {
    if (tick == 0) sample.q[0] += counts * step;
    return Status::ok;
  });
  press.device = device;
  press.force = force;
  return press;
}

// A wall rises at 20 mm/s for 0.3 s. Every `every` ticks the host sets its pose, with the step divided by one tick as
// its velocity: as an application does that divides by the controller's period.
PressedWall risingWall(int every) {
  return withHost(4.0, [=](int tick, Scene& scene) {
    if (tick < 0 || tick > 300) return;
    Pose pose = scene.obstacles()[0].pose;
    const bool isSet = tick % every == 0 && tick < 300;
    if (isSet) pose.position.z() += 20e-6 * every;
    (void)scene.move(0, pose, upward(isSet ? 20e-6 * every / 1e-3 : 0.0));
  });
}

// An application adds 2 N of vibration after the controller. The device may or may not report the torque that acted.
PressedWall vibrating(bool reportsTorque) {
  PressedWall press = withDriver([=](int, Measurement& sample) {
    if (!reportsTorque) sample.applied.reset();
    return Status::ok;
  });
  press.force = 3.0;
  press.vibration = 2.0;
  return press;
}

}  // namespace

constexpr double kEnergyAtRest = 1e-3;  // J, in 0.5 s

TEST_CASE("pressed wall: without a fault the tool rests on the wall", "[cases]") {
  for (const char* device : {"tau-nominal.toml", "cartesian-6.toml"})
    for (const double force : {4.0, 8.0}) {
      INFO(device << ", " << force << " N");
      PressedWall press;
      press.device = device;
      press.force = force;
      const PressResult result = run(press);
      CHECK(result.finished);
      CHECK(result.guard == GuardReason::none);
      CHECK(result.depthBefore > 0.0);
      CHECK(result.depth < 20e-6);
      CHECK(result.lift < 20e-6);
      if (device != std::string("tau-nominal.toml")) CHECK(result.energy < kEnergyAtRest);
    }
}

TEST_CASE("pressed wall: a TAU at rest is given little energy (expected failure, 1.1 mJ instead of 1)",
          "[!shouldfail][cases]") {
  for (const double force : {4.0, 8.0}) {
    PressedWall press;
    press.device = "tau-nominal.toml";
    press.force = force;
    CHECK(run(press).energy < kEnergyAtRest);
  }
}

// The runs of the cases below before the fault, so that none of the cases fails for another reason.
TEST_CASE("pressed wall: all is well before the fault", "[cases]") {
  for (const PressedWall& press :
       {appliedZero(), restingWallClaims(1.0), oneSampleWith(Status::notFinite), oneSampleWith(Status::stale),
        oneSampleOff("tau-nominal.toml", 8.0, 200.0), oneSampleOff("cartesian-6.toml", 4.0, 20.0), risingWall(17)}) {
    const PressResult result = run(press);
    CHECK(result.depthBefore > 0.0);
    CHECK(result.depthBefore < 20e-6);
  }
  CHECK_NOTHROW(run(samplesEvery(0.4e-3)));
  CHECK(run(vibrating(false)).finished);
}

TEST_CASE("case 01: reports of torque that cannot be true are ignored", "[cases]") {
  const auto zero = [](int tick, JointVector& torque) { tick >= 0 ? (void)torque.setZero() : (void)torque; };
  const auto turned = [](int tick, JointVector& torque) { tick >= 0 ? (void)(torque = -torque) : (void)torque; };
  const auto huge = [](int tick, JointVector& torque) { tick == 0 ? (void)torque.setConstant(100.0) : (void)torque; };
  const std::function<void(int, JointVector&)> reports[] = {zero, turned, huge};
  for (const auto& report : reports) {
    const PressResult result = run(withDriver([&](int tick, Measurement& sample) {
      report(tick, *sample.applied);
      return Status::ok;
    }));
    CAPTURE(&report - reports, result.energy, result.lift, toString(result.guard));
    CHECK((isFault(result.guard) || result.energy < 0.02));
    CHECK(result.lift < 0.1e-3);
    CHECK(result.ignoredReports > 0);
    CHECK(result.energyAtEnd < kEnergyAtRest);
  }
  CHECK(run(PressedWall()).ignoredReports == 0);
  CHECK(run(vibrating(true)).ignoredReports == 0);  // the report contains the application's addition
}

TEST_CASE("case 02: a wall at rest that claims to move does not", "[cases]") {
  for (const double speed : {0.1, 1.0, -1.0, 50.0}) {
    const PressResult result = run(restingWallClaims(speed));
    CAPTURE(speed, result.energy, result.lift, toString(result.guard));
    CHECK(result.guard == GuardReason::none);
    CHECK(result.energy < 2.0 * kEnergyAtRest);
    CHECK(result.lift < 20e-6);
  }
}

TEST_CASE("case 03: with samples every 0.4 ms the wall holds or a fault says why not", "[cases]") {
  const PressResult result = run(samplesEvery(0.4e-3));
  CAPTURE(result.depth, toString(result.guard));
  CHECK((isFault(result.guard) || result.depth < 0.5e-3));
}

TEST_CASE("case 09: a driver that fails is a fault", "[cases]") {
  for (const Status status : {Status::notFinite, Status::outOfRange, Status::inactive, Status::stopped}) {
    CAPTURE(toString(status));
    CHECK(run(oneSampleWith(status)).guard == GuardReason::device);
  }
  CHECK(run(oneSampleWith(Status::stale)).guard == GuardReason::none);
}

TEST_CASE("case 03: samples faster than half a period are a fault, slower ones are accepted", "[cases]") {
  CHECK(run(samplesEvery(0.4e-3)).guard == GuardReason::early);
  CHECK(run(samplesEvery(0.6e-3)).guard == GuardReason::none);
}

TEST_CASE("case 10: one sample 200 counts off moves the tool by less than 0.2 mm", "[cases]") {
  const PressResult result = run(oneSampleOff("tau-nominal.toml", 8.0, 200.0));
  CAPTURE(result.lift, toString(result.guard));
  CHECK(result.lift < 0.2e-3);
}

TEST_CASE("case 10: one sample 20 counts off is not taken for a frozen encoder", "[cases]") {
  CHECK(run(oneSampleOff("cartesian-6.toml", 4.0, 20.0)).guard != GuardReason::frozen);
}

TEST_CASE("case 19: one lost sample lets the tool sink by less than 10 um", "[cases]") {
  const PressResult result = run(oneSampleWith(Status::stale));
  CAPTURE(result.depthBefore, result.depth);
  CHECK(result.depth < 10e-6);
}

TEST_CASE("case 20: a wall that rises at 20 mm/s carries the tool if its pose is set at every tick", "[cases]") {
  const PressResult result = run(risingWall(1));
  CHECK(result.finished);
  CHECK(result.guard == GuardReason::none);
  CHECK(result.lift < 0.1e-3);
}

TEST_CASE("case 20: a wall that rises at 20 mm/s carries the tool if its pose is set 60 times a second", "[cases]") {
  for (const int every : {2, 8, 17, 33}) {
    const PressResult result = run(risingWall(every));
    CAPTURE(every, result.lift, result.energy, toString(result.guard));
    CHECK(result.guard == GuardReason::none);
    CHECK(result.lift < 0.1e-3);
  }
}

TEST_CASE("case 10: samples that are off again and again are a fault", "[cases]") {
  for (const int every : {2, 5}) {
    const double step = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")))->limits().encoderStep[0];
    PressedWall press = withDriver([every, step](int tick, Measurement& sample) {
      if (tick >= 0 && tick % every == 0) sample.q[0] += 200.0 * step;
      return Status::ok;
    });
    press.force = 8.0;
    const PressResult result = run(press);
    CAPTURE(every, result.lift, toString(result.guard));
    CHECK(result.guard == GuardReason::renderer);
  }
}

TEST_CASE("case 23: a vibration behind the controller moves the tool little if the device reports its torque",
          "[cases]") {
  const PressResult result = run(vibrating(true));
  CHECK(result.finished);
  CHECK(result.lift < 50e-6);
}

TEST_CASE("case 23: a vibration behind the controller moves the tool little on a device that cannot report its torque",
          "[cases]") {
  double lift = 0.0;  // largest of several similar runs, because a single one may pass by luck
  for (const double vibration : {1.98, 1.99, 2.0, 2.01, 2.02}) {
    PressedWall press = vibrating(false);
    press.vibration = vibration;
    lift = std::max(lift, run(press).lift);
  }
  CHECK(lift < 50e-6);
}

}  // namespace enamel::test_pressed_wall
