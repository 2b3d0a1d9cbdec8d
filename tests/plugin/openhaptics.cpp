// The driver of OpenHaptics with a stand-in of the vendor's library: devices, axes, errors, a silent host, and a wall.
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/driver_bench.hpp"
#include "support/unplugged_session.hpp"

namespace enamel::test_openhaptics {

using test::ContainsSubstring;
using test::openAt;

namespace {

const std::string kFolder = ENAMEL_PLUGINS, kLibrary = ENAMEL_HD_STAND_IN;

// At rest, without faults.
struct StandIn : test::StandIn {
  StandIn() : test::StandIn(kLibrary, "hd") {
    for (const char* fault : {"touch-x", "absent", "max-force", "button", "unplugged", "fault", "warm", "heat",
                              "uncalibrated", "stalled", "manual", "place-z", "turn-x", "turn-y", "turn-z"})
      set(fault, 0.0);
  }
};

std::string urlOf(const std::string& name = "Default Device") {
  return "openhaptics://" + name + "?library=" + kLibrary;
}

struct Bench : test::DriverBench {
  Bench() : test::DriverBench(urlOf()) {}
};

}  // namespace

TEST_CASE("the OpenHaptics driver keeps the contract on each device, and allocates nothing", "[openhaptics]") {
  StandIn standIn;
  for (const auto& [isX, file] : {std::pair<double, const char*>{0.0, "touch.toml"}, {1.0, "touch-x.toml"}}) {
    standIn.set("touch-x", isX);
    const OpenedDevice opened = openAt(urlOf(""));  // the default device
    CHECK(opened.text == readFile(test::deviceFile(file)));
    CHECK(opened.poll > 0.0);  // the loop follows the vendor's scheduler
    CHECK(opened.facts == std::string(isX != 0.0 ? "Touch X" : "Touch") +
                              ", serial number S-1, firmware 1.5, driver 2023.1, HD API 3.50; at most " +
                              (isX != 0.0 ? "7.9" : "3.3") +
                              " N, 0.88 N continuously; the vendor's springs up to 500 N/m and 2 N s/m");
  }
  standIn.set("touch-x", 0.0);
  test::checkContract("openhaptics", kLibrary);
  test::checkByCommand("openhaptics", "Default Device?library=" + kLibrary);
}

TEST_CASE("refusals of the OpenHaptics driver name the error, its number, and what to do", "[openhaptics]") {
  StandIn standIn;
  const auto refuses = [](const std::string& url, const std::string& message) {
    CHECK_THROWS_WITH(openAt(url), ContainsSubstring('"' + url + '"') && ContainsSubstring(message));
  };
  refuses("openhaptics://?library=/nowhere.so", "the vendor's library cannot be opened: /nowhere.so");
  refuses("openhaptics://?library=" + kFolder + "/enamel_template.so", "has no function hdInitDevice");
  refuses(urlOf() + "&rate=fast", "rate is \"fast\", must be 500 to 10000 Hz");
  refuses(urlOf("Left"), "the device \"Left\" does not open: HD_DEVICE_FAULT (0x0300, internal -7): check the name");
  standIn.set("absent", 0x0600);
  refuses(urlOf(), "HD_INVALID_LICENSE (0x0600, internal -7): install the licence");
  standIn.set("absent", 0x0777);
  refuses(urlOf(), "an error (0x0777, internal -7)");
  standIn.set("absent", 0.0);
  {
    const OpenedDevice first = openAt(urlOf());
    refuses(urlOf(), "HD_DEVICE_ALREADY_INITIATED (0x0301, internal -7): another part of this program uses it");
  }
  OpenedDevice opened = openAt(urlOf());
  standIn.set("uncalibrated", 2.0);
  CHECK_THROWS_WITH(opened.device->open(), ContainsSubstring("the Touch is not calibrated: put the stylus"));
  standIn.set("uncalibrated", 1.0);  // the driver updates it
  opened.device->open();
  opened.device->close();
  standIn.set("fault", 1.0);
  CHECK_THROWS_WITH(opened.device->open(), ContainsSubstring("the scheduler does not start: HD_TIMER_ERROR (0x0304"));
}

TEST_CASE("positions, turns, forces and buttons of a Touch are those of W, from the middle of its workspace",
          "[openhaptics]") {
  StandIn standIn;
  standIn.set("touch-x", 1.0);
  Bench bench;
  for (int axis = 0; axis < 3; ++axis)
    for (const double force : {5.0, -5.0}) {
      bench.command.effort.setZero();
      bench.command.effort[axis] = force;
      INFO(axis << " " << force);
      // The hand has 100 N/m: 50 mm in the direction of the force, and nothing across. The friction keeps up to 0.6 mm,
      // and the ripple (1 % of 5 N) up to 0.5 mm along it.
      REQUIRE(bench.soon([&] {
        return std::abs(bench.sample.q[axis] - 0.01 * force) < 1.2e-3 &&
               std::abs(bench.sample.q[(axis + 1) % 3]) < 8e-4 && std::abs(bench.sample.q[(axis + 2) % 3]) < 8e-4;
      }));
    }
  CHECK(bench.sample.enabled);
  const char* const turns[] = {"turn-x", "turn-y", "turn-z"};
  for (int axis = 0; axis < 3; ++axis) {
    standIn.set(turns[axis], 0.5);
    REQUIRE(bench.soon([&] {
      return std::abs(bench.sample.q[3 + axis] - 0.5) < 0.01 && std::abs(bench.sample.q[3 + (axis + 1) % 3]) < 0.01;
    }));
    standIn.set(turns[axis], 0.0);
  }
  standIn.set("button", 1.0);
  CHECK(bench.soon([&] { return bench.sample.buttons == 2; }));
}

TEST_CASE("a force on a Touch is cut at its length, because the vendor refuses a longer one as a whole",
          "[openhaptics]") {
  StandIn standIn;
  for (const double largest : {3.3, 2.0}) {
    standIn.set("max-force", largest);
    Bench bench;
    bench.command.effort << 30.0, 40.0, 0.0, 0.0, 0.0, 0.0;
    REQUIRE(bench.soon([&] { return standIn.force().norm() > 0.0; }));
    CHECK((standIn.force() - largest * Vec3(0.6, 0.8, 0.0)).norm() < 1e-9);  // rounding
    CHECK(bench.sample.enabled);
  }
}

TEST_CASE("faults of a Touch are missing samples, a disabled device or a lost one", "[openhaptics]") {
  StandIn standIn;
  Bench bench;
  REQUIRE(bench.soon([] { return true; }));
  CHECK(bench.sample.conditions == 0);
  standIn.set("warm", 1.0);  // the device cuts its forces by itself
  REQUIRE(bench.soon([&] { return !bench.sample.enabled; }));
  CHECK(bench.sample.conditions == kForcesCut);
  standIn.set("warm", 0.0);
  REQUIRE(bench.soon([&] { return bench.sample.enabled; }));
  standIn.set("heat", 0.7);
  standIn.set("uncalibrated", 2.0);
  REQUIRE(bench.soon([&] { return bench.sample.heat == 0.7 && bench.sample.conditions == kUncalibrated; }));
  standIn.set("uncalibrated", 0.0);
  standIn.set("stalled", 1.0);
  REQUIRE(test::eventually([&] { return bench.tick() == Status::stale; }));
  CHECK(bench.tick() == Status::stale);
  standIn.set("stalled", 0.0);
  REQUIRE(bench.soon([] { return true; }));
  standIn.set("unplugged", 1.0);
  REQUIRE(test::eventually([&] { return bench.tick() == Status::inactive; }));
  CHECK(bench.opened.device->actuate(bench.command) == Status::inactive);
  bench.opened.device->close();
  CHECK_THROWS_WITH(bench.opened.device->open(), ContainsSubstring("HD_COMM_ERROR (0x0302, internal -7): check power"));
  standIn.set("unplugged", 0.0);
  bench.opened.device->open();
  CHECK(bench.soon([&] { return bench.sample.enabled; }));
  standIn.set("unplugged", 1.0);
  REQUIRE(test::eventually([&] { return bench.tick() == Status::inactive; }));
  standIn.set("unplugged", 0.0);
  CHECK(bench.soon([&] { return bench.sample.enabled; }));  // without open()
}

TEST_CASE("a Touch is released when its host is silent, and when it is closed", "[openhaptics]") {
  StandIn standIn;
  Bench bench;
  bench.command.effort[1] = 1.0;
  REQUIRE(bench.soon([&] { return standIn.force().y() == 1.0; }));
  REQUIRE(test::eventually([&] { return standIn.force().isZero(); }));  // no command any more
  REQUIRE(bench.soon([&] { return standIn.force().y() == 1.0; }));
  bench.opened.device->close();
  CHECK(standIn.force().isZero());
}

TEST_CASE("a session feels a wall with the OpenHaptics driver", "[openhaptics]") {
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
    // The hand has 100 N/m.
    return session.snapshot().tick.mode == RenderMode::contact && std::abs(standIn.force().z() - 0.2) < 0.05;
  }));
  session.stop();
}

TEST_CASE(
    "a session stops when the device of the OpenHaptics driver is unplugged in contact, and continues after a reset",
    "[openhaptics]") {
  StandIn standIn;
  test::checkUnpluggedInContact(
      urlOf(), kFolder, 2e-3, [&](bool on) { standIn.set("unplugged", on); },
      [&] { return std::abs(standIn.force().z()); });  // 2 mm inside
}

TEST_CASE("the command prints what a Touch reports", "[openhaptics]") {
  test::checkReported("button 1 heat 0.7 warm 1", urlOf(),
                      {"device: Touch, serial number S-1, firmware 1.5", "springs up to 500 N/m",
                       "the device has cut its forces by itself", "buttons pressed: 1; hottest motor 70 % of its limit",
                       "; forces cut by the device in "});
}

TEST_CASE("the list has a Touch whose library the system finds", "[openhaptics]") {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink(kLibrary, folder / "libHD.so");
  const auto result = test::runCommand("LD_LIBRARY_PATH='" + folder / "" + "' '" ENAMEL_TOOL "' devices");
  INFO(result.output);
  CHECK_THAT(result.output, ContainsSubstring("connected: openhaptics://Default Device  Touch S-1"));
}

}  // namespace enamel::test_openhaptics
