#include "enamel/device/cartesian/parameters.hpp"

#include <cmath>

#include "core/message.hpp"
#include "core/toml.hpp"
#include "device/inertia.hpp"
#include "device/read.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

void check(const CartesianParameters& device, const Fail& fail) {
  const auto indexed = [](const std::string& key, int i) { return key + "[" + std::to_string(i) + "]"; };
  if (device.axes != 3 && device.axes != 6) fail("axes", "is " + std::to_string(device.axes) + ", must be 3 or 6");
  if (!device.gravity.allFinite()) fail("gravity", "must be finite");
  for (int i = 0; i < 3; ++i) requirePositive(device.halfWidths[i], indexed("half_widths", i), "m", fail);
  requirePositive(device.maxForce, "max_force", "N", fail);
  requirePositive(device.positionStep, "position_step", "m", fail);
  requirePositive(device.mass, "platform.mass", "kg", fail);
  for (int i = 0; i < device.axes; ++i)
    requireNotNegative(device.damping[i], indexed("platform.damping", i), i < 3 ? "N s/m" : "N m s/rad", fail);
  if (device.axes == 3) return;
  requirePositive(device.maxMoment, "max_moment", "N m", fail);
  requirePositive(device.angleStep, "angle_step", "rad", fail);
  checkInertia(device.inertia, "platform.inertia", fail);
  // The motion of turns divides by it.
  const double least = eigenvaluesOf(device.inertia)[0];
  if (!(least > 0.0))
    fail("platform.inertia",
         "has the principal moment " + formatNumber(least) + ", must be greater than 0 kg m^2 for a device of 6 axes");
}

// Refuses a key that only a device of 6 axes has.
void refuseTurn(TomlTable& table, const std::string& key) {
  if (table.has(key)) table.fail(key, "stands beside axes = 3: only a device of 6 axes turns");
}

}  // namespace

CartesianParameters readCartesian(TomlTable& root) {
  CartesianParameters device;
  device.name = root.text("name");
  const std::int64_t axes = root.integer("axes");
  if (axes != 3 && axes != 6) root.fail("axes", "is " + std::to_string(axes) + ", must be 3 or 6");
  device.axes = static_cast<int>(axes);
  if (root.has("gravity")) device.gravity = root.vector3("gravity");
  device.halfWidths = root.vector3("half_widths");
  device.maxForce = root.number("max_force");
  device.positionStep = root.number("position_step");
  TomlTable platform = root.table("platform");
  device.mass = platform.number("mass");
  if (axes == 6) {
    device.maxMoment = root.number("max_moment");
    device.angleStep = root.number("angle_step");
    device.inertia = platform.matrix3("inertia");
    if (platform.has("damping")) device.damping = platform.vector6("damping");
  } else {
    refuseTurn(root, "max_moment");
    refuseTurn(root, "angle_step");
    refuseTurn(platform, "inertia");
    if (platform.has("damping")) device.damping.head<3>() = platform.vector3("damping");
  }
  platform.finish();
  root.finish();

  check(device, [&root](const std::string& key, const std::string& problem) { root.fail(key, problem); });
  return device;
}

CartesianParameters parseCartesian(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  requireKind(root, "cartesian");
  return readCartesian(root);
}

CartesianParameters loadCartesian(const std::string& path) { return parseCartesian(readFile(path), path); }

void checkCartesian(const CartesianParameters& parameters) {
  check(parameters, [&parameters](const std::string& key, const std::string& problem) {
    throw ConfigurationError("device \"" + parameters.name + "\"", 0, key, problem);
  });
}

}  // namespace enamel
