#include "overlay.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

namespace {

void drawHeader(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Frame& frame = input.left.frame;
  const Rect& area = layout.scene;
  const float x = area.x + 18 * s, right = area.x + area.width - 18 * s;
  brush.clear(x, area.y + 10 * s, Brush::width(gFonts.large, input.scene.name), 32 * s);
  brush.text(gFonts.large, x, area.y + 12 * s, kInk, input.scene.name);
  const std::size_t slot = indexOf(frame.selected);
  const Player* const player = input.player;
  const float y = area.y + 46 * s;
  const std::string renderer = player != nullptr ? "Recording of " + player->header().renderer : titleOf(input, slot);
  const std::string who = format("%s on %s", renderer.c_str(), input.device.name.c_str());
  brush.clear(x, y - 3 * s, 16 * s + Brush::width(gFonts.text, who), 24 * s);
  brush.list->AddCircleFilled({x + 5 * s, y + 8.5f * s}, 5 * s, ink(player != nullptr ? kInk : slotColour(slot)));
  brush.text(gFonts.text, x + 16 * s, y, kMuted, who);

  drawStatus(right, area.y + 16 * s, input, frame, brush);
  drawBadges(right, area.y + 72 * s, frame, brush);
  if (player != nullptr) return;  // its time is beside the time bar
  std::string time = format("%.3f s", input.elapsed.simulated);
  if (frame.paused) time += "   paused";
  if (frame.slowdown != 1) time += format("   slow motion 1:%d", frame.slowdown);
  brush.clear(right - Brush::width(gFonts.text, time), y - 3 * s, Brush::width(gFonts.text, time), 24 * s);
  brush.textRight(gFonts.text, right, y, kMuted, time);
}

// Draw a notice in as many lines as it needs.
void drawNotice(const Layout& layout, const std::string& notice, const Brush& brush) {
  const float s = layout.scale, whole = (layout.isSplit() ? 2 : 1) * layout.scene.width;
  const float most = std::min(560 * s, whole - 48 * s);
  const ImFont* const font = gFonts.text;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6f, most, notice.c_str());
  const float wide = size.x + 24 * s, x = layout.scene.x + 0.5f * (whole - wide), y = layout.scene.y + 76 * s;
  brush.list->AddRectFilled({x, y}, {x + wide, y + size.y + 13 * s}, ink(kInk, 0.9), 14 * s);
  brush.list->AddText(font, font->FontSize, {std::round(x + 12 * s), std::round(y + 5 * s)}, ink(0xFFFFFF),
                      notice.c_str(), nullptr, most);
}

}  // namespace

void setUpOverlay(const std::string& font, const std::string& boldFont, float scale) {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  static constexpr ImWchar kDigits[] = {' ', '>', 0xD7, 0xD7, 0};
  const auto load = [&io, scale](const std::string& file, float size, const ImWchar* only = nullptr) {
    if (!file.empty())
      if (ImFont* loaded = io.Fonts->AddFontFromFileTTF(file.c_str(), std::round(size * scale), nullptr, only))
        return loaded;
    ImFontConfig config;
    config.SizePixels = std::round(size * scale);
    return io.Fonts->AddFontDefault(&config);
  };
  gFonts.text = load(font, 15.0f);
  gFonts.small = load(font, 13.0f);
  gFonts.bold = load(boldFont, 15.0f);
  gFonts.large = load(boldFont, 26.0f);
  gFonts.huge = load(boldFont, 52.0f, kDigits);
  io.Fonts->Build();

  ImGui::GetStyle() = ImGuiStyle();
  ImGui::StyleColorsLight();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0.0f;
  style.WindowBorderSize = 0.0f;
  style.FrameRounding = 4.0f;
  style.GrabRounding = 4.0f;
  style.FrameBorderSize = 1.0f;
  style.WindowPadding = {14, 8};
  style.ItemSpacing = {6, 4};
  style.FramePadding = {6, 3};
  style.ScrollbarSize = 8;
  style.GrabMinSize = 10;
  style.AntiAliasedLinesUseTex = true;
  style.ScaleAllSizes(scale);
  ImVec4* c = style.Colors;
  c[ImGuiCol_Text] = tone(kInk);
  c[ImGuiCol_WindowBg] = tone(kPaper);
  c[ImGuiCol_PopupBg] = tone(0xFFFFFF);
  c[ImGuiCol_Border] = tone(kLine);
  c[ImGuiCol_FrameBg] = tone(0xFFFFFF);
  c[ImGuiCol_FrameBgHovered] = tone(kGround);
  c[ImGuiCol_FrameBgActive] = tone(kLine);
  c[ImGuiCol_SliderGrab] = tone(kChosen, 0.8);
  c[ImGuiCol_SliderGrabActive] = tone(kChosen);
  c[ImGuiCol_CheckMark] = tone(kChosen);
  c[ImGuiCol_Header] = tone(kChosen, 0.2);
  c[ImGuiCol_HeaderHovered] = tone(kChosen, 0.3);
  c[ImGuiCol_Button] = tone(0xFFFFFF);
  c[ImGuiCol_ButtonHovered] = tone(kLine);
}

