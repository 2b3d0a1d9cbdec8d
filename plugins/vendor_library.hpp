// A library of a vendor, opened at run time: a driver loads without it, and says what is missing.
#pragma once

#include <dlfcn.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace enamel {

class VendorLibrary {
 public:
  /// Open `file`; if it is "auto", the first of `names` that the system's loader finds. Throws std::runtime_error with
  /// the reason of each.
  VendorLibrary(const std::string& file, const std::vector<std::string>& names) {
    std::string reasons;
    for (const std::string& name : file == "auto" ? names : std::vector<std::string>{file}) {
      handle_.reset(dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL));
      if (handle_) return;
      reasons += (reasons.empty() ? "" : "; ") + std::string(dlerror());
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
    function = reinterpret_cast<Function>(dlsym(handle_.get(), name));
  }

 private:
  struct Closer {
    void operator()(void* handle) const noexcept { dlclose(handle); }
  };
  std::unique_ptr<void, Closer> handle_;
};

}  // namespace enamel
