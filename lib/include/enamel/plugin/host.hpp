// For hosts: finding, loading and running renderer plugins.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/plugin/abi.h"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// A plugin cannot be loaded or used; the message names the file and the reason.
class PluginError : public Error {
 public:
  using Error::Error;
};

/// A loaded plugin. The library stays loaded as long as this or a renderer made from it lives.
class PluginLibrary {
 public:
  /// Loads a shared library, its symbols kept to itself (RTLD_LOCAL). Throws PluginError: not a file, not an ELF
  /// library, one of another architecture, a library that cannot be loaded (such as one that needs a missing symbol),
  /// without enamel_plugin(), of another ABI version or other struct sizes, with missing functions or an empty or
  /// malformed description, one that throws. A library that crashes or hangs takes the process with it. Realtime: no.
  static std::shared_ptr<const PluginLibrary> load(const std::string& path);
  ~PluginLibrary();
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;

  const std::string& path() const noexcept { return path_; }
  const EnamelDescription& description() const noexcept { return *description_; }
  const EnamelPlugin& table() const noexcept { return *table_; }

 private:
  PluginLibrary() = default;

  std::string path_;
  void* handle_ = nullptr;
  const EnamelPlugin* table_ = nullptr;
  const EnamelDescription* description_ = nullptr;
};

/// What a renderer from a plugin is made with: see EnamelConfiguration. Empty texts are not given.
struct PluginSetup {
  std::string devicePath, deviceText, scenePath, sceneText;
  std::map<std::string, std::string> parameters;
};

/// A renderer that runs in the plugin: the contract of Renderer holds, and an output that is not finite becomes a
/// fault. activate() throws PluginError with the plugin's reason. Throws PluginError: no memory, or the plugin refuses
/// the configuration. Realtime: no; step() and reset() as far as the plugin's are.
std::unique_ptr<Renderer> makeRenderer(std::shared_ptr<const PluginLibrary> library, const PluginSetup& setup);

/// One file of a plugin folder.
struct PluginFinding {
  std::string path;
  std::shared_ptr<const PluginLibrary> library;  ///< nullptr where it was refused
  std::string reason;                            ///< why it was refused
};

/// Return the paths of all *.so of a folder, in order. Throws PluginError: the folder cannot be read. Realtime: no.
std::vector<std::string> pluginFiles(const std::string& folder);

/// Every *.so of a folder, by name. Throws PluginError: the folder cannot be read. Realtime: no.
std::vector<PluginFinding> findPlugins(const std::string& folder);

/// A plugin by its path (a text with '/' or ending in .so) or by its name, of those in `folder`: enamel_NAME.so and
/// NAME.so (with _ for -) are tried first, the other files only if these are not it. Throws PluginError: as
/// PluginLibrary::load(), or no plugin of that name, with those that there are. Realtime: no.
std::shared_ptr<const PluginLibrary> findPlugin(const std::string& nameOrPath, const std::string& folder);

}  // namespace enamel
