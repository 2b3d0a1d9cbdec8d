// For hosts: find, load and run renderer plugins.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/plugin/abi.h"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Thrown if a plugin cannot be loaded or used. The message names the file and the reason.
class PluginError : public Error {
 public:
  using Error::Error;
};

/// A loaded plugin. The library stays loaded while this object or a renderer made from it exists.
class PluginLibrary {
 public:
  /// Load a shared library with local symbols (RTLD_LOCAL). Throws PluginError in these cases:
  ///
  /// - the path is not a file, not an ELF library, or has another architecture;
  /// - the library cannot be loaded, for example because of a missing symbol;
  /// - enamel_plugin() is missing or throws;
  /// - the ABI version or a struct size differs, or functions are missing;
  /// - the description is empty or malformed.
  ///
  /// A library that crashes or hangs does the same to the process. Realtime: no.
  static std::shared_ptr<const PluginLibrary> load(const std::string& path);

  /// Use a table of functions in this program. `name` appears in messages. Throws PluginError as load(). Realtime: no.
  static std::shared_ptr<const PluginLibrary> of(const EnamelPlugin& table, const std::string& name);
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;

  const std::string& path() const noexcept { return path_; }
  const EnamelDescription& description() const noexcept { return *description_; }
  const EnamelPlugin& table() const noexcept { return *table_; }

 private:
  PluginLibrary() = default;
  void use(const EnamelPlugin& table);

  std::string path_;
  std::shared_ptr<void> handle_;  // unloads the library
  const EnamelPlugin* table_ = nullptr;
  const EnamelDescription* description_ = nullptr;
};

/// Configuration of a plugin's renderer, see EnamelConfiguration. Empty texts are not passed.
struct PluginSetup {
  std::string devicePath, deviceText, scenePath, sceneText;
  std::map<std::string, std::string> parameters;
};

/// Make a renderer that runs in the plugin. It keeps the contract of Renderer. An output that is not finite becomes a
/// fault. Throws PluginError if memory is exhausted or the plugin rejects the configuration. activate() throws
/// PluginError with the plugin's reason. Realtime: no; step() and reset() if the plugin's are.
std::unique_ptr<Renderer> makeRenderer(std::shared_ptr<const PluginLibrary> library, const PluginSetup& setup);

/// One file of a plugin folder.
struct PluginFinding {
  std::string path;
  std::shared_ptr<const PluginLibrary> library;  ///< nullptr if it was rejected
  std::string reason;                            ///< why it was rejected
};

/// Return the paths of all *.so of a folder, in order. Throws PluginError if the folder cannot be read. Realtime: no.
std::vector<std::string> pluginFiles(const std::string& folder);

/// Load every *.so of a folder, in order of their names. Throws PluginError if the folder cannot be read. Realtime: no.
std::vector<PluginFinding> findPlugins(const std::string& folder);

/// Find a plugin by its path (a text with '/' or ending in .so) or by its name in `folder`. A search by name first
/// tries enamel_NAME.so and NAME.so (with _ for -), then all other files. Throws PluginError as PluginLibrary::load().
/// Throws PluginError also if the name is unknown; the message lists the known names. Realtime: no.
std::shared_ptr<const PluginLibrary> findPlugin(const std::string& nameOrPath, const std::string& folder);

}  // namespace enamel
