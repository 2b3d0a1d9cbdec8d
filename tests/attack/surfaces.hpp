// Attack surfaces: functions that take bytes from outside and must not crash, hang or answer nonsense. A fuzzer finds
// the bytes (fuzzer.cpp), the corpus keeps them, and a test runs all that are kept (corpus.cpp).
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

namespace enamel::attack {

struct Surface {
  std::string_view name;
  void (*attack)(std::string_view bytes);  ///< ends the process where a promise is broken
};

std::vector<Surface> meshSurfaces();
std::vector<Surface> fileSurfaces();
std::vector<Surface> linkSurfaces();
std::vector<Surface> tickSurfaces();
std::vector<Surface> pluginSurfaces();
std::vector<Surface> hostSurfaces();
#ifdef ENAMEL_ATTACK_FMI
std::vector<Surface> unitSurfaces();
#endif

inline std::vector<Surface> allSurfaces() {
  std::vector<Surface> all;
  for (const auto& some : {
           meshSurfaces(),
           fileSurfaces(),
           linkSurfaces(),
           tickSurfaces(),
           pluginSurfaces(),
           hostSurfaces(),
#ifdef ENAMEL_ATTACK_FMI
           unitSurfaces(),
#endif
       })
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// Ends the process where a promise is broken.
inline void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise);
  std::abort();
}

/// Numbers of any type, read from the front of bytes; zeros where there are no more.
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
  /// 0 to `count` - 1.
  int pick(int count) { return next<unsigned char>() % count; }
  /// Some of the next bytes.
  std::string_view text(std::size_t most) {
    const std::string_view some = left_.substr(0, std::min<std::size_t>(next<unsigned char>(), most));
    left_.remove_prefix(std::min(some.size(), left_.size()));
    return some;
  }

 private:
  std::string_view left_;
};

}  // namespace enamel::attack
