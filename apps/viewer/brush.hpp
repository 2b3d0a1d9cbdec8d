// Fonts, colours, text and arrows of the overlay.
#pragma once

#include <imgui.h>

#include <cmath>
#include <string>

#include "colours/palette.hpp"
#include "layout.hpp"

namespace enamel::viewer {

/// ImGui keeps fonts as long as its context, and there is only one: setUpOverlay() fills them in.
struct Fonts {
  ImFont *text = nullptr, *small = nullptr, *bold = nullptr, *large = nullptr;
  ImFont* huge = nullptr;  ///< for digits
};
inline Fonts gFonts;

ImU32 ink(unsigned rgb, double alpha = 1.0);
ImVec4 tone(unsigned rgb, double alpha = 1.0);

std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

/// Format with one decimal, but never as "-0.0".
std::string tenths(double value);

struct Brush {
  ImDrawList* list;
  float s;  // scale

  void text(ImFont* font, float x, float y, unsigned rgb, const std::string& text) const {
    list->AddText(font, font->FontSize, {std::round(x), std::round(y)}, ink(rgb), text.c_str());
  }
  static float width(ImFont* font, const std::string& text) {
    return font->CalcTextSizeA(font->FontSize, 1e6f, 0.0f, text.c_str()).x;
  }
  void textRight(ImFont* font, float x, float y, unsigned rgb, const std::string& t) const {
    text(font, x - width(font, t), y, rgb, t);
  }
  // Clear the background, so that text remains readable over the device.
  void clear(float x, float y, float width, float height) const {
    list->AddRectFilled({x - 6 * s, y}, {x + width + 6 * s, y + height}, ink(kGround, 0.8), 6 * s);
  }
  void box(const Rect& a, double alpha) const {
    list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper, alpha), 6 * s);
    list->AddRect({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kLine), 6 * s, 0, s);
  }
  void arrow(ImVec2 from, ImVec2 to, unsigned rgb, float width) const {
    const float dx = to.x - from.x, dy = to.y - from.y, length = std::sqrt(dx * dx + dy * dy);
    if (length < 1e-3f) return;
    const float ux = dx / length, uy = dy / length, head = std::min(9 * s, 0.7f * length);
    const ImVec2 neck{to.x - head * ux, to.y - head * uy};
    list->AddLine(from, neck, ink(rgb), width);
    list->AddTriangleFilled(to, {neck.x - 0.55f * head * uy, neck.y + 0.55f * head * ux},
                            {neck.x + 0.55f * head * uy, neck.y - 0.55f * head * ux}, ink(rgb));
  }
};

}  // namespace enamel::viewer
