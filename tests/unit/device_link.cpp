// The datagrams and the two ends of a device link.
#include "enamel/runtime/device_link.hpp"

#include "enamel/sim/virtual_loop.hpp"
#include "support/catch.hpp"
#include "support/device_wire.hpp"
#include "support/run_length.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_device_link {

using test::Wire;
using test::WiredDevice;
using test::WireFaults;

namespace {

const CartesianMechanism& stylus() {
  static const CartesianMechanism mechanism(loadCartesian(test::deviceFile("cartesian-3.toml")));
  return mechanism;
}

const LinkKey kKey = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

std::uint64_t droppedBy(const LinkCounts& counts, DropReason reason) {
  return counts.dropped[static_cast<std::size_t>(reason)];
}

std::uint64_t dropped(const LinkCounts& counts) {
  std::uint64_t sum = 0;
  for (const auto& n : counts.dropped) sum += n;
  return sum;
}

// A haptic loop on a device behind a wire, in simulated time.
struct Rig {
  explicit Rig(std::optional<LinkKey> key = {})
      : plant(stylus(), test::swingStart(), test::swingingHand()),
        device(stylus(), plant, key),
        scene(flatWall()),
        wall({400.0, 0.0}),
        haptics(stylus(), scene, Tool(), wall, 1e-3),
        body(device, haptics, {}) {}

  void tick() {
    device.serve();
    body.step();
    device.pass();
    const double most = device.motors.effort.cwiseAbs().maxCoeff();
    within = within && most <= stylus().limits().effort[0] &&
             body.tick().command.effort.cwiseAbs().maxCoeff() <= stylus().limits().effort[0];
    largest = std::max(largest, most);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(1e3 * seconds + 0.5); ++i) tick();
  }

  SimulatedDevice plant;
  WiredDevice device;
  Scene scene;
  ImpedanceRenderer wall;
  HapticTick haptics;
  LoopBody body;
  bool within = true;
  double largest = 0.0;  // N
};

// The last datagrams of both ends, to be changed.
struct Pair {
  explicit Pair(std::optional<LinkKey> key = {}) : client(options(key), 5), server(options(key), stylus(), 6) {
    const std::size_t size = client.call(now, called);
    REQUIRE(server.receive(called.data(), size, now));
    m.q = m.rates = JointVector::Constant(3, 0.001);
    measure();
    client.receive(measurement.data(), kMeasurementBytes, now);
    command();
    REQUIRE(client.counts().accepted == 1);
  }
  static LinkOptions options(std::optional<LinkKey> key) {
    LinkOptions o;
    o.joints = 3;
    o.key = key;
    return o;
  }
  void measure() { REQUIRE(server.measurement(m, now, measurement) == kMeasurementBytes); }
  void command() { REQUIRE(client.command(JointVector::Constant(3, 1.0), now, torque) == kCommandBytes); }
  // Return the server's reaction to a changed command.
  bool takes(Datagram d, std::size_t size = kCommandBytes) { return server.receive(d.data(), size, now); }

  LinkClient client;
  LinkServer server;
  std::int64_t now = 1'000'000'000;
  Measurement m;
  Datagram called{}, measurement{}, torque{};
};

void putDouble(Datagram& d, std::size_t at, double value) { std::memcpy(&d[at], &value, 8); }

}  // namespace

TEST_CASE("SipHash-2-4 is that of its authors", "[device_link]") {
  // Aumasson and Bernstein 2012, appendix A: key 00 01 .. 0f, message 00 01 .. 0e.
  std::string message;
  for (char c = 0; c < 15; ++c) message.push_back(c);
  CHECK(sipHash(kKey, message) == 0xa129ca6149be45e5u);
}

TEST_CASE("a key is 32 hexadecimal digits", "[device_link]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "key";
  test::writeFile(path, "000102030405060708090a0b0c0d0e0f\n");
  CHECK(readKey(path) == kKey);
  for (const char* text : {"", "0001", "000102030405060708090a0b0c0d0e0g", "000102030405060708090a0b0c0d0e0f00"}) {
    test::writeFile(path, text);
    CHECK_THROWS_AS(readKey(path), ConfigurationError);
  }
}

