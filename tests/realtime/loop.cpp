// A period of a loop never allocates, with or without a network link.
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/udp_device.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/device_wire.hpp"
#include "support/eventually.hpp"

namespace enamel::test_loop {

namespace {

const CartesianMechanism& stylus() {
  static const CartesianMechanism mechanism(loadCartesian(test::deviceFile("cartesian-3.toml")));
  return mechanism;
}

}  // namespace

TEST_CASE("periods of a loop allocate nothing", "[realtime]") {
  class Flickering final : public HapticDevice {  // no measurement for a while
   public:
    explicit Flickering(HapticDevice& device) : device_(device) {}
    Status measure(Measurement& m) noexcept override {
      return ++calls_ % 1000 > 990 ? Status::stale : device_.measure(m);
    }
    Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

   private:
    HapticDevice& device_;
    int calls_ = 0;
  };
  SimulatedDevice plant(stylus(), test::swingStart(), test::swingingHand(), true);
  Flickering device(plant);
  const Scene scene = flatWall();
  ImpedanceRenderer wall({400.0, 0.0});
  HapticTick haptics(stylus(), scene, Tool(), wall, 1e-3);
  LoopBody body(device, haptics, {});
  int faults = 0;
  const long before = test::allocationCount();
  for (int i = 0; i < 5000; ++i) {
    (void)body.step();
    if (haptics.guard().fault() == GuardReason::none) continue;
    ++faults;
    if (faults % 30 == 0) body.reset();
  }
  body.stop();
  int left = 0;
  while (body.step() && left < 1000) ++left;
  CHECK(test::allocationCount() - before == 0);
  CHECK(faults > 30);
  CHECK(left > 10);
  CHECK(left < 200);
}

TEST_CASE("a device over UDP allocates nothing, in its loop and in its server", "[realtime]") {
  SimulatedDevice plant(stylus(), test::swingStart(), test::swingingHand(), true);
  ServeOptions options;
  options.port = 0;
  options.link.key = LinkKey{1, 2, 3};
  DeviceServer server(plant, stylus(), options);
  LinkOptions link;
  link.joints = 3;
  link.key = LinkKey{1, 2, 3};
  UdpDevice device("127.0.0.1", server.port(), link);
  const Scene scene = flatWall();
  ImpedanceRenderer wall({400.0, 0.0});
  HapticTick haptics(stylus(), scene, Tool(), wall, 1e-3);
  HapticLoopOptions how;
  how.period = 2.5e-4;
  how.firstMeasurement = 300.0;
  how.lockMemory = false;
  HapticLoop loop(device, haptics, how);
  const auto accepts = [&device](std::uint64_t more) {
    const std::uint64_t before = device.counts().accepted;
    return test::eventually([&] { return device.counts().accepted >= before + more; });
  };
  REQUIRE(accepts(50));
  const long before = test::allocationCount();
  CHECK(accepts(300));
  CHECK(test::allocationCount() - before == 0);
}

}  // namespace enamel::test_loop
