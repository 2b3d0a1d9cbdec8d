#include "support/deltas.hpp"

namespace enamel::test {

DeltaParameters desktopDelta() { return loadDelta(deviceFile("delta.toml")); }

DeltaParameters randomDelta(std::uint64_t seed) {
  Random random(seed);
  while (true) {
    DeltaParameters device = desktopDelta();
    device.name = "random delta " + std::to_string(seed);
    device.gravity = 9.81 * random.direction();
    DeltaGeometry& g = device.geometry;
    for (double* length : {&g.a, &g.b, &g.c, &g.d, &g.e, &g.f, &g.r, &g.s}) *length *= random.uniform(0.7, 1.4);
    for (double& phi : g.phi) phi += random.uniform(-0.3, 0.3);
    if (random.uniform(0.0, 1.0) < 0.5) std::swap(g.phi[1], g.phi[2]);  // the other order of the legs
    device.homeDistance *= random.uniform(0.8, 1.2);
    device.upperLink = {random.uniform(0.02, 0.1), random.uniform(-0.02, 0.05), random.uniform(1e-5, 1e-4)};
    device.bar.mass *= random.uniform(0.5, 5.0);
    device.bar.spacing = random.uniform(0.02, 0.05);
    device.platform.mass *= random.uniform(0.3, 2.0);
    device.platform.damping = random.vector(1.0).cwiseAbs();
    device.motor.rotorInertia = random.uniform(0.0, 3e-4);
    device.motor.viscousFriction = random.uniform(0.0, 0.01);
    try {
      const DeltaModel model = makeModel(device);
      bool regular = true;
      for (int corner = 0; corner < 8 && regular; ++corner) {
        const Vec3 position = 0.02 * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        DeltaConfiguration c;
        regular = inverseKinematics(model, position, c) == Status::ok && c.parallel > 0.2;
        for (const DeltaLeg& leg : c.leg) regular = regular && leg.sinElbow > 0.3 && leg.sin3 > 0.3;
      }
      if (regular) return device;
    } catch (const Error&) {
      continue;  // these lengths cannot close; try the next ones
    }
  }
}

std::vector<SomeDelta> someDeltas() {
  return {{desktopDelta(), 0.04},
          {randomDelta(1), 0.02},
          {randomDelta(2), 0.02},
          {randomDelta(3), 0.02},
          {randomDelta(4), 0.02}};
}

}  // namespace enamel::test
