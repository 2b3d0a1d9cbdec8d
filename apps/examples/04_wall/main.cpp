// A wall in your own loop: measure, compute a tick, actuate. Ten lines of physics take the place of your driver: a hand
// presses a mass against the wall, slides it along the wall and releases it.
//
//   wall cartesian-3.toml
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/render/tick.hpp>
#include <string>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: wall DEVICE.toml (of kind cartesian, 3 axes)\n"), 2;
  try {
    constexpr double kPeriod = 1e-3;  // s
    const auto device = makeMechanism(idealOf(loadDevice(argv[1])));
    if (device->joints() != 3) throw Error("this example moves a device of 3 axes");
    Scene scene;
    Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());  // a point of the wall (m), outward normal
    wall.material.friction = wall.material.slidingFriction = 0.2;
    scene.add(wall);
    Tool tool;  // a ball of 1 mm; the default is a point
    tool.parts[0].radius = 0.5e-3;
    PositionControlRenderer servo(positionControlFor(*device, kPeriod, 0, 0));
    Vec3 position(0.0, 0.0, 0.003), speed = Vec3::Zero();  // m, m/s
    HapticTick tick(*device, scene, tool, servo, kPeriod, Pose{position, Mat3::Identity()});

    double deepest = 0.0, most = 0.0;
    Measurement measurement;
    Command command;
    for (int i = 0; i < 2000; ++i) {  // 2 s
      measurement.time = (i + 1) * kPeriod;
      measurement.q = position;  // of a Cartesian device the joints are x, y and z
      measurement.rates = speed;
      const Status status = tick(measurement, command);  // always send `command`, it is safe at every status
      if (status != Status::ok) throw Error(std::string("the guard stopped: ") + toString(tick.frame().reason));

      // Replace this by your device: 45 g, moved by hand and motors in steps of 0.1 ms.
      const double pressed = 0.002 * std::sin(1e-3 * M_PI * i), along = 0.01 * std::sin(4e-3 * M_PI * i);  // m
      for (int step = 0; step < 10; ++step) {
        const Vec3 hand = 600.0 * (Vec3(along, 0.0, 0.0015 - 2.0 * pressed) - position) - 8.0 * speed;
        speed += 1e-4 * (hand + command.effort) / 0.045;
        position += 1e-4 * speed;
      }

      const double gap = tick.frame().contacts.count > 0 ? tick.frame().contacts.contacts[0].gap : kContactMargin;
      const double force = tick.frame().output.normalForce;
      deepest = std::max(deepest, -gap);
      most = std::max(most, force);
      if (i % 50 == 49)
        std::printf("%.2f s  x %6.2f mm  gap %7.4f mm  wall %5.2f N  along %5.2f N  |%s\n", measurement.time,
                    1e3 * position.x(), 1e3 * gap, force, command.effort.head<2>().norm(),
                    std::string(static_cast<std::size_t>(std::lround(10.0 * force)), '#').c_str());
    }
    std::printf("pressed with up to %.2f N, the tool went %.3f mm into the wall\n", most, 1e3 * deepest);
    return most > 0.5 && deepest < 0.2e-3 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "wall: %s\n", error.what());
    return 1;
  }
}
