// Functions with many options: each option is a member of a struct, with its name in Python.
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "binding.hpp"

namespace enamel::python {

/// Name of a type in help().
template <typename T>
struct TypeName {
  static std::string text() {
    const py::type type = py::type::of<T>();
    return py::str("{}.{}").format(type.attr("__module__"), type.attr("__qualname__")).template cast<std::string>();
  }
};
template <>
struct TypeName<bool> {
  static std::string text() { return "bool"; }
};
template <>
struct TypeName<int> {
  static std::string text() { return "int"; }
};
template <>
struct TypeName<std::uint32_t> : TypeName<int> {};
template <>
struct TypeName<std::uint64_t> : TypeName<int> {};
template <>
struct TypeName<double> {
  static std::string text() { return "float"; }
};
template <>
struct TypeName<std::string> {
  static std::string text() { return "str"; }
};
template <>
struct TypeName<Array> {
  static std::string text() { return "numpy.ndarray[numpy.float64]"; }
};
template <typename T>
struct TypeName<std::vector<T>> {
  static std::string text() { return "List[" + TypeName<T>::text() + "]"; }
};
template <typename A, typename B>
struct TypeName<std::pair<A, B>> {
  static std::string text() { return "Tuple[" + TypeName<A>::text() + ", " + TypeName<B>::text() + "]"; }
};
template <typename T>
struct TypeName<std::optional<T>> {
  static std::string text() { return "Optional[" + TypeName<T>::text() + "]"; }
};
template <typename T>
struct TypeName<std::shared_ptr<T>> : TypeName<T> {};

/// The options of a function: members of Options, whose initial values are the defaults.
template <typename Options>
class Keywords {
 public:
  /// `function`: its name for messages. If not `byNameOnly`, options can also be positional.
  explicit Keywords(std::string function, bool byNameOnly = true)
      : function_(std::move(function)), byNameOnly_(byNameOnly) {}

  template <typename T>
  Keywords& add(const char* name, T Options::*member) {
    const std::string type = TypeName<T>::text();
    const auto read = [name, member, type, function = function_](Options& options, const py::handle& value) {
      try {
        options.*member = value.cast<T>();
      } catch (const py::cast_error&) {
        throw py::type_error(function + "(): " + name + " is " + py::repr(value).cast<std::string>() + ", must be " +
                             type);
      }
    };
    entries_.push_back({name, std::string(name) + ": " + type + " = " + reprOf(Options().*member), read});
    return *this;
  }

  /// Read the options. Throws TypeError: an unknown option, a repeated one, a value of another type.
  Options read(const py::kwargs& named) const { return read(py::args(), named); }
  Options read(const py::args& placed, const py::kwargs& named) const {
    if (placed.size() > entries_.size()) throw py::type_error(function_ + "() got too many arguments");
    Options options;
    for (std::size_t i = 0; i < placed.size(); ++i) entries_[i].read(options, placed[i]);
    for (const auto& [key, value] : named) {
      const auto name = key.template cast<std::string>();
      const std::size_t i = find(name);
      if (i == entries_.size()) throw py::type_error(function_ + "() has no argument \"" + name + "\"");
      if (i < placed.size()) throw py::type_error(function_ + "() got \"" + name + "\" twice");
      entries_[i].read(options, value);
    }
    return options;
  }

  /// Return the docstring, which begins with the function's signature as pybind11 writes it. `before`: arguments before
  /// the options. For functions under disable_function_signatures().
  std::string documented(const std::string& before, const std::string& result, const char* text) const {
    std::string signature = function_ + "(" + before + (byNameOnly_ ? ", *" : "");
    for (const Entry& entry : entries_) signature += ", " + entry.signature;
    return signature + ") -> " + result + "\n\n" + text + "\n";
  }

 private:
  struct Entry {
    std::string name, signature;
    std::function<void(Options&, const py::handle&)> read;
  };

  template <typename T>
  static std::string reprOf(const T& value) {
    if constexpr (std::is_base_of_v<py::handle, T>)
      return py::repr(value).template cast<std::string>();
    else
      return py::repr(py::cast(value)).template cast<std::string>();
  }

  std::size_t find(const std::string& name) const {
    std::size_t i = 0;
    while (i < entries_.size() && entries_[i].name != name) ++i;
    return i;
  }

  std::string function_;
  bool byNameOnly_;
  std::vector<Entry> entries_;
};

/// Return the arguments of push(), judge() and trials() before their options, for documented().
inline std::string deviceAnd(const char* other) {
  return "device: " + TypeName<Device>::text() + ", " + other + ": object";
}

}  // namespace enamel::python
