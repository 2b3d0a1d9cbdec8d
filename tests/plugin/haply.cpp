// The driver of the Haply Inverse3 with a stand-in of its service: messages, axes, every fault, and a wall.
#include <fcntl.h>
#include <sys/stat.h>

#include <thread>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/session/session.hpp"
#include "plugins/haply/message.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/driver_bench.hpp"
#include "support/haply_service.hpp"
#include "support/process.hpp"
#include "support/unplugged_session.hpp"

namespace enamel::test_haply {

using test::ContainsSubstring;
using test::HaplyService;
using test::openAt;

namespace {

const std::string kFile = test::deviceFile("inverse3.toml");
const std::string kFolder = ENAMEL_PLUGINS;

std::string urlOf(const HaplyService& service, const std::string& options = "") {
  return "haply://" + service.address() + options;
}

struct Bench : test::DriverBench {
  explicit Bench(const HaplyService& service) : test::DriverBench(urlOf(service)) {}
  bool samplesAgain() {
    return soon([] { return true; });
  }
};

}  // namespace

TEST_CASE("messages of the Haply service are read in any order, and others are refused", "[haply]") {
  using haply::readMessage;
  const haply::Message message = readMessage(
      R"( {"session_id": 7, "verse_grip": [{"state": {"buttons": {"c": true, "q": 1, "a": true}}}, {"state": {"buttons": {"b": true}}}],
       "inverse3": [ {"state": {"cursor_velocity": {"z": 3e-1, "x": -1, "y": 2}, "other": [1, {"a": "\"}"}, null],
       "cursor_position": {"x": 0.5, "w": 9, "y": -0.25, "z": 1.0}}, "device_id": "049D",
       "config": {"basis": {"permutation": "XYZ"}, "type": "inverse3"}, "status": {"calibrated": false, "ready": true}},
       {"device_id": "1", "state": {"cursor_position": {"x": 1, "y": 2}}} ] } )");
  REQUIRE(message.isValid);
  REQUIRE(message.count == 2);
  CHECK(message.buttons == 5);
  const haply::DeviceState& d = message.devices[0];
  CHECK(d.id == "049D");
  CHECK(d.type == "inverse3");
  CHECK(d.basis == "XYZ");
  CHECK_FALSE(d.isCalibrated);
  CHECK(d.hasPosition);
  CHECK(d.position == haply::Numbers{0.5, -0.25, 1.0});
  CHECK(d.velocity == haply::Numbers{-1.0, 2.0, 0.3});
  CHECK_FALSE(message.devices[1].hasPosition);
  CHECK(readMessage(R"({"verse_grip":[{"state":{"hall":0,"button":true}}]})").buttons == 1);
  for (const char* turned : {R"("config":{"mount":{"rotation":{"w":0,"x":0,"y":0,"z":1}}})",
                             R"("config":{"mount":{"scale":{"x":1,"y":2,"z":1}}})",
                             R"("state":{"transform":{"rotation":{"w":0.7,"x":0.7}}})"})
    CHECK(readMessage(std::string(R"({"inverse3":[{)") + turned + "}]}").devices[0].isTurned);
  CHECK_FALSE(readMessage(R"({"inverse3":[{"config":{"mount":{"position":{"x":1,"y":2,"z":3},
       "rotation":{"w":1,"x":0,"y":0,"z":0},"scale":{"x":1,"y":1,"z":1}}}}]})")
                  .devices[0]
                  .isTurned);

  const std::string deep(100, '['), valid = R"({"inverse3":[{"device_id":"1"}]})";
  for (const std::string& bad :
       {std::string(), std::string("null"), std::string("{"), std::string("[]"), deep, "{\"a\":" + deep + "}",
        valid + "x", std::string(R"({"inverse3":[{"state":{"cursor_position":{"x":nan,"y":0,"z":0}}}]})"),
        std::string(R"({"inverse3":[{"state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"),
        std::string(R"({"inverse3":[{"state":{"cursor_position":{"x":inf,"y":0,"z":0}}}]})"), std::string(R"({"a":"\)"),
        std::string(R"({"a" 1})"), std::string(R"({"inverse3":{}})")}) {
    INFO(bad);
    CHECK_FALSE(readMessage(bad).isValid);
  }
  CHECK(readMessage(valid).isValid);
  for (std::size_t length = 0; length < valid.size(); ++length)
    CHECK_FALSE(readMessage(valid.substr(0, length)).isValid);
  std::string many = R"({"inverse3":[{})";
  for (int i = 0; i < 20; ++i) many += ",{}";
  CHECK(readMessage(many + "]}").count == 8);
}