TEST_CASE("what crosses the wire is what was sent", "[device_link]") {
  Pair p;
  Measurement got;
  p.m.time = 0.25;
  p.m.q = Vec3(1e-3, -2e-3, 0.01 / 3.0);
  p.m.rates = Vec3(0.1, -0.2, 0.3);
  p.m.applied = Vec3(1.0, 2.0, -3.0);
  CHECK(p.takes(p.torque));
  p.measure();
  p.client.receive(p.measurement.data(), kMeasurementBytes, p.now);
  REQUIRE(p.client.measure(got, p.now) == Status::ok);
  CHECK(got.time == 0.25);
  CHECK(got.q == p.m.q);
  CHECK(got.rates == p.m.rates);
  CHECK(got.applied == p.m.applied);
  CHECK_FALSE(got.enabled);  // the server's part of the command still ramps in
  CHECK(p.client.measure(got, p.now) == Status::stale);
  for (int i = 0; i < 99; ++i) (void)p.server.torque(p.m.q, 1e-3, p.now);
  CHECK(p.server.watchdog());
  for (int i = 0; i < 2; ++i) CHECK(p.server.torque(p.m.q, 1e-3, p.now).cwiseAbs().maxCoeff() <= 1.0);
  CHECK(p.server.torque(p.m.q, 1e-3, p.now) == JointVector::Constant(3, 1.0));
  CHECK_FALSE(p.server.watchdog());
}

TEST_CASE("every reason to drop a datagram is found and counted", "[device_link]") {
  const auto changed = [](const Datagram& d, const std::function<void(Datagram&)>& change) {
    Datagram copy = d;
    change(copy);
    test::reseal(copy.data(), kCommandBytes);
    return copy;
  };
  Pair p;
  const auto refuses = [&p](DropReason reason, const Datagram& d, std::size_t size = kCommandBytes) {
    const std::uint64_t before = droppedBy(p.server.counts(), reason), all = dropped(p.server.counts());
    INFO(toString(reason));
    CHECK_FALSE(p.takes(d, size));
    CHECK(droppedBy(p.server.counts(), reason) == before + 1);
    CHECK(dropped(p.server.counts()) == all + 1);
  };
  refuses(DropReason::length, p.torque, 0);
  refuses(DropReason::length, p.torque, kCommandBytes - 1);
  refuses(DropReason::length, p.measurement, kMeasurementBytes);
  refuses(DropReason::magic, changed(p.torque, [](Datagram& d) { d[0] ^= 1; }));
  refuses(DropReason::version, changed(p.torque, [](Datagram& d) { d[4] = 2; }));
  Datagram bad = p.torque;
  bad[60] ^= 1;
  refuses(DropReason::checksum, bad);
  refuses(DropReason::tag, changed(p.torque, [](Datagram& d) { d[112] ^= 1; }));
  refuses(DropReason::kind, changed(p.torque, [](Datagram& d) { d[5] = 1; }));
  refuses(DropReason::kind, changed(p.torque, [](Datagram& d) { d[6] = 6; }));
  refuses(DropReason::session, changed(p.torque, [](Datagram& d) { d[8] ^= 1; }));
  refuses(DropReason::session, changed(p.torque, [](Datagram& d) { d[16] ^= 1; }));
  refuses(DropReason::session, changed(p.torque, [](Datagram& d) { d[5] = 3, d[8] ^= 1; }));  // another client calls
  refuses(DropReason::notFinite, changed(p.torque, [](Datagram& d) { putDouble(d, 56, std::nan("")); }));
  refuses(DropReason::notFinite, changed(p.torque, [](Datagram& d) { putDouble(d, 72, INFINITY); }));
  refuses(DropReason::limits, changed(p.torque, [](Datagram& d) { putDouble(d, 64, 3.4); }));
  refuses(DropReason::limits, changed(p.torque, [](Datagram& d) { putDouble(d, 64, -1e300); }));
  CHECK(p.takes(p.torque));
  refuses(DropReason::duplicate, p.torque);
  Datagram older = p.torque;
  p.command();
  CHECK(p.takes(p.torque));
  refuses(DropReason::old, older);
  p.now += 11'000'000;
  p.command();
  CHECK(p.takes(p.torque));  // it belongs to the session, but is too old
  CHECK(droppedBy(p.server.counts(), DropReason::stale) == 1);
  CHECK(p.server.torque(p.m.q, 1e-3, p.now).isZero(0.0));

  Pair keyed{kKey}, other;
  const Datagram open = other.torque;
  CHECK(keyed.takes(keyed.torque));
  CHECK_FALSE(keyed.takes(open));
  CHECK(droppedBy(keyed.server.counts(), DropReason::tag) == 1);
  CHECK_FALSE(p.takes(keyed.torque));  // also in the opposite case

  // The client's side.
  Pair q;
  const auto ignored = [&q](DropReason reason, const std::function<void(Datagram&)>& change) {
    Datagram d = q.measurement;
    change(d);
    test::reseal(d.data(), kMeasurementBytes);
    const std::uint64_t before = droppedBy(q.client.counts(), reason);
    q.client.receive(d.data(), kMeasurementBytes, q.now);
    INFO(toString(reason));
    CHECK(droppedBy(q.client.counts(), reason) == before + 1);
  };
  q.measure();
  ignored(DropReason::notFinite, [](Datagram& d) { putDouble(d, 56, std::nan("")); });
  ignored(DropReason::notFinite, [](Datagram& d) { putDouble(d, 128, -INFINITY); });
  ignored(DropReason::session, [](Datagram& d) { d[8] ^= 1; });
  ignored(DropReason::session, [](Datagram& d) { d[16] ^= 1; });
  ignored(DropReason::kind, [](Datagram& d) { d[5] = 2; });
  q.client.receive(q.measurement.data(), kMeasurementBytes, q.now);
  CHECK(q.client.counts().accepted == 2);
  ignored(DropReason::duplicate, [](Datagram&) {});
}

