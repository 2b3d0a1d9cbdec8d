// The driver of Force Dimension with a stand-in of the vendor's library: devices, axes, moments, faults, and a wall.
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/driver_bench.hpp"
#include "support/unplugged_session.hpp"

namespace enamel::test_forcedimension {

using test::ContainsSubstring;
using test::openAt;

namespace {

const std::string kFolder = ENAMEL_PLUGINS, kLibrary = ENAMEL_DHD_STAND_IN;

// An omega.3 at rest, without faults. Its forces have the axes of the SDK.
struct StandIn : test::StandIn {
  StandIn() : test::StandIn(kLibrary, "dhd") {
    for (const char* fault :
         {"unplugged", "early", "button", "reset", "off-cause", "turn-x", "turn-y", "turn-z", "place-z"})
      set(fault, 0.0);
    set("power", 1.0);
    set("count", 1.0);
    set("busy", -1.0);
    set("model", 3.0);
  }
};

std::string urlOf(const std::string& index = "0") { return "forcedimension://" + index + "?library=" + kLibrary; }

struct Bench : test::DriverBench {
  Bench() : test::DriverBench(urlOf()) {}
};

}  // namespace

TEST_CASE("the Force Dimension driver keeps the contract on each device, and allocates nothing", "[forcedimension]") {
  StandIn standIn;
  for (const auto& [model, file] :
       {std::pair<double, const char*>{3.0, "omega-3.toml"}, {6.0, "omega-6.toml"}, {7.0, "sigma-7.toml"}}) {
    standIn.set("model", model);
    const OpenedDevice opened = openAt(urlOf());
    CHECK(opened.text == readFile(test::deviceFile(file)));
    CHECK_THAT(opened.facts, ContainsSubstring(", SDK 3.17.6.0"));
    test::checkContract("forcedimension", kLibrary);
  }
  test::checkByCommand("forcedimension", "0?library=" + kLibrary);
}

TEST_CASE("refusals of the Force Dimension driver give the reason", "[forcedimension]") {
  StandIn standIn;
  const auto refuses = [](const std::string& url, const std::string& message) {
    CHECK_THROWS_WITH(openAt(url), ContainsSubstring('"' + url + '"') && ContainsSubstring(message));
  };
  refuses("forcedimension://?library=/nowhere.so", "the vendor's library cannot be opened: /nowhere.so");
  refuses("forcedimension://?library=" + kFolder + "/enamel_template.so", "has no function dhdGetDeviceCount");
  refuses("forcedimension://one?library=" + kLibrary, "must be the number of a device, 0 to 63");
  refuses(urlOf("1"), "device 1 is missing: 1 connected");
  standIn.set("count", 0.0);
  refuses(urlOf(), "no device is connected, or it has no power or is not accessible");
  standIn.set("count", 1.0);
  standIn.set("power", 0.0);
  refuses(urlOf(), "the omega.3 has no power");
}

TEST_CASE("positions and forces of each Force Dimension device have the axes of W", "[forcedimension]") {
  StandIn standIn;
  for (const double model : {3.0, 6.0, 7.0}) {
    standIn.set("model", model);
    Bench bench;
    for (int axis = 0; axis < 3; ++axis)
      for (const double force : {0.5, -0.5}) {
        bench.command.effort.setZero();
        bench.command.effort[axis] = force;
        INFO(model << " " << axis << " " << force);
        // The hand has 100 N/m: 5 mm in the direction of the force, and nothing across.
        REQUIRE(test::eventually([&] {
          return bench.tick() == Status::ok && std::abs(bench.sample.q[axis] - 0.01 * force) < 2e-4 &&
                 std::abs(bench.sample.q[(axis + 1) % 3]) < 2e-4 && std::abs(bench.sample.q[(axis + 2) % 3]) < 2e-4;
        }));
      }
    CHECK(bench.sample.enabled);
    bench.command.effort[0] = 1e3;
    (void)bench.tick();
    CHECK(std::abs(standIn.force(1)) <= 20.0);  // x of W is y of the SDK
    CHECK(bench.sample.gripper.has_value() == (model == 7.0));
    for (const double force : {1.5, -1.5, 100.0}) {
      bench.command.gripper = force;
      (void)bench.tick();
      CHECK(standIn.force(6) == (model == 7.0 ? std::min(force, 8.0) : 0.0));
    }
  }
}

TEST_CASE("rotations and moments of Force Dimension devices have the axes of W", "[forcedimension]") {
  StandIn standIn;
  for (const double model : {6.0, 7.0}) {
    standIn.set("model", model);
    Bench bench;
    standIn.set("turn-x", 0.5);  // about the axis towards the user: z of W
    REQUIRE(test::eventually([&] {
      return bench.tick() == Status::ok && std::abs(bench.sample.q[5] - 0.5) < 0.01 &&
             std::abs(bench.sample.q[3]) < 0.01 && std::abs(bench.sample.q[4]) < 0.01;
    }));
    standIn.set("turn-y", 0.4);  // x of W
    REQUIRE(test::eventually([&] {
      return bench.tick() == Status::ok && std::abs(bench.sample.q[5] - 0.5) < 0.01 &&
             std::abs(bench.sample.q[3] - 0.4) < 0.01;
    }));
    // Efforts of a wrench J^T F become that wrench, in the axes of the SDK; without motors the moment is zero.
    Kinematics k = bench.opened.mechanism->home();
    REQUIRE(bench.opened.mechanism->track(bench.sample.q, bench.sample.rates, false, k) == Status::ok);
    Vec6 wrench;
    wrench << 0.1, 0.2, 0.3, 0.01, -0.02, 0.03;
    bench.command.effort = torqueOf(k.jacobian, wrench);
    (void)bench.opened.device->actuate(bench.command);
    const double moment = model == 7.0 ? 1.0 : 0.0;
    const double wanted[] = {0.3, 0.1, 0.2, moment * 0.03, moment * 0.01, moment * -0.02};
    for (int i = 0; i < 6; ++i) CHECK(standIn.force(i) == Approx(wanted[i]).margin(1e-9));
    standIn.set("turn-x", 0.0);
    standIn.set("turn-y", 0.0);
  }
}

TEST_CASE("faults of a Force Dimension device are missing samples, a disabled device or a lost one",
          "[forcedimension]") {
  StandIn standIn;
  Bench bench;
  REQUIRE(bench.tick() == Status::ok);
  standIn.set("button", 1.0);
  REQUIRE(bench.tick() == Status::ok);
  CHECK(bench.sample.buttons == 1);
  standIn.set("early", 1.0);
  CHECK(bench.tick() == Status::stale);
  standIn.set("early", 0.0);
  CHECK(bench.tick() == Status::ok);
  CHECK(bench.sample.conditions == 0);
  standIn.set("power", 0.0);  // the power supply fails
  REQUIRE(bench.soon([&] { return !bench.sample.enabled && bench.sample.conditions == kForcesCut; }));
  standIn.set("power", 1.0);
  REQUIRE(bench.soon([&] { return bench.sample.enabled && bench.sample.conditions == 0; }));
  standIn.set("forces", 0.0);
  standIn.set("off-cause", 1.0);  // the force button
  REQUIRE(bench.soon([&] { return !bench.sample.enabled; }));
  CHECK(bench.sample.conditions == 0);
  standIn.set("off-cause", 2.0);  // the device cuts its forces by itself: too fast
  REQUIRE(bench.soon([&] { return bench.sample.conditions == kForcesCut; }));
  standIn.set("reset", 1.0);
  REQUIRE(bench.soon([&] { return bench.sample.conditions == (kForcesCut | kUncalibrated); }));
  standIn.set("unplugged", 1.0);
  CHECK(bench.tick() == Status::inactive);
  CHECK(bench.opened.device->actuate(bench.command) == Status::inactive);
  bench.opened.device->close();
  CHECK_THROWS_WITH(bench.opened.device->open(), ContainsSubstring("device 0 does not open: stand-in"));
  standIn.set("unplugged", 0.0);
  bench.opened.device->open();
  CHECK(bench.tick() == Status::ok);
  standIn.set("unplugged", 1.0);
  CHECK(bench.tick() == Status::inactive);
  standIn.set("unplugged", 0.0);
  CHECK(bench.soon([] { return true; }));  // without open()
  standIn.set("model", 7.0);               // another device on the same cable
  standIn.set("unplugged", 1.0);
  CHECK(bench.tick() == Status::inactive);
  standIn.set("unplugged", 0.0);
  bench.opened.device->close();
  CHECK_THROWS_WITH(bench.opened.device->open(), ContainsSubstring("another device is connected now: the sigma.7"));
  standIn.set("model", 3.0);
  bench.opened.device->open();
  CHECK(test::eventually([&] { return bench.tick() == Status::ok && bench.sample.enabled; }));
}

TEST_CASE("a session feels a wall with the Force Dimension driver", "[forcedimension]") {
  StandIn standIn;
  SessionDef def;
  def.device = urlOf();
  def.pluginFolder = kFolder;
  Session session(def);
  Obstacle wall = flatWall().obstacles()[0];
  wall.pose.position.z() = 2e-3;  // the hand holds the device 2 mm inside
  (void)session.add({wall});
  session.startOpened();
  REQUIRE(test::eventually([&] {
    if (session.snapshot().fault != GuardReason::none) session.reset();  // on a busy machine a tick may come late
    // The hand has 100 N/m, and its force along z is x of the SDK.
    return session.snapshot().tick.mode == RenderMode::contact && std::abs(standIn.force(0) - 0.2) < 0.05;
  }));
  session.stop();
}

TEST_CASE("a session sets the force of the gripper, and the guard removes it", "[forcedimension]") {
  StandIn standIn;
  standIn.set("model", 7.0);
  SessionDef def;
  def.device = urlOf();
  def.pluginFolder = kFolder;
  Session session(def);
  CHECK_THROWS_WITH(session.setGripper(std::nan("")), ContainsSubstring("the force of the gripper must be finite"));
  session.setGripper(2.0);
  session.startOpened();
  const auto has = [&](double force) {
    return test::eventually([&] {
      if (session.snapshot().fault != GuardReason::none) session.reset();  // on a busy machine a tick may come late
      return standIn.force(6) == force;
    });
  };
  REQUIRE(has(2.0));
  // 2 N open the fingers by 0.2 rad.
  CHECK(test::eventually([&] { return session.snapshot().tick.measurement.gripper == 0.25 + 0.1 * 2.0; }));
  session.enable(false);
  CHECK(has(0.0));
  session.enable(true);
  CHECK(has(2.0));
  session.stop();
  CHECK(standIn.force(6) == 0.0);
}

TEST_CASE(
    "a session stops when the device of the Force Dimension driver is unplugged in contact, and continues after a "
    "reset",
    "[forcedimension]") {
  StandIn standIn;
  test::checkUnpluggedInContact(
      urlOf(), kFolder, 2e-3, [&](bool on) { standIn.set("unplugged", on); },
      [&] { return std::abs(standIn.force(0)); });  // 2 mm inside
}

TEST_CASE("the command prints what a Force Dimension device reports", "[forcedimension]") {
  test::checkReported("model 7 button 1 gripper 0.3 reset 1", urlOf(),
                      {"device: sigma.7, SDK 3.17.6.0", "the device is not calibrated",
                       "buttons pressed: 0; gripper 0.300", "; not calibrated in "});
}

TEST_CASE("a device without access does not hide the others in the list", "[forcedimension]") {
  StandIn standIn;
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink(kLibrary, folder / "libdhd.so.3");
  const auto result = test::runCommand("ENAMEL_STAND_IN='count 2 busy 0' LD_LIBRARY_PATH='" + folder / "" +
                                       "' '" ENAMEL_TOOL "' devices");
  INFO(result.output);
  CHECK_THAT(result.output, ContainsSubstring("forcedimension://0  cannot be opened: device 0 does not open") &&
                                ContainsSubstring("connected: forcedimension://1  omega.3"));
}

}  // namespace enamel::test_forcedimension
