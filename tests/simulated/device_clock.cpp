// Devices with a clock of their own: 500 Hz to 4 kHz, faster and slower than stated, with jitter and in bursts.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "support/catch.hpp"
#include "support/run_length.hpp"
#include "support/stepped_device.hpp"

namespace enamel::test_device_clock {

using test::Rig;
using test::SteppedDevice;

namespace {

// When the samples of a device come.
struct Samples {
  double rate;              // of the ticks, Hz
  double error = 0.0;       // of the device's rate, share
  double jitter = 0.0;      // of each instant, share of a period, to both sides
  int late = 1, every = 1;  // of `every` samples the last `late` come together
};

struct Pressed {
  std::uint64_t ticks = 0, samples = 0;
  double deepest = 0.0, force = 0.0;  // m, N: largest depth after 0.5 s, mean force
  GuardReason fault = GuardReason::none;
};

// A hand presses against a wall for 4 s: with 1 N, at a place 4 mm behind it.
Pressed press(const Rig& rig, const Samples& samples) {
  constexpr double kStiffness = 250.0, kBehind = 4e-3, kTime = 4.0;  // N/m, m, s
  const double period = 1.0 / samples.rate;
  OpenDeviceOptions how;
  how.pluginFolder = ENAMEL_PLUGINS;
  how.period = period;
  OpenedDevice opened = openDevice(rig.url, how);
  std::mt19937_64 random(test::seed());
  std::uint64_t frames = 0;
  const auto instant = [&](std::uint64_t i) {  // of the sample i, s
    const std::uint64_t in = i % static_cast<std::uint64_t>(samples.every);
    const auto last = static_cast<std::uint64_t>(samples.every);
    if (in + static_cast<std::uint64_t>(samples.late) >= last) i += last - 1 - in;
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    return period / (1.0 + samples.error) * (static_cast<double>(i) + samples.jitter * (2.0 * share - 1.0));
  };
  double next = instant(1);
  SteppedDevice device(std::move(opened.device), rig, opened.poll > 0.0 ? opened.poll : period, [&](double time) {
    while (time >= next) {
      rig.period();
      next = instant(++frames + 1);
    }
  });
  PositionControlRenderer control(positionControlFor(*opened.mechanism, period, opened.delay.low, opened.delay.high));
  const Scene scene = flatWall();
  HapticTick haptics(*opened.mechanism, scene, Tool(), control, period);
  HapticLoopOptions options;
  options.period = opened.poll;
  LoopBody body(device, haptics, options);
  Pressed result;
  rig.hold(Vec3(0.0, 0.0, -kBehind), kStiffness, 5.0);
  double sum = 0.0;
  int count = 0;
  while (device.time() < kTime) {
    (void)body.step();
    if (result.fault == GuardReason::none) result.fault = haptics.guard().fault();
    if (device.time() < 0.5) continue;
    result.deepest = std::max(result.deepest, -body.tick().pose.position.z());
    sum += rig.force().z();
    ++count;
  }
  result.ticks = body.tick().number;
  result.samples = opened.poll > 0.0 ? frames : result.ticks;
  result.force = sum / count;
  return result;
}

// The wall must hold, and each sample must be a tick.
void checkFollows(const std::string& name, const Rig& rig, const Samples& samples) {
  const Pressed result = press(rig, samples);
  std::cout << name << ", " << samples.rate << " Hz, clock " << 100.0 * samples.error << " %, jitter " << samples.jitter
            << ", the last " << samples.late << " of " << samples.every << " together: " << result.ticks << " ticks of "
            << result.samples << " samples, deepest " << 1e6 * result.deepest << " um, " << result.force << " N\n";
  INFO(name << ", " << samples.rate << " Hz: " << toString(result.fault));
  CHECK(result.fault == GuardReason::none);
  const auto most = static_cast<double>(result.samples), ticks = static_cast<double>(result.ticks);
  CHECK(ticks > 0.97 * most * (samples.every > 1 ? 1.0 - static_cast<double>(samples.late) / samples.every : 1.0));
  CHECK(ticks < 1.03 * most + 2.0);
  CHECK(result.deepest < 1e-3);  // the hand alone: 4 mm
  CHECK(result.force > 0.6);     // of the 1 N, minus the friction of the device
}

}  // namespace

#ifdef ENAMEL_HD_STAND_IN
TEST_CASE("the loop follows the clock of a Touch", "[device_clock]") {
  test::HdRig standIn;
  const std::string url = standIn.rig.url;
  for (const double rate : {500.0, 1000.0, 2000.0, 4000.0}) {
    standIn.rig.url = url + "&rate=" + std::to_string(static_cast<int>(rate));
    for (const double error : {-0.01, 0.0, 0.01}) checkFollows("Touch", standIn.rig, {rate, error, 0.2});
  }
  standIn.rig.url = url;
  checkFollows("Touch", standIn.rig, {1000.0, 0.0, 0.0, 3, 50});  // three samples together, every 50 ms
}

TEST_CASE("samples of a Touch that always come in bursts stop the loop", "[device_clock]") {
  const test::HdRig standIn;
  for (const int together : {3, 6}) {
    const Pressed result = press(standIn.rig, {1000.0, 0.0, 0.0, together, together});
    INFO(together << ": " << toString(result.fault));
    CHECK((result.fault == GuardReason::deadlines || result.fault == GuardReason::late));
    CHECK(standIn.rig.force().isZero());
  }
}
#endif

#ifdef ENAMEL_DHD_STAND_IN
TEST_CASE("the Force Dimension driver runs at 500 Hz to 4 kHz", "[device_clock]") {
  const test::DhdRig standIn;
  for (const double rate : {500.0, 1000.0, 2000.0, 4000.0}) checkFollows("omega.3", standIn.rig, {rate});
}
#endif

#ifdef ENAMEL_HAPLY_SERVICE
TEST_CASE("the Haply driver runs at 500 Hz to 4 kHz", "[device_clock]") {
  const test::HaplyRig standIn;
  for (const double rate : {500.0, 1000.0, 2000.0, 4000.0}) checkFollows("Inverse3", standIn.rig, {rate});
}
#endif

}  // namespace enamel::test_device_clock
