#include "enamel/device/parameters.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/toml.hpp"

namespace enamel {
namespace {

using Fail = std::function<void(const std::string& key, const std::string& problem)>;

std::string formatVector(const Vec3& v) {
  return "[" + formatNumber(v.x()) + ", " + formatNumber(v.y()) + ", " + formatNumber(v.z()) + "]";
}

void requirePositive(double value, const std::string& key, const std::string& unit, const Fail& fail) {
  if (!(value > 0.0 && std::isfinite(value)))
    fail(key, "is " + formatNumber(value) + ", must be greater than 0 " + unit + " and finite");
}

void requireNotNegative(double value, const std::string& key, const std::string& unit, const Fail& fail) {
  if (!(value >= 0.0 && std::isfinite(value)))
    fail(key, "is " + formatNumber(value) + ", must be at least 0 " + unit + " and finite");
}

// A tensor of inertia about the centre of mass is symmetric, has no negative principal moment, and none is
// larger than the sum of the other two. The tolerance covers decimal rounding in a file.
void checkInertia(const Mat3& inertia, const std::string& key, const Fail& fail) {
  if (!inertia.allFinite()) return fail(key, "must be finite");
  const double scale = inertia.cwiseAbs().maxCoeff();
  const double tolerance = 1e-9 * scale;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (std::abs(inertia(i, j) - inertia(j, i)) > tolerance)
      fail(key, "is not symmetric: element (" + std::to_string(i) + "," + std::to_string(j) + ") is " +
                    formatNumber(inertia(i, j)) + " and (" + std::to_string(j) + "," + std::to_string(i) + ") is " +
                    formatNumber(inertia(j, i)) + " kg m^2");
  }
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[0] < -tolerance)
    fail(key, "has the principal moment " + formatNumber(moments[0]) + ", must be at least 0 kg m^2");
  if (moments[2] > moments[0] + moments[1] + tolerance)
    fail(key, "is that of no body: the largest principal moment " + formatNumber(moments[2]) +
                  " exceeds the sum of the others, " + formatNumber(moments[0] + moments[1]) + " kg m^2");
}

void checkLink(const LinkParameters& link, const std::string& key, const Fail& fail) {
  requirePositive(link.length, key + ".length", "m", fail);
  requirePositive(link.mass, key + ".mass", "kg", fail);
  if (!link.com.allFinite()) fail(key + ".com", "must be finite");
  checkInertia(link.inertia, key + ".inertia", fail);
}

// At home P equals W: the spherical joint stands at `platform` in W and the two links must reach it.
void checkClosure(const ChainParameters& chain, const std::string& key, const Fail& fail) {
  const Vec3 reach = chain.platform - chain.base;
  const double distance = reach.norm();
  const double longest = chain.link1.length + chain.link2.length;
  const double shortest = std::abs(chain.link1.length - chain.link2.length);
  const double margin = 1e-6 * longest;
  if (!(distance < longest - margin && distance > shortest + margin))
    fail(key + ".platform", "is " + formatVector(chain.platform) + " m, " + formatNumber(distance) +
                                " m from the base at home: the links of this chain close between " +
                                formatNumber(shortest) + " and " + formatNumber(longest) + " m");
  const double radius = std::hypot(reach.x(), reach.z());
  if (!(radius > margin))
    fail(key + ".platform", "is " + formatNumber(radius) +
                                " m from the chain's yaw axis at home, must be greater than " + formatNumber(margin) +
                                " m: the yaw angle is undefined there");
}

