#include "support/devices.hpp"

#include <Eigen/Geometry>

namespace enamel::test {

Vec3 Random::vector(double size) {
  const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
  return {x, y, z};
}

Vec3 Random::direction() {
  Vec3 v = vector(1.0);
  while (!(v.norm() > 0.1 && v.norm() < 1.0)) v = vector(1.0);
  return v.normalized();
}

double Random::power(double low, double high) { return std::pow(10.0, uniform(low, high)); }

Vec3 Random::ofLength(double low, double high) {
  const double length = uniform(low, high);
  return length * direction();
}

Mat3 Random::rotation(double largest) {
  const Vec3 axis = direction();
  return Eigen::AngleAxis<double>(uniform(0.0, largest), axis).toRotationMatrix();
}

Vec6 Random::vector6(double linear, double angular) {
  Vec6 v;
  v.head<3>() = vector(linear);
  v.tail<3>() = vector(angular);
  return v;
}

Pose Random::workspacePose(double share) {
  Pose pose;
  pose.position = vector(0.025 * share);
  pose.rotation = rotationFromEuler(vector(10.0 * M_PI / 180.0 * share));
  return pose;
}

Mat3 rotationAbout(const Vec3& axis, double angle) { return Eigen::AngleAxis<double>(angle, axis).toRotationMatrix(); }

std::string deviceFile(const std::string& name) { return ENAMEL_SOURCE_DIR "/data/devices/" + name; }

TauParameters nominal() { return loadTau(deviceFile("tau-nominal.toml")); }

TauParameters detailed() { return loadTau(deviceFile("tau-detailed.toml")); }

Mat3 randomInertia(Random& random, double mass, double size) {
  Mat3 inertia = Mat3::Zero();
  for (int i = 0; i < 4; ++i) {
    const Vec3 r = random.vector(size);
    inertia += 0.25 * mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  return inertia;
}

TauParameters randomDevice(std::uint64_t seed) {
  Random random(seed);
  while (true) {
    TauParameters device = nominal();
    device.name = "random " + std::to_string(seed);
    device.gravity = 9.81 * random.direction();
    for (auto& chain : device.chain) {
      chain.base += random.vector(0.02);
      chain.platform += random.vector(0.006);
      chain.elbow = random.uniform(0.0, 1.0) < 0.5 ? 1 : -1;
      for (LinkParameters* link : {&chain.link1, &chain.link2}) {
        link->length *= random.uniform(0.85, 1.25);
        link->mass *= random.uniform(0.5, 2.0);
        link->com = Vec3(0.0, 0.0, 0.5 * link->length) + random.vector(0.01);
        link->inertia = randomInertia(random, link->mass, 0.3 * link->length);
      }
    }
    device.platform.mass *= random.uniform(0.5, 2.0);
    device.platform.com += random.vector(0.02);
    device.platform.inertia = randomInertia(random, device.platform.mass, 0.03);
    for (int i = 0; i < 6; ++i) device.platform.damping[i] = random.uniform(0.0, i < 3 ? 2.0 : 0.01);
    device.motor.rotorInertia = random.uniform(0.0, 3e-4);
    device.motor.viscousFriction = random.uniform(0.0, 0.01);
    try {
      const TauModel model = makeModel(device);
      bool regular = true;
      for (int corner = 0; corner < 8; ++corner) {  // corners of a cube of 20 mm
        const Vec3 position = 0.01 * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        TauConfiguration c;
        regular = regular && inverseKinematics(model, Pose{position, Mat3::Identity()}, c) == Status::ok;
        if (!regular) break;
        const SingularityMeasures m = singularity(model, c);
        regular = m.elbow > 0.3 && m.yaw > 0.15 && m.parallel > 0.08;
      }
      if (regular) return device;
    } catch (const Error&) {
      continue;  // these lengths cannot close; try the next ones
    }
  }
}

std::vector<TauParameters> someDevices() {
  return {nominal(), detailed(), randomDevice(1), randomDevice(2), randomDevice(3), randomDevice(4)};
}

}  // namespace enamel::test
