// The common parts of renderer and driver plugins: a shared library with a table of functions and a description.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "enamel/plugin/host.hpp"
#include "plugin/system_library.hpp"

namespace enamel::plugin {

/// Load a shared library; the last copy of the result unloads it. Throws PluginError as PluginLibrary::load().
std::shared_ptr<void> loadShared(const std::string& path);

/// Return the exported function `symbol`. Throws PluginError if it is missing; the message says if the library is a
/// plugin of the other kind.
void* exported(const std::string& path, void* library, const char* symbol);

/// Throw PluginError if a struct has not the size that this host expects.
void checkSize(const std::string& path, const char* what, std::uint32_t found, std::size_t expected);

/// Throw PluginError unless the version is in `oldest` to `newest`.
void checkVersion(const std::string& path, std::uint32_t version, std::uint32_t oldest, std::uint32_t newest);

/// Throw PluginError unless a description is complete, with one line in each text.
void checkDescription(const std::string& path, const EnamelDescription* description);

/// Call a function of a plugin. The contract forbids exceptions. If it throws one, report it instead of ending this
/// program.
template <typename Result>
Result guarded(const std::string& path, const std::string& what, Result (*function)()) {
  try {
    return function();
  } catch (const std::exception& error) {
    throw PluginError(path + ": " + what + "() threw: " + error.what());
  } catch (...) {
    throw PluginError(path + ": " + what + "() threw an unknown exception");
  }
}

/// Return the table of a loaded library.
template <typename Table>
const Table& tableOf(const std::string& path, void* library, const char* symbol) {
  const auto function = reinterpret_cast<const Table* (*)()>(exported(path, library, symbol));
  const Table* table = guarded(path, symbol, function);
  if (table == nullptr) throw PluginError(path + ": " + symbol + "() returned NULL");
  return *table;
}

/// Call a setup function that returns an EnamelResult and writes a message. Return the message as one line. Throws
/// PluginError with the message, or with the result if the message is empty.
std::string requireOk(const std::string& path, const char* what,
                      const std::function<std::int32_t(EnamelMessage)>& call);

/// Find a plugin by its path or by its name in `folder`: findPlugin(). `kind` is a noun for messages.
template <typename Library>
std::shared_ptr<const Library> find(const char* kind, const std::string& nameOrPath, const std::string& folder) {
  namespace fs = std::filesystem;
  const std::string& ending = system::kLibraryEnding;
  const bool isFile = nameOrPath.size() > ending.size() &&
                      nameOrPath.compare(nameOrPath.size() - ending.size(), ending.size(), ending) == 0;
  if (isFile || fs::u8path(nameOrPath).has_parent_path()) return Library::load(nameOrPath);
  std::string known, stem = nameOrPath;
  std::replace(stem.begin(), stem.end(), '-', '_');
  std::error_code ignored;
  // The likely files come first, so that a bad plugin beside them is not loaded.
  for (const std::string& file : {folder + "/enamel_" + stem + ending, folder + "/" + stem + ending}) {
    if (!fs::is_regular_file(fs::u8path(file), ignored)) continue;
    auto library = Library::load(file);
    if (library->description().name == nameOrPath) return library;
  }
  if (fs::is_directory(fs::u8path(folder), ignored))
    for (const std::string& file : pluginFiles(folder)) try {
        auto library = Library::load(file);
        if (library->description().name == nameOrPath) return library;
        known += std::string(known.empty() ? "" : ", ") + library->description().name;
      } catch (const PluginError&) {  // refused: `enamel plugins` says why
      }
  const std::string found = folder.empty()  ? "no plugin folder is given"
                            : known.empty() ? folder + " has no " + kind + "s"
                                            : folder + " has " + known;
  throw PluginError(std::string("unknown ") + kind + " \"" + nameOrPath + "\": " + found + "; a path must end in " +
                    ending);
}

}  // namespace enamel::plugin
