// Each driver in real time against its stand-in: 3 minutes with ENAMEL_LONG=1, otherwise 2 s. Times are printed only.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>

#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "support/driver_rigs.hpp"
#include "support/processor_time.hpp"
#include "support/run_length.hpp"

namespace enamel::test_drivers {

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// Measures the calls of a driver in the thread of the loop: real time and processor time.
class Metered final : public HapticDevice {
 public:
  explicit Metered(HapticDevice& device) : device_(device) {}
  void open() override { device_.open(); }
  void close() noexcept override { device_.close(); }
  Status measure(Measurement& m) noexcept override {
    return metered([&] { return device_.measure(m); });
  }
  Status actuate(const Command& command) noexcept override {
    return metered([&] { return device_.actuate(command); });
  }

  DurationHistogram calls;             // s
  std::atomic<double> processor{0.0};  // s

 private:
  template <typename Call>
  Status metered(const Call& call) noexcept {
    const auto begin = Clock::now();
    const double before = test::processorTime();
    const Status status = call();
    processor = processor + (test::processorTime() - before);
    calls.add(since(begin));
    return status;
  }

  HapticDevice& device_;
};

// Counts ticks, contacts, and forces above those of the device.
struct Counter final : TickSink {
  void tick(const LoopTick& tick, const HapticTick&) noexcept override {
    ++ticks;
    if (tick.mode == RenderMode::contact && tick.reason == GuardReason::none) ++inContact;
    if (tick.measurement.age > 0) ++predicted;
  }
  std::atomic<std::uint64_t> ticks{0}, inContact{0}, predicted{0};
};

void print(const char* name, const DurationHistogram& h) {
  std::printf("  %-24s p50 %7.1f  p99 %7.1f  p99.9 %7.1f  max %7.1f us\n", name, 1e6 * h.quantile(0.5),
              1e6 * h.quantile(0.99), 1e6 * h.quantile(0.999), 1e6 * h.largest());
}

// A hand moves in and out of a wall by 4 mm once a second.
void run(const char* name, const test::Rig& rig) {
  const double seconds = test::count(2, 180);
  OpenedDevice opened = test::openAt(rig.url);
  const double largest = opened.mechanism->limits().effort.head<3>().norm();
  PositionControlRenderer control(positionControlFor(*opened.mechanism, 1e-3, opened.delay.low, opened.delay.high));
  const Scene scene = flatWall();
  HapticTick haptics(*opened.mechanism, scene, Tool(), control, 1e-3);
  Metered device(*opened.device);
  Counter counter;
  HapticLoopOptions options;
  options.period = opened.poll;
  options.sink = &counter;
  int faults = 0;
  double strongest = 0.0;  // N
  rig.hold(4e-3 * Vec3::UnitZ(), 100.0, 5.0);
  HapticLoop loop(device, haptics, options);
  const auto begin = Clock::now();
  // On a busy machine, go on until there was contact.
  REQUIRE(test::eventually([&] {
    do {
      rig.hold(4e-3 * std::cos(2.0 * M_PI * since(begin)) * Vec3::UnitZ(), 100.0, 5.0);
      strongest = std::max(strongest, rig.force().norm());
      if (loop.refresh() && isFault(loop.latest().reason)) {
        ++faults;
        std::printf("  %.3f s: %s\n", since(begin), toString(loop.latest().reason));
        (void)loop.reset();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    } while (since(begin) < seconds);
    return counter.inContact > 100;
  }));
  const double whole = since(begin);
  CHECK(strongest > 0.1);
  CHECK(strongest <= largest * (1.0 + 1e-9));
  std::printf(
      "%s: %.0f s, %llu ticks, %llu in contact, %llu predicted, %llu missed periods, %d faults, %s scheduling; "
      "driver %.1f %% of a core\n",
      name, whole, static_cast<unsigned long long>(counter.ticks), static_cast<unsigned long long>(counter.inContact),
      static_cast<unsigned long long>(counter.predicted), static_cast<unsigned long long>(loop.timing().missed.load()),
      faults, loop.timing().realtime ? "real-time" : "normal", 100.0 * device.processor / whole);
  print("a call of the driver", device.calls);
  print("a period of the loop", loop.timing().compute);
  print("age of the command", loop.age());
}

}  // namespace

#ifdef ENAMEL_DHD_STAND_IN
TEST_CASE("the Force Dimension driver in real time", "[timing]") {
  const test::DhdRig standIn;
  run("forcedimension", standIn.rig);
}
#endif

#ifdef ENAMEL_HD_STAND_IN
TEST_CASE("the OpenHaptics driver in real time", "[timing]") {
  const test::HdRig standIn(false);
  run("openhaptics", standIn.rig);
}
#endif

#ifdef ENAMEL_HAPLY_SERVICE
TEST_CASE("the Haply driver in real time", "[timing]") {
  const test::HaplyRig standIn;
  run("haply", standIn.rig);
}
#endif

}  // namespace enamel::test_drivers
