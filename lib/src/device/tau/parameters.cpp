#include "enamel/device/tau/parameters.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/message.hpp"
#include "core/toml.hpp"
#include "device/read.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

void checkLink(const LinkParameters& link, const std::string& key, const Fail& fail) {
  requirePositive(link.length, key + ".length", "m", fail);
  requirePositive(link.mass, key + ".mass", "kg", fail);
  if (!link.com.allFinite()) fail(key + ".com", "must be finite");
  checkInertia(link.inertia, key + ".inertia", fail);
}

// At home P equals W: the spherical joint is at `platform` in W, and the two links must reach it.
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

void check(const TauParameters& device, const Fail& fail) {
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

  checkPlatform(device.platform, fail);
  checkMotor(device.motor, fail);
  checkImperfections(device.imperfections, {"N m", "rad", "motor.rotor_inertia", device.motor.rotorInertia}, fail);
}

LinkParameters readLink(TomlTable& chain, const char* key) {
  TomlTable table = chain.table(key);
  LinkParameters link;
  link.length = table.number("length");
  link.mass = table.number("mass");
  if (table.has("radius")) {
    if (table.has("com") || table.has("inertia"))
      table.fail("radius",
                 "is given together with com or inertia: give either radius (a uniform rod) or com and inertia");
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

TauParameters readTau(TomlTable& root) {
  TauParameters device;
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

  device.platform = readPlatform(root);
  device.motor = readMotor(root);
  device.imperfections = readImperfections(root);
  root.finish();

  check(device, [&root](const std::string& key, const std::string& problem) { root.fail(key, problem); });
  return device;
}

TauParameters parseTau(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  requireKind(root, "tau");
  return readTau(root);
}

TauParameters loadTau(const std::string& path) { return parseTau(readFile(path), path); }

void checkTau(const TauParameters& parameters) {
  check(parameters, [&parameters](const std::string& key, const std::string& problem) {
    throw ConfigurationError("device \"" + parameters.name + "\"", 0, key, problem);
  });
}

}  // namespace enamel
