// A library of a vendor, opened at run time: a driver loads without it, and says what is missing.
#pragma once

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>

#include <filesystem>
#include <system_error>
#else
#include <dlfcn.h>
#endif

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace enamel {

class VendorLibrary {
 public:
  /// Open `file`; if it is "auto", the first of the names that the system's loader finds. Throws std::runtime_error
  /// with the reason of each.
  VendorLibrary(const std::string& file, const std::vector<std::string>& linuxNames,
                const std::vector<std::string>& windowsNames) {
#ifdef _WIN32
    const std::vector<std::string>& names = windowsNames;
    (void)linuxNames;
#else
    const std::vector<std::string>& names = linuxNames;
    (void)windowsNames;
#endif
    std::string reasons;
    for (const std::string& name : file == "auto" ? names : std::vector<std::string>{file}) {
      handle_.reset(load(name));
      if (handle_) return;
      reasons += (reasons.empty() ? "" : "; ") + lastReason(name);
    }
    throw std::runtime_error("the vendor's library cannot be opened: " + reasons);
  }

  /// Find a function. Throws std::runtime_error if it is missing.
  template <typename Function>
  void bind(const char* name, Function& function) const {
    bindIfThere(name, function);
    if (function == nullptr) throw std::runtime_error(std::string("the vendor's library has no function ") + name);
  }

  /// Find a function; null if it is missing.
  template <typename Function>
  void bindIfThere(const char* name, Function& function) const noexcept {
#ifdef _WIN32
    function =
        reinterpret_cast<Function>(reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_.get()), name)));
#else
    function = reinterpret_cast<Function>(dlsym(handle_.get(), name));
#endif
  }

 private:
#ifdef _WIN32
  static void* load(const std::string& name) { return LoadLibraryW(std::filesystem::u8path(name).c_str()); }
  static std::string lastReason(const std::string& name) {
    return name + ": " + std::system_category().message(static_cast<int>(GetLastError()));
  }
  static void unload(void* handle) noexcept { FreeLibrary(static_cast<HMODULE>(handle)); }
#else
  static void* load(const std::string& name) { return dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL); }
  static std::string lastReason(const std::string&) { return dlerror(); }
  static void unload(void* handle) noexcept { dlclose(handle); }
#endif
  struct Closer {
    void operator()(void* handle) const noexcept { unload(handle); }
  };
  std::unique_ptr<void, Closer> handle_;
};

}  // namespace enamel
