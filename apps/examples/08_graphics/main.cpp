// Graphics beside the loop: the haptic thread runs at 1 kHz, this thread draws 30 pictures a second, and neither waits
// for the other. refresh() and latest() give the loop's newest tick. A TripleBuffer sends the mouse to the loop's
// thread.
//
//   graphics tau-nominal.toml molar-scene.toml [seconds]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <enamel/collision/scene_file.hpp>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/runtime/haptic_loop.hpp>
#include <enamel/sim/hand.hpp>
#include <enamel/sim/simulated_device.hpp>
#include <string>
#include <thread>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: graphics DEVICE.toml SCENE.toml [seconds]\n"), 2;
  try {
    const double seconds = argc > 3 ? std::atof(argv[3]) : 2.0;
    const auto mechanism = makeMechanism(idealOf(loadDevice(argv[1])));
    const SceneFile file = loadScene(argv[2]);

    // A simulated device; a spring pulls it to the mouse. Your driver is another HapticDevice.
    TripleBuffer<Vec3> mouse;  // this thread writes, the loop's thread reads
    mouse.next() = file.start;
    mouse.publish();
    VirtualDeviceSetup setup;
    setup.start.position = file.start;
    SimulatedDevice device(
        *mechanism, setup,
        [&](double, const Pose& pose, const Vec6& twist) {
          mouse.refresh();
          Vec6 wrench;
          wrench << 300.0 * (mouse.latest() - pose.position) - 6.0 * twist.head<3>(),
              holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
          return wrench;
        },
        true);  // in real time

    PositionControlRenderer servo(positionControlFor(*mechanism, 1e-3, 0, 0));
    HapticTick haptics(*mechanism, file.scene, file.tool, servo, 1e-3, setup.start);
    HapticLoop loop(device, haptics);  // the thread runs from here to the end of this function

    double most = 0.0;
    int pictures = 0, faults = 0;
    // Until the tooth has been touched, a busy machine gets up to 100 times as long.
    const auto goesOn = [&] { return pictures < 30.0 * seconds * (most > 0.0 ? 1.0 : 100.0); };
    for (auto next = std::chrono::steady_clock::now(); goesOn(); ++pictures) {
      next += std::chrono::microseconds(33333);
      std::this_thread::sleep_until(next);  // a real program waits for the display here
      mouse.next() = file.start - Vec3(0.0, 0.0, 0.014 * std::pow(std::sin(0.1 * pictures), 2));
      mouse.publish();
      (void)loop.refresh();
      const LoopTick& tick = loop.latest();  // whole and of one instant, and nobody writes to it
      most = std::max(most, tick.normalForce);
      if (isFault(tick.reason)) ++faults, (void)loop.reset();  // on a busy machine: a late tick; a real program asks
      const double z = 1e3 * tick.pose.position.z();
      std::string line(56, ' ');
      line[static_cast<std::size_t>(std::clamp(std::lround(20.0 + 4.0 * z), 0L, 55L))] = 'o';
      std::printf("tick %5llu  %s %6.2f mm %5.2f N %s\n", static_cast<unsigned long long>(tick.number), line.c_str(), z,
                  tick.normalForce, tick.reason == GuardReason::none ? "" : toString(tick.reason));
    }
    std::printf("%d pictures during %llu ticks; %llu ticks were late; %d faults; up to %.2f N\n", pictures,
                static_cast<unsigned long long>(loop.timing().periods.load()),
                static_cast<unsigned long long>(loop.timing().missed.load()), faults, most);
    return most > 0.0 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "graphics: %s\n", error.what());
    return 1;
  }
}
