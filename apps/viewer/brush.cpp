#include "brush.hpp"

#include <cstdarg>
#include <cstdio>

namespace enamel::viewer {

ImU32 ink(unsigned rgb, double alpha) {
  return IM_COL32(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255, static_cast<int>(255.0 * alpha));
}

ImVec4 tone(unsigned rgb, double alpha) { return ImGui::ColorConvertU32ToFloat4(ink(rgb, alpha)); }

std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof(text), pattern, arguments);
  va_end(arguments);
  return text;
}

std::string tenths(double value) { return format("%.1f", std::abs(value) < 0.05 ? 0.0 : value); }

}  // namespace enamel::viewer
