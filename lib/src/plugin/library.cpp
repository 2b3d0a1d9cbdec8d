#include "plugin/library.hpp"

#include <array>
#include <cctype>

#include "core/message.hpp"
#include "enamel/plugin/driver.h"

namespace enamel::plugin {

std::shared_ptr<void> loadShared(const std::string& path) {
  system::checkLibrary(path);
  return {system::loadLibrary(path), system::unloadLibrary};
}

void* exported(const std::string& path, void* library, const char* symbol) {
  if (void* found = system::symbolOf(library, symbol)) return found;
  const bool isDriver = system::symbolOf(library, ENAMEL_DRIVER_SYMBOL) != nullptr;
  const bool isRenderer = system::symbolOf(library, ENAMEL_PLUGIN_SYMBOL) != nullptr;
  throw PluginError(path + ": does not export " + symbol + "()" +
                    (isDriver     ? ": it is a driver, not a renderer"
                     : isRenderer ? ": it is a renderer, not a driver"
                                  : ""));
}

void checkSize(const std::string& path, const char* what, std::uint32_t found, std::size_t expected) {
  if (found != expected)
    throw PluginError(path + ": its " + what + " has " + std::to_string(found) + " bytes, this host's " +
                      std::to_string(expected));
}

void checkVersion(const std::string& path, std::uint32_t version, std::uint32_t oldest, std::uint32_t newest) {
  if (version < oldest || version > newest)
    throw PluginError(path + ": has ABI version " + std::to_string(version) + ", this host loads " +
                      std::to_string(oldest) + " to " + std::to_string(newest) +
                      ": build the plugin with this version's headers");
}

void checkDescription(const std::string& path, const EnamelDescription* d) {
  const auto isLine = [](const char* text) { return text != nullptr && printable(text) == text; };
  const auto filled = [isLine](const char* text) { return isLine(text) && *text != 0; };
  if (d == nullptr || !filled(d->name) || !filled(d->version) || !filled(d->summary))
    throw PluginError(path + ": name, version and summary of its description must each be one line");
  const std::string name = d->name;
  if (!std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '-'; }))
    throw PluginError(path + ": its name \"" + name + "\" has characters other than letters, digits and '-'");
  if (d->parameter_count > 0 && d->parameters == nullptr)
    throw PluginError(path + ": its description declares " + std::to_string(d->parameter_count) +
                      " parameters, but its list is NULL");
  for (std::size_t i = 0; i < d->parameter_count; ++i)
    if (!filled(d->parameters[i].key) || !isLine(d->parameters[i].value) || !filled(d->parameters[i].meaning))
      throw PluginError(path + ": parameter " + std::to_string(i) +
                        " must have a key and a meaning of one line each, and a default");
}

std::string requireOk(const std::string& path, const char* what,
                      const std::function<std::int32_t(EnamelMessage)>& call) {
  std::array<char, 1024> text{};
  const std::int32_t result = call(EnamelMessage{text.data(), text.size()});
  text.back() = 0;
  if (result != ENAMEL_OK)
    throw PluginError(
        path + ": " +
        (text[0] != 0 ? std::string(text.data())
                      : std::string(what) + "() failed with code " + std::to_string(result) + " and gave no reason"));
  return printable(text.data());
}

}  // namespace enamel::plugin
