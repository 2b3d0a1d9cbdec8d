#include "support/mechanisms.hpp"

namespace enamel::test {

std::vector<Shipped> shippedDevices() {
  const double ten = 10.0 * M_PI / 180.0;
  return {{"tau-nominal.toml", 0.025, ten},
          {"tau-detailed.toml", 0.025, ten},
          {"delta.toml", 0.040, 0.0},
          {"cartesian-3.toml", 0.034, 0.0},
          {"cartesian-6.toml", 0.064, 2.4}};
}

JointVector randomJoints(Random& random, int joints, double size) {
  JointVector q(joints);
  for (int i = 0; i < joints; ++i) q[i] = random.uniform(-size, size);
  return q;
}

}  // namespace enamel::test
