#include "settings.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace enamel::viewer {
namespace {

constexpr std::array<const char*, kLinkedRenderers> kLinkedNames{"position-control", "impedance", "hold", "passivity"};

}  // namespace

RendererSlot slotOf(const PluginLibrary& plugin) noexcept {
  const auto* linked = std::find(kLinkedNames.begin(), kLinkedNames.end(), std::string_view(plugin.description().name));
  return static_cast<RendererSlot>(linked - kLinkedNames.begin());
}

std::vector<std::string> rendererNames(const PluginLibrary* plugin) {
  std::vector<std::string> names(kLinkedNames.begin(), kLinkedNames.end());
  if (plugin != nullptr && slotOf(*plugin) == RendererSlot::plugin) names.emplace_back(plugin->description().name);
  return names;
}

DeviceParameters changed(DeviceParameters device, const Settings& settings) {
  addMass(device, settings.extraMass);
  addFriction(device, settings.friction);
  Vec6 damping = Vec6::Zero();
  damping.head<3>().setConstant(settings.toolDamping);
  addDamping(device, damping);
  return device;
}

}  // namespace enamel::viewer