TEST_CASE("a forged stamp of long ago is a long time ago", "[device_link]") {
  const auto forged = [](Datagram d, std::size_t size) {
    std::memset(&d[48], 0, 7);
    d[55] = 0x80;  // -2^63 ns
    test::reseal(d.data(), size);
    return d;
  };
  Pair p;
  CHECK(p.takes(forged(p.torque, kCommandBytes)));
  CHECK(p.server.counts().roundTrip.largest() > 9e9);
  CHECK(droppedBy(p.server.counts(), DropReason::stale) == 1);
  p.measure();
  p.client.receive(forged(p.measurement, kMeasurementBytes).data(), kMeasurementBytes, p.now);
  CHECK(p.client.counts().roundTrip.largest() > 9e9);
  Measurement m;
  CHECK(p.client.measure(m, p.now) == Status::stale);
  // A measurement time in the future is not fresh either.
  Pair q;
  Datagram ahead = q.torque;
  ahead[54] = 1;
  test::reseal(ahead.data(), kCommandBytes);
  CHECK(q.takes(ahead));
  CHECK(droppedBy(q.server.counts(), DropReason::stale) == 1);
}

TEST_CASE("recorded datagrams of an earlier session do nothing", "[device_link]") {
  Pair p{kKey};
  CHECK(p.takes(p.torque));
  p.now += kSessionTimeout + 1;
  Measurement m;
  CHECK(p.client.measure(m, p.now) == Status::stale);
  Datagram call{};
  REQUIRE(p.client.call(p.now, call) == kCommandBytes);
  CHECK(p.server.receive(call.data(), kCommandBytes, p.now));
  CHECK_FALSE(p.takes(p.torque));
  CHECK(droppedBy(p.server.counts(), DropReason::session) == 1);
  p.client.receive(p.measurement.data(), kMeasurementBytes, p.now);
  CHECK(droppedBy(p.client.counts(), DropReason::session) == 1);
  CHECK(p.server.torque(p.m.q, 1e-3, p.now).isZero(0.0));
  // A call opens a session after another one is over. The commands after the old call have another session number.
  p.now += kSessionTimeout + 1;
  CHECK(p.server.receive(p.called.data(), kCommandBytes, p.now));
  CHECK_FALSE(p.takes(p.torque));
  CHECK(p.server.torque(p.m.q, 1e-3, p.now).isZero(0.0));
}