void check(const DeviceParameters& device, const Fail& fail) {
  if (!device.gravity.allFinite()) fail("gravity", "must be finite");
  for (std::size_t i = 0; i < device.chain.size(); ++i) {
    const ChainParameters& chain = device.chain[i];
    const std::string key = "chain[" + std::to_string(i) + "]";
    if (!chain.base.allFinite()) fail(key + ".base", "must be finite");
    if (!chain.platform.allFinite()) fail(key + ".platform", "must be finite");
    if (chain.elbow != 1 && chain.elbow != -1)
      fail(key + ".elbow", "is " + std::to_string(chain.elbow) + ", must be 1 or -1");
    checkLink(chain.link1, key + ".link1", fail);
    checkLink(chain.link2, key + ".link2", fail);
    checkClosure(chain, key, fail);
  }

  const Vec3 side1 = device.chain[1].platform - device.chain[0].platform;
  const Vec3 side2 = device.chain[2].platform - device.chain[0].platform;
  const double size = std::max(side1.norm(), side2.norm());
  const double area = side1.cross(side2).norm();
  if (!(area > 1e-6 * size * size))
    fail("chain[2].platform", "is " + formatVector(device.chain[2].platform) +
                                  " m: the three platform points lie on one line, they must span a plane");

  requirePositive(device.platform.mass, "platform.mass", "kg", fail);
  if (!device.platform.com.allFinite()) fail("platform.com", "must be finite");
  checkInertia(device.platform.inertia, "platform.inertia", fail);
  for (int i = 0; i < 6; ++i)
    requireNotNegative(device.platform.damping[i], "platform.damping[" + std::to_string(i) + "]",
                       i < 3 ? "N s/m" : "N m s/rad", fail);

  requirePositive(device.motor.maxTorque, "motor.max_torque", "N m", fail);
  requireNotNegative(device.motor.rotorInertia, "motor.rotor_inertia", "kg m^2", fail);
  requirePositive(device.motor.encoderCounts, "motor.encoder_counts", "per revolution", fail);
  requireNotNegative(device.motor.viscousFriction, "motor.viscous_friction", "N m s/rad", fail);
}

LinkParameters readLink(TomlTable& chain, const char* key) {
  TomlTable table = chain.table(key);
  LinkParameters link;
  link.length = table.number("length");
  link.mass = table.number("mass");
  if (table.has("radius")) {
    if (table.has("com") || table.has("inertia"))
      table.fail("radius", "stands beside com or inertia: a link has either a radius (uniform rod) or com and inertia");
    const double radius = table.number("radius");
    if (!(radius > 0.0)) table.fail("radius", "is " + formatNumber(radius) + ", must be greater than 0 m");
    link = uniformRod(link.length, link.mass, radius);
  } else {
    link.com = table.vector3("com");
    link.inertia = table.matrix3("inertia");
  }
  table.finish();
  return link;
}

}  // namespace

LinkParameters uniformRod(double length, double mass, double radius) noexcept {
  LinkParameters link;
  link.length = length;
  link.mass = mass;
  link.com = {0.0, 0.0, 0.5 * length};
  const double across = mass * (3.0 * radius * radius + length * length) / 12.0;
  link.inertia = Vec3(across, across, 0.5 * mass * radius * radius).asDiagonal();
  return link;
}

DeviceParameters parseDevice(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  DeviceParameters device;
  device.name = root.text("name");
  device.gravity = root.vector3("gravity");

  std::vector<TomlTable> chains = root.tables("chain");
  if (chains.size() != device.chain.size())
    root.fail("chain", "occurs " + std::to_string(chains.size()) + " times, a TAU has exactly 3 chains");
  for (std::size_t i = 0; i < chains.size(); ++i) {
    device.chain[i].base = chains[i].vector3("base");
    device.chain[i].platform = chains[i].vector3("platform");
    device.chain[i].link1 = readLink(chains[i], "link1");
    device.chain[i].link2 = readLink(chains[i], "link2");
    const std::int64_t elbow = chains[i].integer("elbow");
    if (elbow != 1 && elbow != -1) chains[i].fail("elbow", "is " + std::to_string(elbow) + ", must be 1 or -1");
    device.chain[i].elbow = static_cast<int>(elbow);
    chains[i].finish();
  }

  TomlTable platform = root.table("platform");
  device.platform.mass = platform.number("mass");
  device.platform.com = platform.vector3("com");
  device.platform.inertia = platform.matrix3("inertia");
  if (platform.has("damping")) device.platform.damping = platform.vector6("damping");
  platform.finish();

  TomlTable motor = root.table("motor");
  device.motor.maxTorque = motor.number("max_torque");
  device.motor.rotorInertia = motor.number("rotor_inertia");
  device.motor.encoderCounts = motor.number("encoder_counts");
  if (motor.has("viscous_friction")) device.motor.viscousFriction = motor.number("viscous_friction");
  motor.finish();
  root.finish();

  check(device, [&root](const std::string& key, const std::string& problem) { root.fail(key, problem); });
  return device;
}

DeviceParameters loadDevice(const std::string& path) { return parseDevice(readTextFile(path), path); }

void checkDevice(const DeviceParameters& parameters) {
  check(parameters, [&parameters](const std::string& key, const std::string& problem) {
    throw ConfigurationError("device \"" + parameters.name + "\"", 0, key, problem);
  });
}

}  // namespace enamel
