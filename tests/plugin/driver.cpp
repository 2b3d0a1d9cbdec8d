// Drivers in plugins: the loader, connections, lists, and a conformance suite that finds every mistake.
#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <thread>

#include "enamel/plugin/driver_conformance.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/eventually.hpp"

namespace enamel::test_driver {

using test::ContainsSubstring;

namespace {

enum class Mistake {
  none,
  silentRefusal,  // no reason for an unknown address
  takesAny,       // accepts every address
  file,           // an invalid device file
  joints,         // not those of the device file
  delay,
  opensItself,  // measures before open
  never,        // gives no sample
  notFinite,
  unit,  // mm
  speed,
  clock,        // time stamps in ms
  frozenClock,  // the same time stamp again
  anyEffort,    // sends NaN
  anyJoints,
  staysOpen,  // measures after close
  allocates,
};

const char* const kDeviceFile =
    "kind = \"cartesian\"\nname = \"point\"\naxes = 3\nhalf_widths = [0.1, 0.1, 0.1]\nmax_force = 3.0\n"
    "position_step = 1e-5\n[platform]\nmass = 0.05\n";

// A point at rest, sampled once a command.
struct Point {
  bool isOpen = false, isNew = true;
  double last = 0.0;
};

// A device that is lost, and how often open() fails until it is back.
std::atomic<bool> isLost{false};
std::atomic<int> failuresLeft{0}, opened{0}, busy{0}, overlaps{0};
std::atomic<double> gripped{0.0};

// Counts calls that overlap with another one.
struct Call {
  Call() { overlaps += busy++ > 0 ? 1 : 0; }
  ~Call() { --busy; }
};

Mistake mistake = Mistake::none;
int connections = 0;
std::unique_ptr<int> litter;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::int32_t measure(void* user, EnamelMeasurement* m) {
  const Call call;
  if (isLost) return ENAMEL_INACTIVE;
  Point& point = *static_cast<Point*>(user);
  if (!point.isOpen && mistake != Mistake::opensItself && mistake != Mistake::staysOpen) return ENAMEL_INACTIVE;
  if (mistake == Mistake::never || !point.isNew) return ENAMEL_STALE;
  point.isNew = false;
  if (mistake == Mistake::allocates) litter = std::make_unique<int>(1);
  std::memset(m, 0, sizeof *m);
  m->size = sizeof *m;
  m->enabled = 1;
  m->time = point.last = mistake == Mistake::frozenClock && point.last > 0.0 ? point.last : now();
  if (mistake == Mistake::clock) m->time *= 1e3;
  m->q[0] = mistake == Mistake::unit ? 1.0 : 1e-3;
  m->q[1] = mistake == Mistake::notFinite ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  m->rates[2] = mistake == Mistake::speed ? 50.0 : 0.0;
  return ENAMEL_OK;
}

std::int32_t actuate(void* user, const double* effort, std::int32_t joints) {
  const Call call;
  Point& point = *static_cast<Point*>(user);
  if (!point.isOpen && mistake != Mistake::opensItself) return ENAMEL_INACTIVE;
  if (joints != 3 && mistake != Mistake::anyJoints) return ENAMEL_OUT_OF_RANGE;
  if (!(effort[0] - effort[0] == 0.0) && mistake != Mistake::anyEffort) return ENAMEL_NOT_FINITE;
  point.isNew = true;
  return ENAMEL_OK;
}

std::int32_t refuse(EnamelMessage message, const char* why) {
  if (mistake != Mistake::silentRefusal) std::strncpy(message.text, why, message.size);
  return ENAMEL_BAD_CONFIGURATION;
}

std::int32_t connect(const char* address, const EnamelParameter* options, std::size_t count, EnamelConnected* connected,
                     EnamelMessage message) {
  if (std::strcmp(address, "0") != 0 && mistake != Mistake::takesAny) return refuse(message, "there is only 0");
  if (count > 0 && std::strcmp(options[0].value, "red") != 0) return refuse(message, "colour must be red");
  ++connections;
  connected->joints = mistake == Mistake::joints ? 2 : 3;
  connected->device_file = mistake == Mistake::file ? "kind = 1" : kDeviceFile;
  connected->delay_low = 1;
  connected->delay_high = mistake == Mistake::delay ? 0 : 2;
  connected->has_own_clock = 1;
  connected->device = {sizeof(EnamelDevice),
                       0u,
                       new Point,
                       [](void* user, EnamelMessage why) {
                         const Call call;
                         if (failuresLeft > 0 && failuresLeft-- > 0) return refuse(why, "still unplugged");
                         static_cast<Point*>(user)->isOpen = true;
                         isLost = false;
                         ++opened;
                         return std::int32_t{ENAMEL_OK};
                       },
                       [](void* user) { static_cast<Point*>(user)->isOpen = mistake == Mistake::staysOpen; },
                       measure,
                       actuate,
                       [](void*, double force) {
                         gripped = force;
                         return std::int32_t{ENAMEL_OK};
                       }};
  return ENAMEL_OK;
}

const EnamelParameter kOptions[] = {{"colour", "red", "of the point"}};
const EnamelDescription kDescription = {"point", "1", "A point at rest", kOptions, 1};
bool isConnected = true;

EnamelDriver table() {
  return {ENAMEL_DRIVER_ABI_VERSION,
          sizeof(EnamelDriver),
          sizeof(EnamelConnected),
          sizeof(EnamelMeasurement),
          [] { return &kDescription; },
          [](EnamelMessage devices, EnamelMessage message) {
            if (!isConnected) return refuse(message, "the cable is out");
            std::strncpy(devices.text, "0\tfirst\n1?colour=red\tsecond\x01\n2\n", devices.size);
            return std::int32_t{ENAMEL_OK};
          },
          connect,
          [](EnamelConnected* connected) {
            --connections;
            delete static_cast<Point*>(connected->device.user);
          }};
}

// Return the checks that failed, with their reasons.
std::string failures(Mistake made) {
  static const EnamelDriver kTable = table();
  mistake = made;
  std::string failed;
  DriverConformanceOptions options;
  options.address = "0";
  options.duration = 0.05;
  options.allocationCount = [] { return litter ? long{*std::exchange(litter, nullptr)} : 0L; };
  const bool isKept = checkDriver(DriverLibrary::of(kTable, "point"), options, [&](const ConformanceResult& result) {
    if (result.verdict == ConformanceResult::Verdict::failed) failed += result.what + ": " + result.detail + "\n";
  });
  CHECK(isKept == failed.empty());
  mistake = Mistake::none;
  CHECK(connections == 0);
  return failed;
}

}  // namespace

TEST_CASE("a driver's table is checked", "[driver]") {
  const auto refuses = [](const EnamelDriver& bad, const std::string& message) {
    CHECK_THROWS_WITH(DriverLibrary::of(bad, "bad"), ContainsSubstring("bad: ") && ContainsSubstring(message));
  };
  EnamelDriver bad = table();
  bad.abi_version = 99;
  refuses(bad, "has ABI version 99, this host loads 1 to 1");
  bad = table();
  bad.driver_size = 1;
  refuses(bad, "its EnamelDriver has 1 bytes");
  bad = table();
  bad.connected_size = 1;
  refuses(bad, "its EnamelConnected has 1 bytes");
  bad = table();
  bad.measurement_size = 1;
  refuses(bad, "its EnamelMeasurement has 1 bytes");
  bad = table();
  bad.list = nullptr;
  refuses(bad, "a function of its table is missing");
  bad = table();
  bad.describe = [] {
    static const EnamelDescription kUpper = {"Point", "1", "A point", nullptr, 0};
    return &kUpper;
  };
  refuses(bad, "its name \"Point\" cannot be a scheme");
}

TEST_CASE("files of the other kind are refused with the reason, and drivers are found by name", "[driver]") {
  const std::string folder = ENAMEL_PLUGINS;
  CHECK_THROWS_WITH(DriverLibrary::load(folder + "/enamel_template.so"),
                    ContainsSubstring("does not export enamel_driver(): it is a renderer, not a driver"));
  CHECK_THROWS_WITH(PluginLibrary::load(folder + "/enamel_driver_template.so"),
                    ContainsSubstring("does not export enamel_plugin(): it is a driver, not a renderer"));
  CHECK(isDriver(folder + "/enamel_driver_template.so"));
  CHECK_FALSE(isDriver(folder + "/enamel_template.so"));
  CHECK(findDriver("driver-template", folder)->path() == folder + "/enamel_driver_template.so");
  CHECK_THROWS_WITH(findDriver("mouse", folder),
                    ContainsSubstring("unknown driver \"mouse\"") && ContainsSubstring("driver-template"));
  CHECK_THROWS_WITH(findDriver("mouse", "/nowhere"), ContainsSubstring("/nowhere has no drivers"));
}

TEST_CASE("a device is connected with its file, delay and options, and disconnected at its end", "[driver]") {
  const EnamelDriver plain = table();
  const auto library = DriverLibrary::of(plain, "point");
  {
    const DriverDevice connected = connectDriver(library, "0", {{"colour", "red"}});
    CHECK(connections == 1);
    CHECK(connected.text == kDeviceFile);
    CHECK(connected.mechanism->name() == "point");
    CHECK(connected.delayLow == 1);
    CHECK(connected.delayHigh == 2);
    CHECK(connected.hasOwnClock);
    Measurement sample;
    CHECK(connected.device->measure(sample) == Status::inactive);
    connected.device->open();
    REQUIRE(connected.device->measure(sample) == Status::ok);
    CHECK(sample.q == JointVector(Vec3(1e-3, 0.0, 0.0)));
    CHECK(connected.device->measure(sample) == Status::stale);
    CHECK(connected.device->actuate({JointVector::Zero(3)}) == Status::ok);
    connected.device->close();
    CHECK(connected.device->measure(sample) == Status::inactive);
  }
  CHECK(connections == 0);
  CHECK_THROWS_WITH(connectDriver(library, "7", {}), ContainsSubstring("point: there is only 0"));
  CHECK_THROWS_WITH(connectDriver(library, "0", {{"colour", "blue"}}), ContainsSubstring("colour must be red"));
  CHECK_THROWS_WITH(connectDriver(library, "0", {{"size", "1"}}),
                    ContainsSubstring("unknown option \"size\", possible are colour"));
  for (const auto& [made, message] : {std::pair<Mistake, const char*>{Mistake::file, "kind"},
                                      {Mistake::joints, "has 3 joints, connect() gave 2"},
                                      {Mistake::delay, "the delay of the driver is 1 to 0 ticks"}}) {
    mistake = made;
    CHECK_THROWS_WITH(connectDriver(library, "0", {}), ContainsSubstring(message));
    mistake = Mistake::none;
    CHECK(connections == 0);
  }
}

TEST_CASE("a lost device of a driver is opened again in the background, and the tick does not call it meanwhile",
          "[driver]") {
  const EnamelDriver plain = table();
  const DriverDevice connected = connectDriver(DriverLibrary::of(plain, "point"), "0", {});
  HapticDevice& device = *connected.device;
  Measurement sample;
  CHECK(device.actuate({JointVector::Zero(3), 1.5}) == Status::inactive);
  CHECK(gripped == 1.5);  // N
  opened = overlaps = 0;
  device.open();
  REQUIRE(device.measure(sample) == Status::ok);
  const double before = sample.time;
  failuresLeft = 2;
  isLost = true;
  CHECK(device.measure(sample) == Status::inactive);
  int refused = 0;
  REQUIRE(test::eventually([&] {
    refused += device.actuate({JointVector::Zero(3)}) == Status::inactive ? 1 : 0;
    return device.measure(sample) == Status::ok;
  }));
  CHECK(refused > 0);
  CHECK(sample.time > before);
  CHECK(failuresLeft == 0);
  CHECK(opened == 2);
  CHECK(overlaps == 0);
  device.close();
  CHECK(device.measure(sample) == Status::inactive);
  device.close();  // does nothing
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(opened == 2);  // a closed device stays closed
  // It ends while it is lost.
  device.open();
  isLost = true;
  failuresLeft = 1000;
  CHECK(device.measure(sample) == Status::inactive);
  device.close();
  failuresLeft = 0;
  isLost = false;
}

TEST_CASE("a driver lists its devices, or gives its reason", "[driver]") {
  const EnamelDriver plain = table();
  const auto library = DriverLibrary::of(plain, "point");
  const std::vector<DriverListing> rows = listDriver(*library);
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].address == "0");
  CHECK(rows[0].text == "first");
  CHECK(rows[1].address == "1?colour=red");
  CHECK_THAT(rows[1].text, ContainsSubstring("second\\x01"));
  CHECK(rows[2].address == "2");
  CHECK(rows[2].text.empty());
  isConnected = false;
  CHECK_THROWS_WITH(listDriver(*library), ContainsSubstring("the cable is out"));
  isConnected = true;
}

