// A tick of the tool, or of a device that CHAI3D drives, never allocates.
#include "chai3d/driver.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/position_control.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"

namespace enamel::test_ticks {

TEST_CASE("ticks of the CHAI3D adapter allocate nothing", "[chai3d]") {
  for (const char* name : {"cartesian-3", "cartesian-6"}) {
    INFO(name);
    const auto mechanism =
        makeMechanism(loadDevice(std::string(ENAMEL_SOURCE_DIR) + "/data/devices/" + name + ".toml"));
    PositionControlRenderer servo(positionControlFor(*mechanism, 1e-3, 0, 0));
    test::Bench bench(*mechanism, servo, 100.0);
    chai3d::cMesh box;
    test::makeBox(box);
    bench.tool.addMesh(&box);
    REQUIRE(bench.tool.start());
    int faults = 0, touching = 0;
    const long before = test::allocationCount();
    for (int i = 0; i < 4000; ++i) {
      box.setLocalPos(i % 1000 < 500 ? 1e-6 * (i % 500) : 0.0, 0.0, 0.0);
      box.computeGlobalPositionsFromRoot();
      bench.driver->lost = i % 500 > 490;
      bench.driver->offset.x() = i % 1000 > 980 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
      bench.tick();
      touching += bench.tool.isInContact(&box) ? 1 : 0;
      if (isFault(bench.tool.latest()->reason)) ++faults, bench.tool.reset();
    }
    CHECK(test::allocationCount() - before == 0);
    CHECK(touching > 200);
    CHECK(faults > 10);

    Chai3dDevice device(bench.driver, *mechanism);
    Measurement measurement;
    Command command{JointVector::Constant(mechanism->joints(), 0.01)};
    bench.driver->moves = false;
    bench.driver->lost = false;
    bench.driver->offset.setZero();
    int measured = 0;
    const long then = test::allocationCount();
    for (int i = 0; i < 1000; ++i) {
      bench.driver->stretch = i % 10 == 0 ? 2.0 : 1.0;
      measured += device.measure(measurement) == Status::ok ? 1 : 0;
      (void)device.actuate(command);
    }
    CHECK(test::allocationCount() - then == 0);
    CHECK(measured > 100);
  }
}

}  // namespace enamel::test_ticks