TEST_CASE("commands of the Haply service have both formats", "[haply]") {
  std::array<char, haply::kMessageBytes> text{};
  const auto written = [&](haply::Format format, bool isFirst, const haply::Numbers& force) {
    return std::string(text.data(), haply::writeForce("049D", force, format, isFirst, text));
  };
  CHECK(
      written(haply::Format::v35, false, {1.0, -2.5, 0.0}) ==
      R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":1.00000,"y":-2.50000,"z":0.00000}}}}]})");
  CHECK_THAT(written(haply::Format::v31, false, {}), ContainsSubstring(R"("set_cursor_force":{"values":{)"));
  CHECK_THAT(written(haply::Format::v35, true, {}),
             ContainsSubstring(R"({"session":{"configure":{"profile":{"name":"enamel"}}},)"));
  CHECK_THAT(written(haply::Format::v31, true, {}), !ContainsSubstring("session"));
  CHECK(haply::writeForce(std::string(33, 'a'), {}, haply::Format::v35, true, text) == 0);
  CHECK(written(haply::Format::v35, true, {-1e300, 0.0, 0.0}).empty());
}

TEST_CASE("the Haply driver keeps the contract of drivers, and allocates nothing in a tick", "[haply]") {
  const HaplyService service(kFile, 0.02, 0.01);
  // In another process: the service allocates.
  const auto check = test::run("check-driver 'haply://" + service.address() + "?id=049D&delay=1'");
  INFO(check.output);
  CHECK(check.status == 0);
  CHECK_THAT(check.output, ContainsSubstring("the plugin keeps the contract") && ContainsSubstring("Haply Inverse3"));
#ifndef ENAMEL_SANITIZED
  CHECK_THAT(check.output, ContainsSubstring("passed       allocates nothing in measure and actuate"));
#endif
}

TEST_CASE("refusals of the Haply driver give the reason", "[haply]") {
  HaplyService service(kFile, 0.02, 0.01);
  const auto refuses = [&](const std::string& url, const std::string& message) {
    CHECK_THROWS_WITH(openAt(url), ContainsSubstring('"' + url + '"') && ContainsSubstring(message));
  };
  refuses("haply://127.0.0.1:1", "127.0.0.1:1: Connection refused; is this the Haply Inverse service");
  const auto check = test::run("check-driver haply 127.0.0.1:1");  // not a fault of the driver
  CHECK(check.status != 0);
  CHECK_THAT(check.output, ContainsSubstring("Connection refused") && !ContainsSubstring("contract"));
  refuses("haply://127.0.0.1", "must be HOST:PORT, such as localhost:10001");
  refuses("haply://127.0.0.1:99999", "must be HOST:PORT");
  refuses(urlOf(service, "?id=7"), "the service has no Inverse3 \"7\", only 049D");
  refuses(urlOf(service, "?centre=1,2"), "centre is \"1,2\", must be X,Y,Z in m");
  refuses(urlOf(service, "?format=2"), "format is \"2\", must be 3.1 or 3.5");
  refuses(urlOf(service, "?ports=2"), "unknown option \"ports\", possible are id, centre, format");
  refuses(urlOf(service, "?device=" + test::deviceFile("cartesian-6.toml")),
          "has 6 joints, the connected device has 3");
  service.isUncalibrated = true;
  refuses(urlOf(service), "the Inverse3 049D is not calibrated");
  service.isUncalibrated = false;
  service.isPermuted = true;
  refuses(urlOf(service), "basis XZY");
  service.isPermuted = false;
  service.isTurned = true;
  refuses(urlOf(service), "turns or scales its positions (preset \"defaults\", mount or workspace)");
}

TEST_CASE("samples, forces and buttons have the axes of W", "[haply]") {
  HaplyService service(kFile, 0.02, 0.01);
  Bench bench(service);
  CHECK(bench.opened.text == readFile(kFile));
  CHECK(bench.opened.facts == "inverse3 049D, firmware 8C20, preset defaults");
  REQUIRE(bench.samplesAgain());
  CHECK(service.hasProfile);
  CHECK(bench.sample.buttons == 2);
  CHECK(bench.sample.q[2] > 0.005);  // the hand is 10 to 20 mm in front of the middle
  CHECK(bench.sample.q[2] < 0.025);
  CHECK(std::abs(bench.sample.q[0]) < 1e-3);
  CHECK(std::abs(bench.sample.q[1]) < 1e-3);
  bench.command.effort = Vec3(0.0, 0.5, 0.0);  // up
  REQUIRE(test::eventually([&] { return bench.tick() == Status::ok && bench.sample.q[1] > 1e-3; }));
  CHECK(service.force == Approx(0.5));  // the service's z is up
  bench.command.effort = Vec3(0.5, 0.0, 0.0);
  REQUIRE(test::eventually([&] { return bench.tick() == Status::ok && bench.sample.q[0] > 1e-3; }));
  // Rates are those of the motion: their integral is the way.
  bench.command.effort.setZero();
  double way = 0.0, moved = 0.0, time = 0.0, place = 0.0;
  for (int i = 0; i < 300; ++i) {
    if (bench.tick() != Status::ok) continue;
    const double elapsed = bench.sample.time - time;
    if (elapsed < 5e-3) {  // the machine did not pause
      way += bench.sample.rates[2] * elapsed;
      moved += bench.sample.q[2] - place;
    }
    time = bench.sample.time;
    place = bench.sample.q[2];
  }
  CHECK(std::abs(moved - way) < 2e-3);           // the low pass of 100 Hz and the clock's jitter
  bench.command.effort = Vec3(100.0, 0.0, 0.0);  // cut at the largest force
  (void)bench.tick();
  REQUIRE(bench.samplesAgain());
  CHECK(service.largestForce == Approx(6.0));
}