TEST_CASE("a wire without faults: a wall is felt, nothing is dropped", "[device_link]") {
  Rig rig;
  rig.run(3.0);
  CHECK(rig.within);
  CHECK(rig.largest > 0.5);
  CHECK(rig.body.tick().reason == GuardReason::none);
  CHECK(dropped(rig.device.client.counts()) == 0);
  CHECK(dropped(rig.device.server.counts()) == 0);
  CHECK(rig.body.held() == 0);
}

TEST_CASE("whatever the wire does, commands stay within the limits", "[device_link]") {
  struct Case {
    const char* name;
    WireFaults faults;
    bool faultExpected, silent, keyed = true;
  };
  const std::vector<Case> cases = {
      {"1 % lost", {0.01, 0, 0, 0, 0}, false, false},
      {"5 % lost", {0.05, 0, 0, 0, 0}, false, false},  // bridged
      {"50 % lost", {0.5, 0, 0, 0, 0}, true, false},
      {"doubled", {0, 0.5, 0, 0, 0}, false, false},
      {"reordered", {0, 0, 0.3, 0, 0}, true, false},
      {"forged", {0, 0, 0, 0.5, 0}, false, false},
      {"forged, without a key", {0, 0, 0, 0.5, 0}, false, false, false},
      {"5 ms", {0, 0, 0, 0, 0.005}, true, true},
      {"50 ms", {0, 0, 0, 0, 0.05}, true, true},
      {"500 ms", {0, 0, 0, 0, 0.5}, true, true},
      {"all at once", {0.2, 0.2, 0.2, 0.5, 0.002}, true, false},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    Rig rig(c.keyed ? std::optional<LinkKey>(kKey) : std::nullopt);
    rig.run(1.3);  // inside the wall
    REQUIRE(rig.body.tick().reason == GuardReason::none);
    REQUIRE(rig.device.motors.effort.norm() > 0.1);
    rig.device.up.faults = rig.device.down.faults = c.faults;
    double silentAfter = 0.0;  // s, until the motors give no torque
    for (int i = 0; i < 2000; ++i) {
      rig.tick();
      if (rig.device.motors.effort.norm() > 0.0) silentAfter = 1e-3 * (i + 1);
    }
    CHECK(rig.within);
    const GuardReason fault = rig.haptics.guard().fault();
    INFO(toString(fault) << ", motors end after " << silentAfter << " s");
    if (c.keyed) CHECK((fault != GuardReason::none) == c.faultExpected);  // without a key, forgeries are accepted
    // 10 ms of silence, 20 ms of ramp, one tick of each end.
    if (c.silent) CHECK(silentAfter <= 0.0335);
    if (fault != GuardReason::none) CHECK(rig.device.motors.effort.isZero(0.0));
  }
}

TEST_CASE("an unplugged device, and one whose commands alone are lost", "[device_link]") {
  Rig rig;
  rig.run(1.3);
  rig.device.plugged = false;
  int until = 0;
  for (int i = 0; i < 200; ++i) {
    rig.tick();
    if (rig.body.tick().command.effort.norm() > 0.0) until = i + 1;
  }
  CHECK(rig.body.tick().reason == GuardReason::late);
  CHECK(until <= 4 + 20 + 2);  // the longest gap, then the ramp
  // After reconnection the fault remains until it is reset; then the wall is back.
  rig.device.plugged = true;
  rig.run(0.5);
  CHECK(rig.body.tick().reason == GuardReason::late);
  CHECK(rig.body.tick().device == Status::ok);
  rig.body.reset();
  rig.run(2.0);
  CHECK(rig.body.tick().reason == GuardReason::none);

  Rig deaf;
  deaf.run(1.3);
  deaf.device.up.faults.loss = 1.0;
  int motors = 0;
  for (int i = 0; i < 200; ++i) {
    deaf.tick();
    if (deaf.device.motors.effort.norm() > 0.0) motors = i + 1;
  }
  CHECK(motors <= 10 + 20 + 2);
  CHECK(isFault(deaf.body.tick().reason));
}

