#include "enamel/device/delta/parameters.hpp"

#include <cmath>

#include "core/message.hpp"
#include "core/toml.hpp"
#include "device/read.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

void requireFinite(double value, const std::string& key, const std::string& unit, const Fail& fail) {
  if (!std::isfinite(value)) fail(key, "is " + formatNumber(value) + " " + unit + ", must be finite");
}

// At home the TCP is the origin of W, and every leg must reach its platform joint.
void checkLegs(const DeltaParameters& device, const Fail& fail) {
  const DeltaGeometry& g = device.geometry;
  const double lateral = g.f - g.s, radial = g.c - g.r;
  if (!(std::abs(lateral) < g.b))
    fail("geometry.b", "is " + formatNumber(g.b) + ", must be greater than the offset |f - s| = " +
                           formatNumber(std::abs(lateral)) + " m that the bars span across a leg at home");
  const double lower = g.d + g.e + std::sqrt(g.b * g.b - lateral * lateral);
  const double distance = std::hypot(radial, device.homeDistance);
  const double shortest = std::abs(g.a - lower), longest = g.a + lower, margin = 1e-6 * longest;
  if (!(distance > shortest + margin && distance < longest - margin))
    fail("home_distance", "is " + formatNumber(device.homeDistance) + ", the platform joints are then " +
                              formatNumber(distance) + " m from the base joints at home: the legs close between " +
                              formatNumber(shortest) + " and " + formatNumber(longest) + " m");
}

void check(const DeltaParameters& device, const Fail& fail) {
  if (!device.gravity.allFinite()) fail("gravity", "must be finite");
  requirePositive(device.homeDistance, "home_distance", "m", fail);
  const DeltaGeometry& g = device.geometry;
  requirePositive(g.a, "geometry.a", "m", fail);
  requirePositive(g.b, "geometry.b", "m", fail);
  requireNotNegative(g.d, "geometry.d", "m", fail);
  requireNotNegative(g.e, "geometry.e", "m", fail);
  requireFinite(g.c, "geometry.c", "m", fail);
  requireFinite(g.f, "geometry.f", "m", fail);
  requireFinite(g.r, "geometry.r", "m", fail);
  requireFinite(g.s, "geometry.s", "m", fail);
  for (const double phi : g.phi) requireFinite(phi, "geometry.phi_deg", "deg", fail);

  requirePositive(device.upperLink.mass, "upper_link.mass", "kg", fail);
  requireFinite(device.upperLink.com, "upper_link.com", "m", fail);
  requireNotNegative(device.upperLink.inertia, "upper_link.inertia", "kg m^2", fail);
  requirePositive(device.bar.mass, "bar.mass", "kg", fail);
  requireNotNegative(device.bar.spacing, "bar.spacing", "m", fail);
  requirePositive(device.platform.mass, "platform.mass", "kg", fail);
  for (int i = 0; i < 3; ++i)
    requireNotNegative(device.platform.damping[i], "platform.damping[" + std::to_string(i) + "]", "N s/m", fail);
  checkMotor(device.motor, fail);
  checkImperfections(device.imperfections, {"N m", "rad", "motor.rotor_inertia", device.motor.rotorInertia}, fail);
  checkLegs(device, fail);
}

}  // namespace

DeltaParameters readDelta(TomlTable& root) {
  DeltaParameters device;
  device.name = root.text("name");
  device.gravity = root.vector3("gravity");
  device.homeDistance = root.number("home_distance");

  TomlTable geometry = root.table("geometry");
  DeltaGeometry& g = device.geometry;
  g.a = geometry.number("a");
  g.b = geometry.number("b");
  g.c = geometry.number("c");
  g.d = geometry.number("d");
  g.e = geometry.number("e");
  g.f = geometry.number("f");
  g.r = geometry.number("r");
  g.s = geometry.number("s");
  const Vec3 phi_deg = geometry.vector3("phi_deg");
  for (int i = 0; i < 3; ++i) g.phi[i] = phi_deg[i] * (M_PI / 180.0);
  geometry.finish();

  TomlTable upper = root.table("upper_link");
  device.upperLink.mass = upper.number("mass");
  device.upperLink.com = upper.number("com");
  device.upperLink.inertia = upper.number("inertia");
  upper.finish();

  TomlTable bar = root.table("bar");
  device.bar.mass = bar.number("mass");
  device.bar.spacing = bar.number("spacing");
  bar.finish();

  TomlTable platform = root.table("platform");
  device.platform.mass = platform.number("mass");
  if (platform.has("damping")) device.platform.damping = platform.vector3("damping");
  platform.finish();

  device.motor = readMotor(root);
  device.imperfections = readImperfections(root);
  root.finish();

  check(device, [&root](const std::string& key, const std::string& problem) { root.fail(key, problem); });
  return device;
}

DeltaParameters parseDelta(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  requireKind(root, "delta");
  return readDelta(root);
}

DeltaParameters loadDelta(const std::string& path) { return parseDelta(readFile(path), path); }

void checkDelta(const DeltaParameters& parameters) {
  check(parameters, [&parameters](const std::string& key, const std::string& problem) {
    throw ConfigurationError("device \"" + parameters.name + "\"", 0, key, problem);
  });
}

}  // namespace enamel
