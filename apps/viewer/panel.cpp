// The panel on the left: what a person can set.
#include <imgui.h>

#include <algorithm>
#include <filesystem>

#include "overlay_parts.hpp"
#include "widgets.hpp"

namespace enamel::viewer {
namespace {

void drawViews(const OverlayInput& input, OverlayState& state, float whole) {
  constexpr const char* views[] = {"user", "side", "top", "close", "follow"};
  constexpr int count = 5;
  const int on = static_cast<int>(
      std::find_if(views, views + count, [&](const char* name) { return std::string(name) == input.cameraName; }) -
      views);
  if (const int asked = choice(state, views, count, on, whole,
                               "Where one looks from (1 to 4); follow goes with the contact (5). Right drag turns the "
                               "view, Ctrl+wheel comes nearer.");
      asked >= 0)
    state.asked.actions.push_back(static_cast<Action>(static_cast<int>(Action::camera1) + asked));
}

void drawPlayerControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Player& player = *input.player;
  const RecordingHeader& header = player.header();
  heading("Recording");
  ImGui::TextWrapped("%s", std::filesystem::path(player.path()).filename().c_str());
  remark(format("Renderer %s on %s.", header.renderer.c_str(), input.device.name.c_str()));
  for (const auto& [key, value] : header.parameters) remark(key + " = " + value);
  remark(format("%.3f s, %g ticks a second", static_cast<double>(player.size()) * header.guard.period,
                1.0 / header.guard.period));
  for (const std::string& note : player.notes()) remark(note, kWrong);

  heading("Time");
  actionButtons(state,
                {{"slower", false, Action::slower},
                 {player.playing() ? "pause" : "play", player.playing(), Action::pause},
                 {"faster", false, Action::faster}},
                s, whole);
  actionButtons(state, {{"< tick", false, Action::stepBack}, {"tick >", false, Action::step}}, s, whole);
  actionButtons(state, {{"< event", false, Action::previousEvent}, {"event >", false, Action::nextEvent}}, s, whole);
  remark("An event: a contact begins, or the guard acts.");

  heading("View");
  drawViews(input, state, whole);
  ImGui::Dummy({0, 4 * s});
  remark("Drag the bar below to any time. F1 lists every key.");
}

void drawLiveControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.left.frame;
  drawLiveSettings(input, state, s, whole);

  heading("Time and view");
  actionButtons(
      state,
      {{frame.paused ? "go on" : "pause", frame.paused, Action::pause, "Time stands still, also the hand (Space)."},
       {"1 ms", false, Action::step, "One period of the loop, then pause (Right)."},
       {frame.slowdown == 1 ? "slower" : format("1:%d", frame.slowdown), frame.slowdown != 1, Action::slower,
        "Slow motion down to 1:1000: - is slower, + is faster."}},
      s, whole);
  drawViews(input, state, whole);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::BeginCombo("##scene", input.scene.name.c_str())) {
    for (std::size_t i = 0; i < input.scene.names.size(); ++i)
      if (ImGui::Selectable(input.scene.names[i].c_str(), i == input.scene.index)) state.asked.scene = i;
    ImGui::EndCombo();
  }
  tip(state,
      "What the tool can touch. Drop a scan (PLY, OBJ, STL, OFF) or a scene file on the window to touch your own.");
  for (const std::string& note : state.sceneNotes) remark(note);
  ImGui::Dummy({0, 4 * s});
  remark("Drag moves the hand, the wheel presses it into the wall. F1 lists every key.");
}

}  // namespace

void drawPanel(const Layout& layout, const OverlayInput& input, OverlayState& state) {
  ImGui::SetNextWindowPos({layout.panel.x, layout.panel.y});
  ImGui::SetNextWindowSize({layout.panel.width, layout.panel.height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  const float whole = ImGui::GetContentRegionAvail().x;
  state.controls.clear();
  (input.player != nullptr ? drawPlayerControls : drawLiveControls)(input, state, layout.scale, whole);
  ImGui::End();
}

}  // namespace enamel::viewer
