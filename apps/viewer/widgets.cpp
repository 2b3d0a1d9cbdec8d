#include "widgets.hpp"

#include <imgui.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>

namespace enamel::viewer {
namespace {

// Return the typed value in the shown unit, or set `problem`.
std::optional<double> typedValue(const OverlayState& state, const SliderRow& row, std::string& problem) {
  const char* const text = state.typing.text.data();
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  const std::string rest(end), blank = " \t";
  const std::size_t word = rest.find_first_not_of(blank);
  const bool onlyUnit = word == std::string::npos || rest.compare(word, std::string::npos, row.unit) == 0;
  if (end == text || !onlyUnit || !std::isfinite(value))
    problem = format("%s: \"%s\" is not a number of %s. The value is unchanged.", row.name, text, row.unit);
  else if (value < row.low || value > row.high)
    problem = format("%s is %s, must be in %g to %g %s. The value is unchanged.", row.name, text, row.low, row.high,
                     row.unit);
  else
    return value;
  return std::nullopt;
}

// Draw the value as a button; a click turns it into a text field. Return true when a value was typed.
bool valueField(OverlayState& state, double& value, const SliderRow& row, float width) {
  bool done = false;
  ImGui::SetNextItemWidth(width);
  if (state.typing.name == row.name) {
    if (ImGui::InputText("##typed", state.typing.text.data(), state.typing.text.size(),
                         ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll)) {
      std::string problem;
      if (const auto typed = typedValue(state, row, problem)) {
        value = *typed / row.factor;
        done = true;
      } else {
        state.asked.problem = problem;
      }
      state.typing.name.clear();
    } else if (ImGui::IsItemDeactivated()) {
      state.typing.name.clear();
    } else if (!ImGui::IsItemActive()) {
      ImGui::SetKeyboardFocusHere(-1);
    }
    return done;
  }
  const std::string shown = format(row.pattern, value * row.factor) + " " + row.unit;
  ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, {1.0f, 0.5f});
  if (ImGui::Button((shown + "##type").c_str(), {width, 0})) {
    state.typing.name = row.name;
    std::snprintf(state.typing.text.data(), state.typing.text.size(), row.pattern, value * row.factor);
  }
  ImGui::PopStyleVar();
  note(state, row.name);
  tip(state, "Click to type a value: Enter sets it, Esc cancels.");
  return done;
}

}  // namespace

void showTip(OverlayState& state, const char* text) {
  constexpr double patience = 0.35;  // s
  if (state.tip.text != text) state.tip.since = ImGui::GetTime();
  state.tip.text = text;
  state.tip.seen = true;
  if (ImGui::GetTime() - state.tip.since < patience) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(20.0f * gFonts.text->FontSize);
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void tip(OverlayState& state, const char* text) {
  if (ImGui::IsItemHovered()) showTip(state, text);
}

void note(OverlayState& state, const std::string& name) {
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  state.controls[name] = {0.5f * (low.x + high.x), 0.5f * (low.y + high.y)};
}

void heading(const char* text) {
  ImGui::Dummy({0, 2});
  ImGui::PushFont(gFonts.bold);
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

void remark(const std::string& text, unsigned rgb) {
  ImGui::PushFont(gFonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, tone(rgb));
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

void label(const char* name) {
  ImGui::PushFont(gFonts.small);
  ImGui::TextColored(tone(kMuted), "%s", name);
  ImGui::PopFont();
}

bool slider(OverlayState& state, double& value, const SliderRow& row) {
  ImGui::PushID(row.name);
  ImGui::PushFont(gFonts.small);
  ImGui::TextColored(tone(kMuted), "%s", row.name);
  tip(state, row.about);
  const float field = 110.0f * gFonts.small->FontSize / 13.0f;
  ImGui::SameLine(ImGui::GetContentRegionMax().x - field);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {4, 0});
  bool done = valueField(state, value, row, field);
  ImGui::PopFont();
  float shown = static_cast<float>(value * row.factor);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::SliderFloat("##value", &shown, static_cast<float>(row.low), static_cast<float>(row.high), "",
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput))
    value = static_cast<double>(shown) / row.factor;
  done |= ImGui::IsItemDeactivatedAfterEdit();
  tip(state, row.about);
  ImGui::PopStyleVar();
  ImGui::PopID();
  return done;
}

bool toggle(const char* name, bool on, float width, unsigned colour) {
  ImGui::PushStyleColor(ImGuiCol_Button, on ? tone(colour) : tone(0xFFFFFF));
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, on ? tone(colour, 0.85) : tone(kLine));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, tone(colour, 0.7));
  ImGui::PushStyleColor(ImGuiCol_Text, on && colour != kSky ? tone(0xFFFFFF) : tone(kInk));
  const bool pressed = ImGui::Button(name, {width, 0});
  ImGui::PopStyleColor(4);
  return pressed;
}

int choice(OverlayState& state, const char* const* names, int count, int chosen, float width, const char* about) {
  int pressed = -1;
  const float gap = 0.3f * gFonts.text->FontSize;
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {1, ImGui::GetStyle().FramePadding.y});
  const float each = (width - gap * static_cast<float>(count - 1)) / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    if (i > 0) ImGui::SameLine(0, gap);
    if (toggle(names[i], i == chosen, each) && i != chosen) pressed = i;
    note(state, names[i]);
    tip(state, about);
  }
  ImGui::PopStyleVar();
  return pressed;
}

void actionButtons(OverlayState& state, std::initializer_list<ActionButton> buttons, float scale, float width) {
  const auto count = static_cast<float>(buttons.size());
  const float gap = 6 * scale, each = (width - gap * (count - 1)) / count;
  for (const ActionButton& button : buttons) {
    if (&button != buttons.begin()) ImGui::SameLine(0, gap);
    if (toggle(button.name.c_str(), button.on, each)) state.asked.actions.push_back(button.action);
    if (button.about != nullptr) tip(state, button.about);
  }
}

}  // namespace enamel::viewer