namespace {

// Show a hand over the tool: there a drag moves the hand.
void showCursor(const Layout& layout, const OverlayInput& input) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  if (!input.knowsHand() || ImGui::GetIO().WantCaptureMouse) return;
  for (const auto& [pane, frame] :
       {std::pair(&layout.scene, &input.left.frame), {&layout.right, input.right ? &input.right->frame : nullptr}}) {
    if (pane->width <= 0 || at.x < pane->x || at.y < pane->y) continue;
    const Pose& tool = frame->record.pose;
    if (isOnTool(input.camera, {pane->width, pane->height}, {at.x - pane->x, at.y - pane->y},
                 millimetres(tool.position), millimetres(tool.rotation.col(2)) / kMillimetres))
      ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
  }
}

}  // namespace

void drawOverlay(const Layout& layout, const OverlayInput& input, OverlayState& state) {
  state.tip.seen = false;
  state.readouts.clear();
  if (layout.panel.width > 0) drawPanel(layout, input, state);
  const Brush brush{ImGui::GetBackgroundDrawList(), layout.scale};
  if (layout.isSplit() && input.right) {
    drawSplitScreen(layout, input, state, brush);
    if (input.elapsed.tour >= 0.0) drawTour(layout, input.elapsed.tour, brush);
  } else {
    const float s = layout.scale;
    const Rect& scene = layout.scene;
    drawNames(
        scene,
        {{scene.x, scene.y, scene.width, 70 * s}, numbersBox(layout, input), drillBox(layout, input), layout.inset},
        input.camera, input.left.frame, input.knowsHand(), brush);
    drawHeader(layout, input, brush);
    drawNumbers(layout, input, state, brush);
    if (layout.inset.width > 0)
      drawInset({layout, layout.inset, input, input.left, input.trail, false, kNeedle, 0.0}, state, brush);
  }
  if (layout.charts.width > 0) {
    drawChartTitles(layout, input, brush);
    if (layout.gauge.height > 0) drawGauge(layout, input, state, brush);
  }
  showCursor(layout, input);
  if (layout.bar.width > 0) drawTimeBar(layout, input, brush);
  if (input.bur && layout.scene.height >= 420 * layout.scale) drawDrill(layout, input, brush);
  if (state.timing) drawTiming(layout, input, brush);
  drawRecordingPills(layout, input, brush);
  drawTips(layout, input, state);
  if (!state.tip.seen) state.tip.text.clear();
  if (!state.notice.empty()) drawNotice(layout, state.notice, brush);
  if (state.help)
    drawHelp(layout,
             input.player != nullptr ? Source::recording
             : input.live != nullptr ? Source::both
                                     : Source::live,
             Brush{ImGui::GetForegroundDrawList(), layout.scale});
}

}  // namespace enamel::viewer
