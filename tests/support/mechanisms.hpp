// The shipped devices of every kind, and their workspaces.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "support/devices.hpp"

namespace enamel::test {

struct Shipped {
  std::string file;
  double cube;  ///< half width of a cube about home within its reach, with room for finite differences, m
  double turn;  ///< largest angle about any axis, rad; 0: no rotation

  DeviceParameters parameters() const { return loadDevice(deviceFile(file)); }
  std::shared_ptr<const Mechanism> mechanism() const { return makeMechanism(parameters()); }

  Pose pose(Random& random) const {
    Pose pose;
    pose.position = random.vector(cube);
    if (turn > 0.0) pose.rotation = random.rotation(turn);
    return pose;
  }
  /// Return a twist of up to 0.5 m/s and 3 rad/s.
  Vec6 twist(Random& random) const { return random.vector6(0.5, turn > 0.0 ? 3.0 : 0.0); }
};

std::vector<Shipped> shippedDevices();

JointVector randomJoints(Random& random, int joints, double size);

}  // namespace enamel::test
