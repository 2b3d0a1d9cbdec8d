// Design a servo for a device and use it. The paper's way leads from the device file to a gain, the loop's stability
// margin, and the depth of a push of 12 N into the wall. For comparison: a spring, and the servo in contact space.
//
//   servo tau-nominal.toml
#include <algorithm>
#include <cstdio>
#include <enamel/control/device_plant.hpp>
#include <enamel/control/margins.hpp>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/hold.hpp>
#include <enamel/render/impedance.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/sim/push.hpp>

using namespace enamel;

namespace {

constexpr double kPeriod = 1e-3;  // s

// Return the deepest point of a push against the wall z = 0, m.
double depthOf(const Mechanism& device, Renderer& renderer, const char* name) {
  PushSetup push;  // a step of 12 N at 1 s
  push.period = kPeriod;
  push.hand.force =
      std::min(12.0, 0.3 * largestForce(device.home(), device.limits().effort, Vec3::Zero(), Vec3::UnitZ()));
  push.hand.noise = 0.0;
  double deepest = 0.0, last = 0.0;
  const PushResult result = runPush(device, renderer, push, [&](const TickRecord& tick) {
    deepest = std::max(deepest, -tick.nearest.gap);
    last = -tick.nearest.gap;
  });
  std::printf("%-6s %8.3f mm deep, %8.4f mm at rest%s%s\n", name, 1e3 * deepest, 1e3 * last,
              result.status == Status::ok ? "" : ": stopped, ",
              result.status == Status::ok ? "" : toString(result.guard));
  return deepest;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: servo DEVICE.toml\n"), 2;
  try {
    DeviceParameters parameters = loadDevice(argv[1]);
    addDamping(parameters, Vec6::Constant(4.0).cwiseProduct((Vec6() << 1, 1, 1, 0, 0, 0).finished()));  // N s/m
    const auto device = makeMechanism(idealOf(parameters));

    std::printf("weight  disk margin  stable delay\n");
    double softest = 0.0, stiffest = 0.0;
    for (const double weight : {1e2, 1e4, 1e6}) {
      ServoWeights weights;  // the paper's weights except for the position
      weights.position = weight;
      const ServoDesign design = designServo(device, Pose{}, kPeriod, weights);
      const Margins margins = measureMargins(runningLoop(design), design.K, kPeriod);
      std::printf("%.0e         %.2f  %d ticks           ", weight, margins.disk, margins.toleratedDelay);
      HoldRenderer hold(design.K, kPeriod, HoldOptions{});
      stiffest = depthOf(*device, hold, "hold");
      if (softest == 0.0) softest = stiffest;
    }
    ImpedanceRenderer spring({6000.0, 0.0});  // N/m, N s/m
    const double conventional = depthOf(*device, spring, "                                    spring");
    PositionControlRenderer servo(positionControlFor(*device, kPeriod, 0, 0));
    const double best = depthOf(*device, servo, "                          in contact space");
    return stiffest < softest && best < stiffest && stiffest < conventional ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "servo: %s\n", error.what());
    return 1;
  }
}
