// Attack surfaces: functions that receive bytes from outside. They must not crash, hang or return invalid results. A
// fuzzer searches for inputs (fuzzer.cpp), the corpus stores them, and a test runs all stored inputs (corpus.cpp).
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel::attack {

struct Surface {
  std::string_view name;
  void (*attack)(std::string_view bytes);  ///< ends the process if a promise is violated
};

/// Return all surfaces of the program.
inline std::vector<Surface>& surfaces() {
  static std::vector<Surface> all;
  return all;
}

/// Adds a surface. There is one for each surface, in the file of its function.
struct Registration {
  Registration(std::string_view name, void (*attack)(std::string_view)) { surfaces().push_back({name, attack}); }
};

/// End the process if a promise is violated.
inline void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise);
  std::abort();
}

/// Require finite torques within the limits.
inline void requireWithin(const JointVector& torque, const JointVector& limits) {
  require(torque.size() == limits.size() && torque.allFinite(), "torques are finite");
  require((torque.cwiseAbs() - limits).maxCoeff() <= 0.0, "torques are within the limits");
}

/// Reads numbers of any type from the front of bytes; zeros after the end.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : left_(bytes) {}
  bool empty() const { return left_.empty(); }
  template <typename T>
  T next() {
    T value{};
    const std::size_t size = std::min(sizeof(T), left_.size());
    std::memcpy(&value, left_.data(), size);
    left_.remove_prefix(size);
    return value;
  }
  /// Return 0 to `count` - 1.
  int pick(int count) { return next<unsigned char>() % count; }
  /// Return some of the next bytes.
  std::string_view text(std::size_t most) {
    const std::string_view some = left_.substr(0, std::min<std::size_t>(next<unsigned char>(), most));
    left_.remove_prefix(std::min(some.size(), left_.size()));
    return some;
  }

 private:
  std::string_view left_;
};

}  // namespace enamel::attack