TEST_CASE("mutated datagrams never make a command beyond the limits", "[device_link]") {
  Pair p;
  test::Random random(9);
  const auto any = [&random](int n) { return static_cast<int>(random.uniform(0, n)) % n; };
  const double most = stylus().limits().effort[0];
  bool within = true;
  int commands = 0;
  const int rounds = test::count(10000, 100000);
  for (int i = 0; i < rounds; ++i) {
    p.now += 1'000'000;
    Measurement got;
    (void)p.client.measure(got, p.now);
    // A forged number ends a session after a while of silence; then a new one begins.
    Datagram call{};
    if (const std::size_t size = p.client.call(p.now, call); size > 0) (void)p.server.receive(call.data(), size, p.now);
    if (p.server.measurement(p.m, p.now, p.measurement) > 0)
      p.client.receive(p.measurement.data(), kMeasurementBytes, p.now);
    if (p.client.command(JointVector::Constant(3, 1.0), p.now, p.torque) > 0) ++commands;
    for (const bool up : {true, false}) {
      Datagram d = up ? p.torque : p.measurement;
      std::size_t size = up ? kCommandBytes : kMeasurementBytes;
      for (int n = 1 + any(4); n > 0; --n)
        d[static_cast<std::size_t>(any(static_cast<int>(size)))] = static_cast<unsigned char>(any(256));
      if (any(8) == 0) {
        std::memset(&d[56], any(2) ? 0xff : 0x7f, 56);
      } else if (any(8) == 0) {
        size = static_cast<std::size_t>(any(static_cast<int>(d.size()) + 1));
      }
      if (any(4) != 0 && size >= 4) test::reseal(d.data(), size);
      if (up)
        (void)p.server.receive(d.data(), size, p.now);
      else
        p.client.receive(d.data(), size, p.now);
    }
    (void)p.takes(p.torque);
    const JointVector torque = p.server.torque(p.m.q, 1e-3, p.now);
    within = within && torque.allFinite() && torque.cwiseAbs().maxCoeff() <= most;
  }
  CHECK(within);
  CHECK(commands > rounds / 20);
  CHECK(p.server.counts().accepted > static_cast<std::uint64_t>(rounds) / 50);
  CHECK(dropped(p.server.counts()) > static_cast<std::uint64_t>(rounds) / 2);
}

TEST_CASE("a push through the wire and in the process agree to the delay of a tick", "[device_link]") {
  Rig wired;
  ImpedanceRenderer wall({400.0, 0.0});
  LoopSetup setup;
  static_cast<VirtualDeviceSetup&>(setup) = test::swingStart();
  setup.delay = {1, 1};
  VirtualLoop loop(stylus(), wall, setup);
  setup.delay = {0, 0};
  ImpedanceRenderer atOnce({400.0, 0.0});
  VirtualLoop without(stylus(), atOnce, setup);
  TickRecord record, other;
  // The plant moved while the link was opened.
  const auto load = test::swingingHand();
  const auto moved = static_cast<std::uint64_t>(wired.plant.device().tick());
  for (std::uint64_t i = 0; i < moved; ++i)
    REQUIRE((loop.tick(load, record) == Status::ok && without.tick(load, other) == Status::ok));
  double apart = 0.0, ofDelay = 0.0;
  for (int i = 0; i < 3000; ++i) {
    REQUIRE((loop.tick(load, record) == Status::ok && without.tick(load, other) == Status::ok));
    wired.tick();
    apart = std::max(apart, (wired.device.measured.q - record.q).norm());
    ofDelay = std::max(ofDelay, (other.q - record.q).norm());
  }
  CHECK(wired.largest > 0.5);
  CHECK(apart == 0.0);
  CHECK(ofDelay > 1e-7);  // without the delay they differ
}

}  // namespace enamel::test_device_link