TEST_CASE("the conformance suite finds every mistake", "[driver]") {
  CHECK(failures(Mistake::none).empty());
  for (const auto& [made, message] :
       {std::pair<Mistake, const char*>{Mistake::silentRefusal, "connect() gave no reason"},
        {Mistake::takesAny, "was accepted"},
        {Mistake::file, "has a valid device file"},
        {Mistake::joints, "the device file has 3 joints, connect() gave 2"},
        {Mistake::opensItself, "measure() before open() did not return inactive"},
        {Mistake::never, "no sample within 1 s after open()"},
        {Mistake::notFinite, "is not finite"},
        {Mistake::unit, "units and origin?"},
        {Mistake::speed, "a rate is 50; are the units SI?"},
        {Mistake::clock, "the time stamps advanced by"},
        {Mistake::frozenClock, "the one before has"},
        {Mistake::anyEffort, "actuate() of nan was accepted"},
        {Mistake::anyJoints, "actuate() of 0 joints was accepted"},
        {Mistake::staysOpen, "measure()"},
        {Mistake::allocates, "allocations or releases"}})
    CHECK_THAT(failures(made), ContainsSubstring(message));
}

TEST_CASE("the template keeps the contract, and a loop feels a wall with it", "[driver]") {
  const auto check = test::run("check-driver driver-template");
  INFO(check.output);
  CHECK(check.status == 0);
  CHECK_THAT(check.output,
             ContainsSubstring("the plugin keeps the contract") && ContainsSubstring("passed       allocates nothing"));
  CHECK_THAT(test::run("check-driver driver-template '0?push=9'").output,
             ContainsSubstring("push must be in 0 to 2 N"));
  CHECK_THAT(test::run("check-driver '" ENAMEL_PLUGINS "/enamel_template.so'").output,
             ContainsSubstring("it is a renderer"));
  CHECK_THAT(test::run("devices").output, ContainsSubstring("connected: driver-template://0  simulated stylus"));
  CHECK_THAT(test::run("plugins").output, ContainsSubstring("driver-template 0.2.0 (driver)"));
  test::CommandResult result;
  for (const char* seconds : {"1", "4", "16"}) {  // on a busy machine ticks are late
    result = test::run(std::string("device --connect driver-template://0?push=0.5 --duration ") + seconds);
    if (result.status == 0) break;
  }
  INFO(result.output);
  CHECK((result.status == 0 || result.output.find("stopped by the guard: ") != std::string::npos));
  CHECK_THAT(result.output, !ContainsSubstring("ticks in contact 0,"));
}

}  // namespace enamel::test_driver