TEST_CASE("faults of the Haply service are missing samples or a lost device, and never wait", "[haply]") {
  HaplyService service(kFile, 0.02, 0.01);
  Bench bench(service);
  REQUIRE(bench.samplesAgain());

  SECTION("members in another order") {
    service.isShuffled = true;
    for (int i = 0; i < 20; ++i) (void)bench.tick();
    REQUIRE(bench.samplesAgain());
    CHECK(bench.sample.q[2] > 0.005);
    CHECK(bench.sample.q[2] < 0.025);
  }
  SECTION("a slow socket") {
    service.isSlow = true;
    for (int i = 0; i < 20; ++i) (void)bench.tick();
    REQUIRE(bench.samplesAgain());
    CHECK(bench.sample.q[2] > 0.005);
  }
  SECTION("a late answer") {
    service.lateOnce_ms = 2000;
    (void)bench.tick();
    int refused = 0;
    for (int i = 0; i < 20; ++i) {
      refused += bench.opened.device->actuate(bench.command) == Status::stale;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(bench.opened.device->measure(bench.sample) == Status::stale);
    CHECK(refused > 0);  // at most eight messages wait
    REQUIRE(bench.samplesAgain());
  }
  SECTION("the device is unplugged and plugged in again") {
    service.isUnplugged = true;
    (void)bench.tick();
    REQUIRE(test::eventually([&] { return bench.tick() == Status::stale; }));
    for (int i = 0; i < 10; ++i) CHECK(bench.tick() == Status::stale);
    service.isUnplugged = false;
    REQUIRE(bench.samplesAgain());
  }
  SECTION("garbage") {
    service.isGarbage = true;
    REQUIRE(test::eventually([&] { return bench.tick() == Status::stale; }));
    service.isGarbage = false;
    REQUIRE(bench.samplesAgain());
  }
  SECTION("the service ends") {
    service.isClosing = true;
    REQUIRE(test::eventually([&] { return bench.tick() == Status::inactive; }));
    CHECK(bench.opened.device->actuate(bench.command) == Status::inactive);
    REQUIRE(bench.samplesAgain());  // the host opens it again
  }
  SECTION("the device loses its calibration") {
    CHECK(bench.sample.conditions == 0);
    service.isUncalibrated = true;
    REQUIRE(bench.soon([&] { return bench.sample.conditions == kUncalibrated; }));
  }
  SECTION("the device loses its power supply") {
    service.hasNoPower = true;
    REQUIRE(bench.soon([&] { return bench.sample.conditions == kForcesCut && !bench.sample.enabled; }));
    service.hasNoPower = false;
    REQUIRE(bench.soon([&] { return bench.sample.conditions == 0 && bench.sample.enabled; }));
  }
}

TEST_CASE("a session feels a wall with the Haply driver, and stops when the device is unplugged in contact",
          "[haply]") {
  HaplyService service(kFile, 0.0, -0.004);
  test::checkUnpluggedInContact(
      urlOf(service), kFolder, 0.002, [&](bool on) { service.isUnplugged = on; },
      [&] { return service.newestForce().norm(); });
}

TEST_CASE("the command says that a device is lost, waits for it, and continues after Enter", "[haply]") {
  HaplyService service(kFile, 0.010, -0.010);
  const test::TemporaryFolder folder;
  const std::string input = folder / "input", log = folder / "log";
  REQUIRE(mkfifo(input.c_str(), 0600) == 0);
  const int keys = open(input.c_str(), O_RDWR);
  REQUIRE(keys >= 0);
  test::Process command("exec '" ENAMEL_TOOL "' device --connect '" + urlOf(service) +
                        "' --duration 3600 --max-force 2 > '" + log + "' 2>&1 < '" + input + "'");
  const auto says = [&](const char* text) { return test::readFile(log).find(text) != std::string::npos; };
  const auto presses = [&] { return write(keys, "\n", 1) == 1; };
  REQUIRE(test::eventually([&] { return presses() && service.force > 0.3; }));  // a late tick is a fault: Enter
  service.isClosing = true;
  REQUIRE(test::eventually([&] { return says("lost; waiting for it") && says("back; Enter continues"); }));
  CHECK(says("stopped by the guard: the driver failed; Enter continues"));
  for (int i = 0; i < 100; ++i) {
    CHECK(service.force == 0.0);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  REQUIRE(test::eventually([&] { return presses() && service.force > 0.3; }));
  command.signal(SIGTERM);
  (void)command.wait();
  INFO(test::readFile(log));
  CHECK(says("buttons pressed: 1"));
  close(keys);
}

}  // namespace enamel::test_haply
