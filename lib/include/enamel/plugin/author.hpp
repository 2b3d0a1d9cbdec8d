// For authors of plugins in C++. A class and one macro make a plugin. No exception crosses the boundary.
//
//   class MyWall {
//    public:
//     static constexpr bool kNeedsInertia = true;  // if needsInertia() of its renderers returns true
//
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

/// The configuration passed to configure(), read and checked.
class PluginConfiguration {
 public:
  /// Throws ConfigurationError as parseDevice() and parseScene(), and if a parameter is unknown, given twice, or
  /// missing without a default.
  PluginConfiguration(const EnamelDescription& description, const EnamelConfiguration& configuration);

  /// Return the device. Throws ConfigurationError if the host gave none.
  const DeviceParameters& device() const;
  const std::optional<SceneFile>& scene() const noexcept { return scene_; }

  /// Return the value of a parameter: a text, a finite number within [low, high] in `unit`, or "on" or "off". Throws
  /// ConfigurationError with key, value and limits.
  const std::string& text(const std::string& key) const;
  double number(const std::string& key, double low, double high, const std::string& unit) const;
  bool flag(const std::string& key) const;

 private:
  std::optional<DeviceParameters> device_;
  std::optional<SceneFile> scene_;
  std::map<std::string, std::string> parameters_;
};

/// An instance of a plugin behind the table. Used by ENAMEL_PLUGIN.
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

/// Whether a plugin's renderers read the inertia: Plugin::kNeedsInertia, or false if the class does not have it.
template <typename Plugin, typename = void>
inline constexpr bool pluginNeedsInertia = false;
template <typename Plugin>
inline constexpr bool pluginNeedsInertia<Plugin, std::void_t<decltype(Plugin::kNeedsInertia)>> = Plugin::kNeedsInertia;

/// Return the table of a plugin class.
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

/// Export a plugin class. Use once, in one source file of the plugin, outside namespaces.
#define ENAMEL_PLUGIN(Class) \
  extern "C" const EnamelPlugin* enamel_plugin(void) { return &enamel::pluginTable<Class>(); }
