// Devices for the tests: the shipped ones, and random ones with other lengths, elbow signs, asymmetric bases, full
// inertia tensors, friction, damping and tilted gravity. Random numbers are made here from mt19937_64 (whose bits
// the standard fixes), so that a seed means the same everywhere. In one expression a compiler draws two numbers in the
// order it likes: where several are needed, they are drawn here, in braces or in one statement each.
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
  /// 10 to a power between the two.
  double power(double low, double high);
  /// In any direction, of a length between the two.
  Vec3 ofLength(double low, double high);
  /// About any axis.
  Mat3 rotation(double largest);
  Vec6 vector6(double linear, double angular);
  /// A pose of the paper's workspace: 50 mm cube, +-10 deg about each axis.
  Pose workspacePose(double share = 1.0);

 private:
  std::mt19937_64 engine_;
};

Mat3 rotationAbout(const Vec3& axis, double angle);

std::string deviceFile(const std::string& name);

TauParameters nominal();
TauParameters detailed();

// The inertia of a few random point masses: any such tensor is that of a body.
Mat3 randomInertia(Random& random, double mass, double size);

/// A random device that is regular in a neighbourhood of home: varied from the nominal one by about 20 %.
TauParameters randomDevice(std::uint64_t seed);

std::vector<TauParameters> someDevices();

}  // namespace enamel::test
