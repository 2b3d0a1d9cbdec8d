// Reports how well a loop meets its deadlines beside a busy core. Times are printed only.
#include <atomic>
#include <cstdio>
#include <thread>

#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/simulated_device.hpp"
#include "support/catch.hpp"
#include "support/eventually.hpp"
#include "support/run_length.hpp"

namespace enamel::test_loop {

namespace {

void print(const char* name, const DurationHistogram& h) {
  std::printf("  %-14s p50 %7.1f  p99 %7.1f  p99.9 %7.1f  max %7.1f us\n", name, 1e6 * h.quantile(0.5),
              1e6 * h.quantile(0.99), 1e6 * h.quantile(0.999), 1e6 * h.largest());
}

}  // namespace

TEST_CASE("deadlines of a loop beside a busy core", "[timing]") {
  const TauMechanism mechanism(nominalDevice());
  const Scene scene = flatWall();
  for (const double rate : {1000.0, 4000.0}) {
    const double period = 1.0 / rate, seconds = rate > 2000.0 ? test::count(1, 10) : test::count(2, 60);
    VirtualDeviceSetup setup;
    setup.period = period;
    SimulatedDevice device(
        mechanism, setup,
        [](double time, const Pose& pose, const Vec6& twist) {
          Vec6 wrench = guidingWrench(pose, twist, Pose{}, Vec3::UnitZ());
          wrench[2] -= 400.0 * (pose.position.z() - 0.01 * std::cos(6.0 * time)) + 12.0 * twist[2];
          return wrench;
        },
        true);
    PositionControlRenderer servo(positionControlFor(mechanism, period, 0, 0));
    HapticTick haptics(mechanism, scene, Tool(), servo, period);
    std::atomic<bool> busy{true};
    std::thread other([&busy] {
      while (busy.load(std::memory_order_relaxed)) continue;
    });
    {
      HapticLoop loop(device, haptics);
      std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
      busy = false;
      const PeriodicTiming& timing = loop.timing();
      REQUIRE(test::eventually([&] { return loop.refresh() && loop.latest().number > 10; }));
      const JointVector& torque = loop.latest().command.effort;
      REQUIRE(torque.size() == mechanism.joints());
      CHECK(torque.allFinite());
      CHECK((torque.cwiseAbs() - mechanism.limits().effort).maxCoeff() <= 0.0);
      std::printf("loop at %.0f Hz for %.0f s: %llu ticks, %llu missed, %s scheduling, memory %s, guard: %s\n", rate,
                  seconds, static_cast<unsigned long long>(timing.periods.load()),
                  static_cast<unsigned long long>(timing.missed.load()), timing.realtime ? "real-time" : "normal",
                  loop.memoryLocked() ? "locked" : "not locked", toString(loop.latest().reason));
      print("wake-up error", timing.wakeUp);
      print("compute time", timing.compute);
      print("command's age", loop.age());
    }
    other.join();
  }
}

}  // namespace enamel::test_loop
