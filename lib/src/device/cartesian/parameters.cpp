#include "enamel/device/cartesian/parameters.hpp"

#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "core/toml.hpp"
#include "device/inertia.hpp"
#include "device/read.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr int kMostMasses = 64;  // points of a table along an axis

// Whether a rotational axis has a motor.
bool turns(const CartesianParameters& device) {
  return device.axes == 6 && (device.driven[3] || device.driven[4] || device.driven[5]);
}

void checkMass(const CartesianParameters& device, const Fail& fail) {
  const MassTable& table = device.massTable;
  if (table.isEmpty()) return requirePositive(device.mass, "platform.mass", "kg", fail);
  std::size_t points = 1;
  for (const int count : table.counts) {
    if (count < 2 || count > kMostMasses)
      fail("platform.mass_counts",
           "has " + std::to_string(count) + " points along an axis, must be in 2 to " + std::to_string(kMostMasses));
    points *= static_cast<std::size_t>(count);
  }
  if (table.mass.size() != points)
    fail("platform.mass_table", "has " + std::to_string(table.mass.size()) + " masses, must have the " +
                                    std::to_string(points) + " of mass_counts");
  for (const double mass : table.mass) requirePositive(mass, "platform.mass_table", "kg", fail);
}

void checkDrives(const CartesianParameters& device, const Fail& fail) {
  const Imperfections& e = device.imperfections;
  requireNotNegative(device.rotorMass, "rotor_mass", "kg", fail);
  double least = device.mass;
  if (!device.massTable.isEmpty())
    least = *std::min_element(device.massTable.mass.begin(), device.massTable.mass.end());
  if (!(device.rotorMass < least))
    fail("rotor_mass", "is " + formatNumber(device.rotorMass) + ", must be less than the apparent mass, " +
                           formatNumber(least) + " kg");
  checkImperfections(e, {"N", "m", "rotor_mass", device.rotorMass}, fail);
  if (e.lengthError > 0.0) fail("imperfections.length_error", "is not allowed: a Cartesian device has no lengths");
  if (e.cableStiffness > 0.0 && !(device.axes == 3 && device.driven[0] && device.driven[1] && device.driven[2]))
    fail("imperfections.cable_stiffness", "needs axes = 3 with a motor on each of them");
  if (e.encoderOffset > 0.0 && device.axes != 3) fail("imperfections.encoder_offset", "needs axes = 3: it is in m");
  if (turns(device) && e.torqueStep + e.cogging + e.coulombFriction > 0.0)
    fail("imperfections",
         "has a torque_step, cogging or coulomb_friction in N, which is not allowed if a rotation has a motor");
}

void check(const CartesianParameters& device, const Fail& fail) {
  const auto indexed = [](const std::string& key, int i) { return key + "[" + std::to_string(i) + "]"; };
  if (device.axes != 3 && device.axes != 6) fail("axes", "is " + std::to_string(device.axes) + ", must be 3 or 6");
  if (!device.gravity.allFinite()) fail("gravity", "must be finite");
  for (int i = 0; i < 3; ++i) requirePositive(device.halfWidths[i], indexed("half_widths", i), "m", fail);
  requirePositive(device.maxForce, "max_force", "N", fail);
  requirePositive(device.positionStep, "position_step", "m", fail);
  if (std::none_of(device.driven.begin(), device.driven.begin() + device.axes, [](bool driven) { return driven; }))
    fail("driven", "is 0 for every axis, at least one must be 1 (with a motor)");
  checkMass(device, fail);
  checkDrives(device, fail);
  for (int i = 0; i < device.axes; ++i)
    requireNotNegative(device.damping[i], indexed("platform.damping", i), i < 3 ? "N s/m" : "N m s/rad", fail);
  if (device.axes == 3) return;
  if (turns(device)) requirePositive(device.maxMoment, "max_moment", "N m", fail);
  requirePositive(device.angleStep, "angle_step", "rad", fail);
  checkInertia(device.inertia, "platform.inertia", fail);
  // The equation of motion divides by the principal moments.
  const double least = eigenvaluesOf(device.inertia)[0];
  if (!(least > 0.0))
    fail("platform.inertia",
         "has the principal moment " + formatNumber(least) + ", must be greater than 0 kg m^2 for a device of 6 axes");
}

