#include "enamel/device/device_file.hpp"

#include "core/text_file.hpp"
#include "core/toml.hpp"
#include "device/read.hpp"
#include "enamel/device/tau/mechanism.hpp"

namespace enamel {
namespace {

struct Make {
  std::shared_ptr<const Mechanism> operator()(const TauParameters& p) { return std::make_shared<TauMechanism>(p); }
};

}  // namespace

DeviceParameters parseDevice(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  const std::string kind = kindOf(root);
  if (kind == "tau") return readTau(root);
  root.fail("kind", "is \"" + kind + "\", must be \"tau\"");
}

DeviceParameters loadDevice(const std::string& path) { return parseDevice(readTextFile(path), path); }

std::shared_ptr<const Mechanism> makeMechanism(const DeviceParameters& parameters) {
  return std::visit(Make{}, parameters);
}

const std::string& nameOf(const DeviceParameters& parameters) noexcept {
  return std::visit([](const auto& p) -> const std::string& { return p.name; }, parameters);
}

void addDamping(DeviceParameters& parameters, const Vec6& damping) {
  std::visit([&](auto& p) { p.platform.damping += damping; }, parameters);
}

void addFriction(DeviceParameters& parameters, double friction) {
  std::visit([&](auto& p) { p.motor.viscousFriction += friction; }, parameters);
}

void addMass(DeviceParameters& parameters, double mass) {
  std::visit([&](auto& p) { p.platform.mass += mass; }, parameters);
}

}  // namespace enamel
