// For authors of plugins in C++: a class and one macro make a plugin; nothing throws across the boundary.
//
//   class MyWall {
//    public:
//     static constexpr bool kNeedsInertia = true;  // where its renderers' needsInertia() does
//     static const EnamelDescription& describe() noexcept;
//     explicit MyWall(const enamel::PluginConfiguration& configuration);             // configure: throws Error
//     std::unique_ptr<enamel::Renderer> activate(double period) const;               // throws Error
//   };
//   ENAMEL_PLUGIN(MyWall)
#pragma once

#include <Eigen/Geometry>  // cross products
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/abi.h"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// What configure() was given, read and checked.
class PluginConfiguration {
 public:
  /// Throws ConfigurationError: as parseDevice() and parseScene(); a parameter that the description does not have,
  /// twice the same one, or none for one without a default.
  PluginConfiguration(const EnamelDescription& description, const EnamelConfiguration& configuration);

  /// Throws ConfigurationError where the host gave no device.
  const DeviceParameters& device() const;
  const std::optional<SceneFile>& scene() const noexcept { return scene_; }

  /// A parameter's value: text; a finite number within [low, high] in `unit`; "on" or "off". Throws ConfigurationError
  /// naming key, value and limits.
  const std::string& text(const std::string& key) const;
  double number(const std::string& key, double low, double high, const std::string& unit) const;
  bool flag(const std::string& key) const;

 private:
  std::optional<DeviceParameters> device_;
  std::optional<SceneFile> scene_;
  std::map<std::string, std::string> parameters_;
};

/// The other side of the table: an instance of a plugin. Used by ENAMEL_PLUGIN.
class PluginInstance {
 public:
  using Activate = std::function<std::unique_ptr<Renderer>(double period)>;
  using Configure = std::function<Activate(const EnamelConfiguration&)>;
  PluginInstance(bool needsInertia, Configure configure)
      : needsInertia_(needsInertia), configure_(std::move(configure)) {}

  int32_t configure(const EnamelConfiguration& configuration, EnamelMessage message) noexcept;
  int32_t activate(double period, EnamelMessage message) noexcept;
  int32_t step(const EnamelTickInput& input, EnamelTickOutput& output) noexcept;
  void reset() noexcept;
  void deactivate() noexcept { renderer_.reset(); }
  std::size_t stateSize() const noexcept { return renderer_ ? renderer_->stateSize() : 0; }
  void saveState(void* state) const noexcept;
  void loadState(const void* state) noexcept;

 private:
  bool needsInertia_;
  Configure configure_;
  Activate activate_;
  std::unique_ptr<Renderer> renderer_;  // while active
  TickFrame frame_;
};

/// Plugin::kNeedsInertia where a class has it: whether its renderers read the inertia.
template <typename Plugin, typename = void>
inline constexpr bool pluginNeedsInertia = false;
template <typename Plugin>
inline constexpr bool pluginNeedsInertia<Plugin, std::void_t<decltype(Plugin::kNeedsInertia)>> = Plugin::kNeedsInertia;

/// The table of a plugin class.
template <typename Plugin>
const EnamelPlugin& pluginTable() noexcept {
  static const EnamelPlugin table = {
      ENAMEL_ABI_VERSION,
      sizeof(EnamelPlugin),
      sizeof(EnamelTickInput),
      sizeof(EnamelTickOutput),
      pluginNeedsInertia<Plugin> ? ENAMEL_NEEDS_INERTIA : 0u,
      0u,
      [] { return &Plugin::describe(); },
      []() -> void* {
        try {
          return new PluginInstance(
              pluginNeedsInertia<Plugin>, [](const EnamelConfiguration& given) -> PluginInstance::Activate {
                auto plugin = std::make_shared<const Plugin>(PluginConfiguration(Plugin::describe(), given));
                return [plugin](double period) { return plugin->activate(period); };
              });
        } catch (...) {
          return nullptr;
        }
      },
      [](void* self, const EnamelConfiguration* given, EnamelMessage message) {
        return static_cast<PluginInstance*>(self)->configure(*given, message);
      },
      [](void* self, double period, EnamelMessage message) {
        return static_cast<PluginInstance*>(self)->activate(period, message);
      },
      [](void* self, const EnamelTickInput* input, EnamelTickOutput* output) {
        return static_cast<PluginInstance*>(self)->step(*input, *output);
      },
      [](void* self) { static_cast<PluginInstance*>(self)->reset(); },
      [](void* self) { static_cast<PluginInstance*>(self)->deactivate(); },
      [](void* self) { delete static_cast<PluginInstance*>(self); },
      [](const void* self) { return static_cast<const PluginInstance*>(self)->stateSize(); },
      [](const void* self, void* state) { static_cast<const PluginInstance*>(self)->saveState(state); },
      [](void* self, const void* state) { static_cast<PluginInstance*>(self)->loadState(state); },
  };
  return table;
}

}  // namespace enamel

/// Once, in one source file of the plugin, outside namespaces.
#define ENAMEL_PLUGIN(Class) \
  extern "C" const EnamelPlugin* enamel_plugin(void) { return &enamel::pluginTable<Class>(); }
