// Devices for the tests: the shipped ones, and random ones. Random ones vary in lengths, elbow signs, asymmetric bases,
// full inertia tensors, friction, damping and tilted gravity. Random numbers come from mt19937_64, whose bits the
// standard defines: a seed has the same meaning everywhere. A compiler may choose the order of two draws in one
// expression. Several numbers are therefore drawn here, in braces or in separate statements.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/device/tau/kinematics.hpp"

namespace enamel::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  Vec3 vector(double size);
  Vec3 direction();
  /// Return 10 to a power between the two.
  double power(double low, double high);
  /// Return a vector of random direction, with a length between the two.
  Vec3 ofLength(double low, double high);
  /// Return a rotation about any axis.
  Mat3 rotation(double largest);
  Vec6 vector6(double linear, double angular);
  /// Return a pose in the paper's workspace: 50 mm cube, +-10 deg about each axis.
  Pose workspacePose(double share = 1.0);

 private:
  std::mt19937_64 engine_;
};

Mat3 rotationAbout(const Vec3& axis, double angle);

std::string deviceFile(const std::string& name);

TauParameters nominal();
TauParameters detailed();

// Return the inertia of a few random point masses, which is always physically possible.
Mat3 randomInertia(Random& random, double mass, double size);

/// Return a random device that is regular near home: the nominal one, varied by about 20 %.
TauParameters randomDevice(std::uint64_t seed);

std::vector<TauParameters> someDevices();

}  // namespace enamel::test
