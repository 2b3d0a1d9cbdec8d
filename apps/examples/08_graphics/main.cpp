// Graphics beside the loop: the session's thread runs at 1 kHz, this thread draws 30 pictures a second, and neither
// waits for the other. snapshot() gives the newest tick. A TripleBuffer sends the mouse to the loop's thread.
//
//   graphics tau-nominal.toml molar-scene.toml [seconds]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <enamel/core/error.hpp>
#include <enamel/runtime/triple_buffer.hpp>
#include <enamel/session/session.hpp>
#include <enamel/sim/hand.hpp>
#include <string>
#include <thread>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: graphics DEVICE.toml SCENE.toml [seconds]\n"), 2;
  try {
    TripleBuffer<double> mouse;  // how far it is pulled down, m: this thread writes, the loop's thread reads
    SessionDef def;
    def.device = argv[1];
    def.scene = argv[2];
    Session session(def);

    const auto hand = [&, start = session.start()](double, const Pose& pose, const Vec6& twist) {
      mouse.refresh();
      const Vec3 goal = start.position - mouse.latest() * Vec3::UnitZ();
      Vec6 wrench;
      wrench << 300.0 * (goal - pose.position) - 6.0 * twist.head<3>(),
          holdingMoment(pose.rotation, start.rotation, twist.tail<3>());
      return wrench;
    };
    session.start(makeVirtualDevice(session, hand));  // your driver is another HapticDevice

    const int wanted = static_cast<int>(30.0 * (argc > 3 ? std::atof(argv[3]) : 2.0));
    double most = 0.0;
    int pictures = 0, faults = 0;
    // Until the tooth has been touched, a busy machine gets up to 100 times as long.
    for (; pictures < (most > 0.0 ? wanted : 100 * wanted); ++pictures) {
      std::this_thread::sleep_for(std::chrono::milliseconds(33));  // a real program waits for the display here
      mouse.next() = 0.014 * std::pow(std::sin(0.1 * pictures), 2);
      mouse.publish();
      const Snapshot now = session.snapshot();  // whole and of one instant
      most = std::max(most, now.tick.normalForce);
      const double z = 1e3 * now.tick.pose.position.z();
      std::string line(56, ' ');
      line[static_cast<std::size_t>(std::clamp(std::lround(20.0 + 4.0 * z), 0L, 55L))] = 'o';
      std::printf("tick %5llu  %s %6.2f mm %5.2f N %s\n", static_cast<unsigned long long>(now.tick.number),
                  line.c_str(), z, now.tick.normalForce, now.fault == GuardReason::none ? "" : toString(now.fault));
      if (now.fault != GuardReason::none) ++faults, session.reset();  // a real program asks the person first
    }
    std::printf("%d pictures; %llu ticks were late; %d faults; up to %.2f N\n", pictures,
                static_cast<unsigned long long>(session.snapshot().missed), faults, most);
    return most > 0.0 ? 0 : 1;
  } catch (const Error& error) {
    return std::fprintf(stderr, "graphics: %s\n", error.what()), 1;
  }
}