// Rejects a key that only a device of 6 axes has.
void refuseTurn(TomlTable& table, const std::string& key) {
  if (table.has(key)) table.fail(key, "is not allowed with axes = 3: only a device of 6 axes turns");
}

// One number per axis: 1 with a motor, 0 without.
void readDriven(TomlTable& root, CartesianParameters& device) {
  const std::vector<double> flags = root.numbers("driven");
  if (flags.size() != static_cast<std::size_t>(device.axes))
    root.fail("driven", "has " + std::to_string(flags.size()) + " numbers, must have one for each of the " +
                            std::to_string(device.axes) + " axes");
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0.0 && flags[i] != 1.0)
      root.fail("driven",
                "has " + formatNumber(flags[i]) + ", must be 1 (the axis has a motor) or 0 (it is only sensed)");
    device.driven[i] = flags[i] == 1.0;
  }
}

void readMass(TomlTable& platform, CartesianParameters& device) {
  if (!platform.has("mass_table")) {
    if (!platform.has("mass")) platform.fail("mass", "is missing: give mass, or mass_table with mass_counts");
    device.mass = platform.number("mass");
    return;
  }
  device.massTable.mass = platform.numbers("mass_table");
  const std::vector<double> counts = platform.numbers("mass_counts");
  if (counts.size() != 3) platform.fail("mass_counts", "must be three whole numbers: points along x, y, z");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(counts[i] >= 2.0 && counts[i] <= kMostMasses && counts[i] == std::floor(counts[i])))
      platform.fail("mass_counts", "must be whole numbers in 2 to " + std::to_string(kMostMasses));
    device.massTable.counts[i] = static_cast<int>(counts[i]);
  }
  if (platform.has("mass")) platform.fail("mass", "is given together with mass_table: give one of them");
}

}  // namespace

double MassTable::at(const Vec3& position, const Vec3& halfWidths, Vec3& gradient) const noexcept {
  // Cell, and position inside it, along each axis.
  std::array<int, 3> cell;
  Vec3 place, perMetre;
  for (int i = 0; i < 3; ++i) {
    const int last = counts[static_cast<std::size_t>(i)] - 1;
    perMetre[i] = last / (2.0 * halfWidths[i]);
    const double at = std::clamp((position[i] + halfWidths[i]) * perMetre[i], 0.0, static_cast<double>(last));
    cell[static_cast<std::size_t>(i)] = std::min(static_cast<int>(at), last - 1);
    place[i] = at - cell[static_cast<std::size_t>(i)];
  }
  double sum = 0.0;
  gradient.setZero();
  for (int corner = 0; corner < 8; ++corner) {
    const int up[3] = {corner & 1, corner >> 1 & 1, corner >> 2 & 1};
    const int index = ((cell[2] + up[2]) * counts[1] + cell[1] + up[1]) * counts[0] + cell[0] + up[0];
    const double value = mass[static_cast<std::size_t>(index)];
    double weight[3], slope[3];
    for (int i = 0; i < 3; ++i) {
      weight[i] = up[i] == 1 ? place[i] : 1.0 - place[i];
      slope[i] = up[i] == 1 ? perMetre[i] : -perMetre[i];
    }
    sum += value * weight[0] * weight[1] * weight[2];
    gradient[0] += value * slope[0] * weight[1] * weight[2];
    gradient[1] += value * weight[0] * slope[1] * weight[2];
    gradient[2] += value * weight[0] * weight[1] * slope[2];
  }
  return sum;
}

CartesianParameters readCartesian(TomlTable& root) {
  CartesianParameters device;
  device.name = root.text("name");
  const std::int64_t axes = root.integer("axes");
  if (axes != 3 && axes != 6) root.fail("axes", "is " + std::to_string(axes) + ", must be 3 or 6");
  device.axes = static_cast<int>(axes);
  if (root.has("gravity")) device.gravity = root.vector3("gravity");
  device.halfWidths = root.vector3("half_widths");
  if (root.has("driven")) readDriven(root, device);
  device.maxForce = root.number("max_force");
  device.positionStep = root.number("position_step");
  if (root.has("rotor_mass")) device.rotorMass = root.number("rotor_mass");
  TomlTable platform = root.table("platform");
  readMass(platform, device);
  if (axes == 6) {
    if (turns(device) || root.has("max_moment")) device.maxMoment = root.number("max_moment");
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
  device.imperfections = readImperfections(root);
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
