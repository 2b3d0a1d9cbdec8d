// A whole tick, forward kinematics -> contact -> renderer, allocates nothing: good input, bad input, faults and resets.
#include "enamel/render/tick.hpp"

#include "enamel/sim/virtual_device.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_tick {

TEST_CASE("a tick of either renderer allocates nothing", "[realtime]") {
  const DeviceModel model = makeModel(test::nominal());
  const Scene wall = flatWall();
  const Tool tool;
  PositionControlRenderer hold = test::positionControl(model);
  ImpedanceRenderer spring(model, {6000.0, 0.0, 4.0});
  for (Renderer* renderer : {static_cast<Renderer*>(&hold), static_cast<Renderer*>(&spring)}) {
    renderer->activate(1e-3);
    test::Random random(81);
    Encoders encoders({true, RateSource::lowPass, 100.0}, model.encoderCounts, 1e-3);
    const RandomStream stream(1, 0);
    Motors motors({0, 3}, Vec6::Zero());
    std::vector<unsigned char> state(renderer->stateSize());
    TickMemory memory{model.home, makeToolCache(wall, tool)};
    TickInput input;
    TickOutput output;
    int ok = 0, contact = 0;
    double sum = 0.0;
    const long before = test::allocationCount();
    for (std::uint64_t i = 0; i < 5000; ++i) {
      Pose pose;
      pose.position.z() = 2e-4 * std::sin(0.01 * static_cast<double>(i));
      Vec6 q = model.homeAngles;
      if (inverseKinematics(model, pose, q) != Status::ok) continue;
      Measurement m = encoders.measure(q, Vec6::Zero());
      if (i % 100 == 7) m.q[2] = std::nan("");
      if (i % 100 == 9) m.q[2] += 2.0;
      const Status status =
          hapticTick(model, wall, tool, 1e-3 * static_cast<double>(i), m.q, m.rates, memory, *renderer, input, output);
      ok += status == Status::ok;
      contact += output.mode == RenderMode::contact;
      sum += motors.actuate(i, output.torque, stream)[0] + stream.normal(RandomStream::Purpose::noise, i);
      renderer->saveState(state.data());
      renderer->loadState(state.data());
      if (i % 1000 == 999) renderer->reset();
    }
    const long allocated = test::allocationCount() - before;
    CHECK(allocated == 0);
    CHECK(ok > 4000);
    CHECK(contact > 1000);
    CHECK(std::isfinite(sum));
  }
}

}  // namespace enamel::test_tick
