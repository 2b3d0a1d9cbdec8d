// The kinematics of your device, place by place: extent of the workspace, accuracy from pose to joints and back,
// effective mass of the tool, and largest force of the motors.
//
//   kinematics tau-nominal.toml [half width of the cube, mm]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: kinematics DEVICE.toml [half width of the cube, mm]\n"), 2;
  try {
    const auto device = makeMechanism(loadDevice(argv[1]));
    const double reach = 1e-3 * (argc > 2 ? std::atof(argv[2]) : 25.0);
    std::printf("%s: %d joints, at most %.3g, measured to %.2g (N m and rad, or N and m)\n", device->name().c_str(),
                device->joints(), device->limits().effort.maxCoeff(), device->limits().encoderStep.maxCoeff());
    std::printf("    x     y     z [mm]   mass along x     y     z [kg]   force along x     y     z [N]\n");
    double worst = 0.0;
    int outside = 0;
    Kinematics solved = device->home();  // start of the iteration: the last tick's solution
    for (int i = 0; i < 27; ++i) {
      Pose pose;
      pose.position = reach * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      // From pose to joints as in a simulation, and back as in a tick.
      Kinematics wanted;
      if (device->reach(pose, Vec6::Zero(), true, wanted) != Status::ok) {
        ++outside;
        continue;
      }
      if (device->track(wanted.q, JointVector::Zero(device->joints()), true, solved) != Status::ok) return 1;
      worst = std::max(worst, (solved.pose.position - pose.position).norm());
      std::printf("%5.0f %5.0f %5.0f      ", 1e3 * pose.position.x(), 1e3 * pose.position.y(), 1e3 * pose.position.z());
      const Vec3& there = solved.pose.position;
      for (int k = 0; k < 3; ++k)  // effective mass of the tool, with joints and motors
        std::printf("%6.3f", effectiveMass(solved, there, Vec3::Unit(k)));
      std::printf("          ");
      for (int k = 0; k < 3; ++k)  // the weaker of the two directions
        std::printf("%6.1f", std::min(largestForce(solved, device->limits().effort, there, Vec3::Unit(k)),
                                      largestForce(solved, device->limits().effort, there, -Vec3::Unit(k))));
      std::printf("\n");
    }
    std::printf("there and back: %.1e m at most; %d of 27 places out of reach\n", worst, outside);
    return worst < 1e-9 && outside < 27 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "kinematics: %s\n", error.what());
    return 1;
  }
}
