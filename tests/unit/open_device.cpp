// Devices by URL: the parts of a URL, messages, and the same device for openDevice(), a session and C.
#include "enamel/session/open_device.hpp"

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/runtime/udp_device.hpp"
#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/eventually.hpp"

namespace enamel::test_open_device {

using test::ContainsSubstring;

namespace {

const std::string kStylus = test::deviceFile("cartesian-3.toml");

// Serves a virtual stylus, as enamel device --serve does.
struct Served {
  OpenedDevice opened = openDevice("virtual:" + kStylus);
  std::unique_ptr<DeviceServer> server;

  explicit Served(const std::optional<LinkKey>& key = {}) {
    ServeOptions options;
    options.port = 0;
    options.link.key = key;
    server = std::make_unique<DeviceServer>(*opened.device, *opened.mechanism, options);
  }
  std::string url(const std::string& options) const {
    return "udp://127.0.0.1:" + std::to_string(server->port()) + "?device=" + kStylus + options;
  }
};

}  // namespace

TEST_CASE("a URL has a scheme, an address and options", "[open_device]") {
  const DeviceUrl url = parseDeviceUrl("udp://[host]:7?device=a b.toml&key=c=d");
  CHECK(url.scheme == "udp");
  CHECK(url.address == "[host]:7");
  CHECK(url.options == std::map<std::string, std::string>{{"device", "a b.toml"}, {"key", "c=d"}});
  CHECK(parseDeviceUrl("virtual:").address.empty());
  CHECK(parseDeviceUrl("virtual:C:/a.toml").address == "C:/a.toml");
  CHECK(parseDeviceUrl("virtual:?a=").options.at("a").empty());
  CHECK(parseDeviceUrl("openhaptics://Default Device").address == "Default Device");
  for (const char* file : {"a.toml", "C:/a.toml", "./virtual:a", "", ":", "Virtual:a", "a b:c"}) {
    INFO(file);
    CHECK_FALSE(isDeviceUrl(file));
  }
  CHECK(isDeviceUrl("virtual:"));
}

TEST_CASE("a refusal names the URL, the cause and what is possible", "[open_device]") {
  const auto refuses = [](const std::string& url, const std::string& message) {
    CHECK_THROWS_WITH(openDevice(url), ContainsSubstring('"' + url + '"') && ContainsSubstring(message));
  };
  refuses("tau.toml",
          "it must begin with a scheme in small letters and ':'; possible are virtual:FILE, udp://HOST:PORT");
  refuses(
      "mouse://0",
      "unknown driver \"mouse\": no plugin folder is given; a path must end in .so; possible are virtual:FILE, udp://");
  refuses("virtual:?seed=1", "unknown option \"seed\", virtual has no options");
  refuses("udp://localhost?devise=a", "unknown option \"devise\", possible are delay, device, key");
  refuses("udp://localhost?device", "option \"device\" must be KEY=VALUE");
  refuses("udp://localhost?=a", "option \"=a\" must be KEY=VALUE");
  refuses("udp://localhost?key=a&key=b", "option \"key\" is given twice");
  refuses("udp://localhost:0", "a port in 1 to 65535");
  refuses("udp://localhost:99999", "a port in 1 to 65535");
  refuses("udp://192.0.2.1", "give a key");
  refuses("virtual:/nowhere.toml", "/nowhere.toml");
  refuses("udp://127.0.0.1?key=/nowhere", "/nowhere");
  const Served keyed(LinkKey{1});
  refuses(keyed.url(""), "no measurement within 1 s");
}

TEST_CASE("a virtual device has the file's mechanism and encoders, begins at home and moves in real time",
          "[open_device]") {
  OpenedDevice opened = openDevice("virtual:" + kStylus);
  CHECK(opened.text == readFile(kStylus));
  CHECK(opened.mechanism->joints() == 3);
  CHECK(opened.poll == 0.0);
  CHECK(opened.delay.high == 0);
  Measurement first, later;
  REQUIRE(opened.device->measure(first) == Status::ok);
  CHECK(first.q.isZero(0.0));
  const Command none{JointVector::Zero(3)};
  REQUIRE(test::eventually([&] {
    return opened.device->actuate(none) == Status::ok && opened.device->measure(later) == Status::ok &&
           later.q[2] < -1e-3;  // the hand pushes it
  }));
  const double step = opened.mechanism->limits().encoderStep[2];
  CHECK(std::abs(later.q[2] / step - std::round(later.q[2] / step)) < 1e-9);  // whole counts, to rounding
  CHECK(openDevice("virtual:").mechanism->joints() == 6);

  OpenDeviceOptions options;
  options.start.emplace().position = {0.0, 0.0, 5.5e-3};
  REQUIRE(openDevice("virtual:" + kStylus, options).device->measure(first) == Status::ok);
  CHECK(first.q[2] == Approx(5.5e-3));
}

TEST_CASE("a served device is opened by URL", "[open_device]") {
  const Served served;
  OpenedDevice opened = openDevice(served.url(""));
  CHECK(opened.poll == 2.5e-4);
  CHECK(opened.delay.low == 1);
  CHECK(opened.delay.high == 2);
  CHECK(opened.file == kStylus);
  const Command none{JointVector::Zero(3)};
  CHECK(test::eventually([&] { return opened.device->actuate(none) == Status::ok; }));
}

TEST_CASE("the delay of a URL replaces that of the driver", "[open_device]") {
  const Served served;
  for (const auto& [text, low, high] : {std::tuple{"3", 3, 3}, {"0..2", 0, 2}}) {
    const OpenedDevice opened = openDevice(served.url(std::string("&delay=") + text));
    CHECK(opened.delay.low == low);
    CHECK(opened.delay.high == high);
  }
  for (const char* text : {"x", "-1", "2..1", "1..", "..1", "1.5", "64", ""})
    CHECK_THROWS_WITH(openDevice(served.url(std::string("&delay=") + text)),
                      ContainsSubstring(std::string("delay is \"") + text + "\", must be N or LOW..HIGH in 0 to 63"));
}

TEST_CASE("a session runs the device of its URL, again after stop()", "[open_device]") {
  const test::TemporaryFolder folder;
  SessionDef def;
  def.device = "virtual:" + kStylus;
  def.start.emplace().position.z() = 2e-3;
  Session session(def);
  CHECK(session.opened().file == kStylus);
  (void)session.add({flatWall().obstacles()[0]});
  session.record(folder / "a.rec");
  for (int i = 0; i < 2; ++i) {
    session.startOpened();
    CHECK_THROWS_WITH(session.startOpened(), ContainsSubstring("already running"));
    // The hand pushes it from 2 mm in front of the wall onto it.
    REQUIRE(test::eventually([&] { return session.snapshot().tick.mode == RenderMode::contact; }));
    const GuardReason fault = session.snapshot().fault;
    CHECK((fault == GuardReason::none || fault == GuardReason::late));  // late: this machine is busy
    session.stop();
    if (i == 0) CHECK(session.stopRecording().problem.empty());
  }

  def.device = kStylus;
  Session ofFile(def);
  CHECK_THROWS_WITH(ofFile.startOpened(), ContainsSubstring("needs a URL as SessionDef::device"));
  def.device = "mouse://0";
  CHECK_THROWS_WITH(Session(def), ContainsSubstring("unknown driver \"mouse\""));
}

TEST_CASE("position control of a session knows the delay of the URL's device", "[open_device]") {
  const Served served;
  SessionDef def;
  def.device = served.url("");
  Session session(def);
  (void)session.add({flatWall().obstacles()[0]});
  const test::TemporaryFolder folder;
  const auto header = [&](const std::string& name) {
    session.record(folder / name);
    (void)session.stopRecording();
    return readFile(folder / name);
  };
  CHECK_THAT(header("a.rec"), ContainsSubstring("\"delay-high\": \"2\""));
  session.setRenderer("position-control", {{"delay", "0"}});
  CHECK_THAT(header("b.rec"), !ContainsSubstring("delay-high"));
  session.startOpened();
  REQUIRE(test::eventually([&] { return session.snapshot().tick.number > 50; }));
  session.stop();
}

}  // namespace enamel::test_open_device
