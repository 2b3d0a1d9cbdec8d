// The loop's thread in every state, and a device over real sockets.
#include "enamel/runtime/haptic_loop.hpp"

#include <atomic>
#include <iostream>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "enamel/runtime/udp_device.hpp"
#include "support/catch.hpp"
#include "support/device_wire.hpp"
#include "support/eventually.hpp"

namespace enamel::test_haptic_loop {

using test::ContainsSubstring;
using test::eventually;

namespace {

const CartesianMechanism& stylus() {
  static const CartesianMechanism mechanism(loadCartesian(test::deviceFile("cartesian-3.toml")));
  return mechanism;
}

void sleepFor(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

// A device 1 mm inside the wall that counts calls and can be broken from another thread. Its time is that of its
// measurements, so that a loaded machine misses no deadline.
class Bench final : public HapticDevice {
 public:
  std::atomic<bool> broken{false}, refusesOpen{false}, measureHangs{false}, actuateHangs{false};
  std::atomic<int> opened{0}, closed{0}, measured{0}, actuated{0};
  std::atomic<double> last{0.0};      // along z, N
  std::atomic<double> steepest{0.0};  // largest change from one command to the next, N
  std::atomic<double> depth{-1e-3};

  void open() override {
    if (refusesOpen) throw Error("the bench is not there");
    ++opened;
  }
  void close() noexcept override {
    if (opened > closed) ++closed;
  }
  Status measure(Measurement& m) noexcept override {
    ++measured;
    while (measureHangs) sleepFor(1e-3);
    if (broken) return Status::stale;
    m.time = 1e-3 * measured;
    m.q = m.rates = JointVector::Zero(3);
    m.q[2] = -depth;
    return Status::ok;
  }
  Status actuate(const Command& command) noexcept override {
    ++actuated;
    while (actuateHangs) sleepFor(1e-3);
    steepest = std::max(steepest.load(), std::abs(command.effort[2] - last));
    last = command.effort[2];
    return Status::ok;
  }
};

// A renderer that pushes with 2 N after the guard has engaged; its request starts small.
class Pusher final : public Renderer {
 private:
  void prepare(double) override {}
  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    force_ = std::min(2.0, force_ + 0.05);
    output.torque = input.kinematics.gravity;
    output.torque[2] += force_;
    output.mode = RenderMode::contact;
    return Status::ok;
  }
  void resetState() noexcept override { force_ = 0.0; }
  StateBlock stateBlock() noexcept override { return {&force_, sizeof(force_)}; }
  double force_ = 0.0;
};

struct Rig {
  Bench bench;
  Scene scene = flatWall();
  Pusher pusher;
  HapticTick haptics{stylus(), scene, Tool(), pusher, 1e-3};
};

class Counter final : public TickSink {
 public:
  std::atomic<std::uint64_t> ticks{0}, wrong{0}, resets{0};
  void tick(const LoopTick& t, const HapticTick& haptics) noexcept override {
    if (t.number != ticks || t.command.effort.size() != 3 || t.reason != haptics.frame().reason ||
        t.requested != haptics.frame().output.torque || !(t.age >= t.compute))
      ++wrong;
    resets.fetch_add(t.reset ? 1u : 0u);
    ++ticks;
  }
};

HapticLoopOptions normal() {
  HapticLoopOptions options;
  options.lockMemory = false;
  return options;
}

}  // namespace

TEST_CASE("a loop that cannot begin says why and leaves the device closed", "[haptic_loop]") {
  Rig rig;
  HapticLoopOptions options = normal();
  options.period = 3e-3;
  CHECK_THROWS_WITH(HapticLoop(rig.bench, rig.haptics, options), ContainsSubstring("must be in 1e-04 to 0.002 s"));
  options.period = 0.0;
  CHECK(rig.bench.opened == 0);
  rig.bench.refusesOpen = true;
  CHECK_THROWS_WITH(HapticLoop(rig.bench, rig.haptics, options), "the bench is not there");
  rig.bench.refusesOpen = false;
  rig.bench.broken = true;
  options.firstMeasurement = 0.01;
  CHECK_THROWS_WITH(HapticLoop(rig.bench, rig.haptics, options), ContainsSubstring("no measurement within 0.01 s"));
  CHECK(rig.bench.opened == 1);
  CHECK(rig.bench.closed == 1);
  CHECK(rig.bench.actuated == 0);

  GuardOptions off = guardFor(stylus(), 1e-3);
  off.on = false;
  HapticTick unguarded(stylus(), rig.scene, Tool(), rig.pusher, off);
  CHECK_THROWS_WITH(HapticLoop(rig.bench, unguarded, normal()), ContainsSubstring("the guard is off"));
}

TEST_CASE("a loop that cannot stop names the function that does not return, and waits for it", "[haptic_loop]") {
  class Hook final : public TickSink {
   public:
    std::atomic<bool> hangs{false};
    void before(Measurement&) noexcept override {
      while (hangs) sleepFor(1e-3);
    }
    void tick(const LoopTick&, const HapticTick&) noexcept override {}
  };
  // The standard error of the loop's end; another thread reads it.
  class Text final : public std::stringbuf {
   public:
    std::string text() {
      const std::lock_guard<std::mutex> lock(mutex_);
      return str();
    }

   private:
    std::streamsize xsputn(const char* from, std::streamsize count) override {
      const std::lock_guard<std::mutex> lock(mutex_);
      return std::stringbuf::xsputn(from, count);
    }
    std::mutex mutex_;
  };
  Rig rig;
  Hook hook;
  HapticLoopOptions options = normal();
  options.sink = &hook;
  for (const auto& [hangs, name] : {std::pair{&rig.bench.measureHangs, "measure() of the device has not returned"},
                                    std::pair{&rig.bench.actuateHangs, "actuate() of the device has not returned"},
                                    std::pair{&hook.hangs, "a renderer or a hook in the tick has not returned"}}) {
    CAPTURE(name);
    Text errors;
    std::streambuf* const usual = std::cerr.rdbuf(&errors);
    auto loop = std::make_unique<HapticLoop>(rig.bench, rig.haptics, options);
    *hangs = true;
    std::atomic<bool> ended{false};
    std::thread end([&] {
      loop.reset();
      ended = true;
    });
    const bool isNamed = eventually([&] { return !errors.text().empty(); });
    const bool hasWaited = !ended;
    *hangs = false;
    end.join();
    std::cerr.rdbuf(usual);
    CHECK(isNamed);
    CHECK(hasWaited);
    CHECK_THAT(errors.text(), ContainsSubstring(name));
    CHECK(errors.text().find('\n') == errors.text().size() - 1);  // one line
    CHECK(rig.bench.closed == rig.bench.opened);
  }
}

TEST_CASE("a loop ends with the motors at rest, whenever and in whatever state", "[haptic_loop]") {
  for (int state = 0; state < 7; ++state) {
    CAPTURE(state);
    Rig rig;
    Counter counter;
    {
      HapticLoopOptions options = normal();
      options.sink = &counter;
      HapticLoop loop(rig.bench, rig.haptics, options);
      if (state >= 1) REQUIRE(eventually([&] { return rig.bench.last == 2.0; }));
      if (state == 2) CHECK(loop.stop());
      if (state == 3) {
        CHECK(loop.stop());
        REQUIRE(eventually([&] { return loop.stopped(); }));
        CHECK(rig.bench.last == 0.0);
      }
      if (state == 4) rig.bench.broken = true;
      if (state == 5) {
        rig.bench.broken = true;
        REQUIRE(eventually([&] { return rig.bench.last == 0.0; }));
      }
      if (state == 6)
        for (int i = 0; i < 100; ++i) (void)(i % 3 == 0 ? loop.stop() : loop.reset());
      CHECK(rig.bench.closed == 0);
    }
    CHECK(rig.bench.closed == 1);
    CHECK(rig.bench.last == 0.0);
    CHECK(counter.wrong == 0);
    if (state == 1) CHECK(rig.bench.steepest <= 2.0 * 1e-3 / 0.02 * (1.0 + 1e-9));  // the guard's ramp
    const int after = rig.bench.measured;
    sleepFor(5e-3);
    CHECK(rig.bench.measured == after);
  }
}

TEST_CASE("a device that falls silent is ramped out, and comes back after a reset alone", "[haptic_loop]") {
  Rig rig;
  Counter counter;
  HapticLoopOptions options = normal();
  options.sink = &counter;
  HapticLoop loop(rig.bench, rig.haptics, options);
  const auto reason = [&loop] {
    (void)loop.refresh();
    return loop.latest().reason;
  };
  REQUIRE(eventually([&] { return rig.bench.last == 2.0; }));
  CHECK(eventually([&] { return reason() == GuardReason::none; }));
  rig.bench.broken = true;
  CHECK(eventually([&] { return reason() == GuardReason::late; }));
  CHECK(eventually([&] { return rig.bench.last == 0.0; }));
  CHECK(loop.held() > 4);
  CHECK(loop.latest().device == Status::stale);
  rig.bench.broken = false;
  CHECK(eventually([&] { return (void)loop.refresh(), loop.latest().device == Status::ok; }));
  CHECK(reason() == GuardReason::late);
  CHECK(rig.bench.last == 0.0);
  CHECK(loop.reset());
  CHECK(eventually([&] { return rig.bench.last == 2.0; }));
  CHECK(eventually([&] { return reason() == GuardReason::none; }));
  CHECK(counter.resets == 1);
  CHECK(loop.age().count() > 0);
  CHECK(loop.timing().wakeUp.count() > 0);
}

TEST_CASE("a second loop on the same tick begins anew", "[haptic_loop]") {
  Rig rig;
  for (int loops = 0; loops < 2; ++loops) {
    HapticLoop loop(rig.bench, rig.haptics, normal());
    CHECK(eventually([&] { return rig.bench.last == 2.0; }));
    CHECK(rig.haptics.guard().fault() == GuardReason::none);
    rig.bench.measured += 3000;  // 3 s pass
    CHECK(eventually([&] { return (void)loop.refresh(), loop.latest().reason == GuardReason::late; }));
  }
}

TEST_CASE("memory is locked as long as a loop lives, where the system allows it", "[haptic_loop]") {
  Rig rig, other;
  bool first = false;
  {
    HapticLoop loop(rig.bench, rig.haptics);
    first = loop.memoryLocked();
    HapticLoop second(other.bench, other.haptics);
    CHECK(second.memoryLocked() == first);
    REQUIRE(eventually([&] { return rig.bench.last == 2.0 && other.bench.last == 2.0; }));
  }
  if (!first) WARN("the system refused to lock memory");
}

TEST_CASE("a device that runs on its own clock is asked more often than it ticks", "[haptic_loop]") {
  Rig rig;
  class Slow final : public HapticDevice {  // a new sample at every fourth call
   public:
    explicit Slow(Bench& bench) : bench_(bench) {}
    Status measure(Measurement& m) noexcept override {
      return questions_++ % 4 == 0 ? bench_.measure(m) : Status::stale;
    }
    Status actuate(const Command& command) noexcept override { return bench_.actuate(command); }

   private:
    Bench& bench_;
    std::uint64_t questions_ = 0;
  } slow(rig.bench);
  HapticLoopOptions options = normal();
  options.period = 2.5e-4;
  HapticLoop loop(slow, rig.haptics, options);
  REQUIRE(eventually([&] { return rig.bench.last == 2.0; }));
  (void)loop.refresh();
  CHECK(loop.latest().reason == GuardReason::none);
  CHECK(loop.held() > 2 * loop.latest().number);
}

TEST_CASE("over the loopback: a wall is felt, the end of either side ramps out", "[haptic_loop]") {
  SimulatedDevice plant(stylus(), test::swingStart(), test::swingingHand());
  auto server = std::make_unique<DeviceServer>(plant, stylus(), [] {
    ServeOptions options;
    options.port = 0;
    options.link.timeout = 0.1;  // for threads of a loaded machine
    return options;
  }());
  LinkOptions link;
  link.joints = 3;
  link.timeout = 0.1;
  UdpDevice device("127.0.0.1", server->port(), link);
  const Scene scene = flatWall();
  ImpedanceRenderer wall({400.0, 0.0});
  GuardOptions guard = guardFor(stylus(), 1e-3);
  guard.longestGap = 100;
  guard.mostMissed = 1000000;
  HapticTick haptics(stylus(), scene, Tool(), wall, guard);
  HapticLoopOptions options = normal();
  options.period = 2.5e-4;
  options.firstMeasurement = 300.0;
  {
    HapticLoop loop(device, haptics, options);
    CHECK(eventually([&] {
      (void)loop.refresh();
      // Threads that wait too long for a processor cause a fault of the guard.
      if (isFault(loop.latest().reason)) (void)loop.reset();
      return loop.latest().reason == GuardReason::none && loop.latest().command.effort.norm() > 0.3 &&
             device.counts().accepted > 100 && device.counts().roundTrip.count() > 100;
    }));
    CHECK(loop.latest().measurement.enabled);
    server.reset();
    CHECK(eventually([&] {
      (void)loop.refresh();
      return loop.latest().reason == GuardReason::late && loop.latest().command.effort.norm() == 0.0;
    }));
  }
}

TEST_CASE("while a session lasts, what comes from elsewhere does not reach the device", "[haptic_loop]") {
  SimulatedDevice plant(stylus(), test::swingStart(), test::swingingHand());
  ServeOptions options;
  options.port = 0;
  options.link.timeout = 2.0;  // s, longer than between two calls of the client, even on a slow machine
  const DeviceServer server(plant, stylus(), options);
  LinkOptions link;
  link.joints = 3;
  link.timeout = options.link.timeout;
  UdpDevice device("127.0.0.1", server.port(), link);
  Measurement m;
  const auto measured = [&] { return device.measure(m) == Status::ok; };
  REQUIRE(eventually(measured));
  REQUIRE(eventually(measured));  // the server knows the session
  const std::uint64_t before = device.counts().accepted;
  for (int i = 0; i < 200; ++i) {
    UdpDevice other("127.0.0.1", server.port(), link);
    Measurement none;
    CHECK(other.measure(none) == Status::stale);
    (void)measured();
  }
  REQUIRE(eventually([&] { return measured() && device.counts().accepted > before + 20; }));
  for (const auto& reason : server.counts().dropped) CHECK(reason == 0);
  // After its end, anyone can begin a session.
  UdpDevice next("127.0.0.1", server.port(), link);
  CHECK(eventually([&] { return next.measure(m) == Status::ok; }));
}

TEST_CASE("a served device that was never measured gets nothing, not even its weight", "[haptic_loop]") {
  CartesianParameters heavy = loadCartesian(test::deviceFile("cartesian-3.toml"));
  heavy.gravity.z() = -9.81;
  const CartesianMechanism mechanism(heavy);
  Bench bench;
  bench.broken = true;
  ServeOptions options;
  options.port = 0;
  {
    const DeviceServer server(bench, mechanism, options);
    REQUIRE(eventually([&] { return bench.actuated > 3; }));
  }
  CHECK(bench.steepest == 0.0);
}

TEST_CASE("what is not of this machine needs a key", "[haptic_loop]") {
  SimulatedDevice plant(stylus(), test::swingStart(), test::swingingHand());
  ServeOptions options;
  options.port = 0;
  options.address = "0.0.0.0";
  CHECK_THROWS_WITH(DeviceServer(plant, stylus(), options), ContainsSubstring("give a key"));
  options.address = "no such host.";
  CHECK_THROWS_WITH(DeviceServer(plant, stylus(), options), ContainsSubstring("cannot find"));
  LinkOptions link;
  link.joints = 3;
  CHECK_THROWS_WITH(UdpDevice("192.0.2.1", 5, link), ContainsSubstring("give a key"));
  options.address = "127.0.0.1";
  const DeviceServer first(plant, stylus(), options);
  options.port = first.port();
  SimulatedDevice other(stylus(), test::swingStart(), test::swingingHand());
  CHECK_THROWS_WITH(DeviceServer(other, stylus(), options), ContainsSubstring("cannot bind to 127.0.0.1:"));
}

}  // namespace enamel::test_haptic_loop
