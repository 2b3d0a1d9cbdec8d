// The panel on the left: settings.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"
#include "widgets.hpp"

namespace enamel::viewer {
namespace {

void drawViews(const OverlayInput& input, OverlayState& state, float whole) {
  constexpr const char* views[] = {"field", "device", "side", "top", "follow"};
  const int asked = choice(state, views, 5, input.view, whole,
                           "Position of the camera: operating field, whole device, its side and top (keys 1 to 4), or "
                           "follow the contact (5). Drag beside the tool to turn the view; the wheel zooms.");
  if (asked >= 0) state.asked.actions.push_back(static_cast<Action>(static_cast<int>(Action::cameraField) + asked));
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
  remark("Event: a contact begins, or the guard acts.");

  heading("View");
  drawViews(input, state, whole);
  ImGui::Dummy({0, 4 * s});
  remark("Drag the bar below to any time. F1 lists every key.");
}

void drawLiveDevice(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Snapshot now = input.live->snapshot();
  heading("Device");
  ImGui::TextWrapped("%s", input.live->url().c_str());
  remark(format("Renderer %s on %s.", input.live->renderer().c_str(), input.device.name.c_str()));
  remark(now.enabled ? "The device is enabled." : "The device is not enabled: no forces.",
         now.enabled ? kMuted : kWrong);
  const Measurement& m = now.tick.measurement;
  if (isLostIn(m, input.live->period())) remark("The device is lost. The viewer waits for it.", kWrong);
  for (const DeviceCondition each : {kForcesCut, kUncalibrated})
    if ((m.conditions & each) != 0) remark(std::string(toString(each)) + ".", kWrong);
  std::string reported = format("Buttons: 0x%x.", m.buttons);
  if (m.gripper) reported += format(" Gripper: %.2f rad.", *m.gripper);
  if (m.heat > 0.0) reported += format(" Hottest motor: %.0f %% of its limit.", 100.0 * m.heat);
  remark(reported);
  if (now.fault != GuardReason::none) remark("Stopped by the guard: " + guardText(now.fault) + ".", kWrong);
  actionButtons(state, {{"continue", false, Action::reset, "Continue after a fault of the guard (Backspace)."}}, s,
                whole);

  heading("View");
  drawViews(input, state, whole);
  for (const std::string& note : state.sceneNotes) remark(note);
  ImGui::Dummy({0, 4 * s});
  remark("Your hand on the device moves the tool. F1 lists every key.");
}

// Return whether a shown tool uses this linked renderer.
bool shows(const OverlayInput& input, RendererSlot slot) {
  return (input.left.frame.selected == slot || (input.right && input.right->frame.selected == slot)) &&
         !isPlugin(input, indexOf(slot));
}

constexpr const char* kRendererTip[kMaxRenderers] = {
    "A servo pushes the tool out of the wall as hard as necessary, up to the limits of the motors. It never pulls, so "
    "the tool slides.",
    "The conventional wall: a spring and a damper.\nforce = stiffness x depth + wall damping x speed inwards",
    "The paper's servo: it holds the pose of the first touch with all joints. The tool cannot slide.\n"
    "torque = -K (state - state of first touch)",
    "The spring with passivity control: a damper removes the energy that the spring would return in excess of what it "
    "received (Hannaford and Ryu 2002).",
    "A renderer from a plugin (--renderer)."};

void drawRendererChoice(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.left.frame;
  const float half = 0.5f * (whole - 6 * s), third = (whole - 12 * s) / 3.0f;
  const bool split = input.right.has_value();
  const auto choose = [&](RendererSlot selected, unsigned side, std::optional<RendererSlot>& asked) {
    ImGui::PushID(&asked);
    for (std::size_t slot = 0; slot < rendererCount(input); ++slot) {
      if (slot % 2 == 1) ImGui::SameLine(0, 6 * s);
      const std::string name = isPlugin(input, slot) ? input.device.plugin->description().name : titleOf(input, slot);
      if (toggle(name.c_str(), indexOf(selected) == slot, half, split ? side : slotColour(slot)))
        asked = static_cast<RendererSlot>(slot);
      tip(state, kRendererTip[isPlugin(input, slot) ? indexOf(RendererSlot::plugin) : slot]);
    }
    ImGui::PopID();
  };
  heading(split ? "Left tool" : "Renderer");
  if (!input.bur) {
    ImGui::SameLine(whole - third);
    ImGui::PushFont(gFonts.small);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, s});  // not higher than the heading
    if (toggle("split  (V)", split, third)) state.asked.actions.push_back(Action::split);
    ImGui::PopStyleVar();
    ImGui::PopFont();
    tip(state, "Two tools, two renderers, one hand: which one feels stiffer?");
  }
  choose(frame.selected, split ? sideColour(input, 0) : 0, state.asked.renderer);
  if (!split) return;
  heading("Right tool");
  choose(input.right->frame.selected, sideColour(input, 1), state.asked.right);
}

void drawRendererSettings(const OverlayInput& input, OverlayState& state) {
  const Frame& frame = input.left.frame;
  Settings& settings = state.settings;
  if (shows(input, RendererSlot::impedance) || shows(input, RendererSlot::passivity)) {
    state.asked.settings |= slider(state, settings.spring.stiffness,
                                   {"stiffness", "%.0f", "N/m", 200, 20000,
                                    "Stiffness of the wall's spring: force for each metre of depth.\nforce = stiffness "
                                    "x depth + damping x speed"});
    if (input.right) return;
    state.asked.settings |=
        slider(state, settings.spring.damping,
               {"wall damping", "%.1f", "N s/m", 0, 20,
                "Damping of the wall: force for each m/s of speed inwards.\nforce = stiffness x depth + damping x "
                "speed"});
    const double required = requiredDamping(settings.spring, kPeriod);
    const bool late = settings.delay.high > 0, met = settings.toolDamping > required && !late;
    remark(
        format(
            met ? "Passive: the tool's damping, %.1f, is more than the %.1f N s/m that this wall requires."
            : late
                ? "May vibrate: the tool's damping is %.1f. With a delay, the %.1f N s/m of this wall do not suffice."
                : "May vibrate: the tool's damping, %.1f, must be more than the %.1f N s/m that this wall requires.",
            settings.toolDamping, required),
        met ? kMuted : kWrong);
    tip(state,
        "With a period of T = 1 ms the wall returns more energy than it receives, unless the device has this damping "
        "(Colgate and Brown 1994; the paper's equation 16).\ntool damping > stiffness x T / 2 + wall damping, without "
        "a delay");
    return;
  }
  if (input.right) return;
  if (isPlugin(input, indexOf(frame.selected))) {
    const EnamelDescription& plugin = input.device.plugin->description();
    remark(format("Plugin %s %s: %s", plugin.name, plugin.version, plugin.summary));
    const double given = deliveredOf(frame.readout.force, frame.record.nearest).normal, told = frame.record.normalForce;
    const bool silent = told == 0.0 && std::abs(given) > 0.5;
    if (frame.record.guard == GuardReason::none)
      remark("Normal force that it reports: " + (silent ? "not reported" : tenths(told) + " N") + ".");
  } else if (frame.selected == RendererSlot::hold) {
    state.asked.settings |= ImGui::Checkbox("release when pulled", &settings.hold.release);
    tip(state, "On: the servo releases a tool that is pulled off. Off: the tool sticks to the wall.");
    state.asked.settings |= ImGui::Checkbox("anti-windup", &settings.hold.antiWindup);
    tip(state,
        "While a motor is at its limit, the servo's integrators stop. Otherwise the servo would push too long "
        "afterwards.");
    remark("It holds the pose of the first touch: the tool cannot slide.");
  } else {
    remark("It pushes out of the wall and never pulls: the tool slides.");
    if (!(frame.control.deviation > 0.0)) return;  // before the first tick
    const double mass = 100.0 * frame.control.mass, factor = std::exp(1.96 * frame.control.deviation);
    remark(format("Estimated mass of the tool: %.0f to %.0f %% of the model's.", mass / factor, mass * factor));
    tip(state,
        format("95 %% interval, from the motion of the tool and the torque of the motors. Ignored samples, which "
               "no push explains: %.0f.",
               frame.control.ignored)
            .c_str());
  }
}

void drawHand(const OverlayInput& input, OverlayState& state, float s, float whole) {
  constexpr float most = 15.0f;  // N, as kLargestHandForce
  const Frame& frame = input.left.frame;
  const Contact& nearest = frame.record.nearest;
  const auto ask = [&state](Action action) { state.asked.actions.push_back(action); };
  heading("Hand");
  label("press into the wall");
  const Vec3 stretch = frame.hand.target - frame.record.pose.position + nearest.gap * nearest.normal;
  float press = std::clamp(static_cast<float>(-nearest.normal.dot(stiffnessOf(frame.hand.grip).cwiseProduct(stretch))),
                           0.0f, most);
  const float lift = 0.3f * whole;
  ImGui::SetNextItemWidth(whole - lift - 6 * s);
  if (ImGui::SliderFloat("##press", &press, 0.0f, most, "%.1f N", ImGuiSliderFlags_NoInput))
    state.asked.press = static_cast<double>(press);
  note(state, "press");
  tip(state,
      "Force of the hand into the nearest wall, N, if the wall does not give way (also Ctrl+wheel, or E and Q).\n"
      "force = grip x (hand - surface)");
  ImGui::SameLine(0, 6 * s);
  if (toggle("lift  (H)", false, lift)) ask(Action::home);
  tip(state, "Moves the hand back to the start, away from the wall (H).");
  if (toggle(frame.testing ? "pushing ..." : "Test push 12 N  (P)", frame.testing, whole)) ask(Action::testPush);
  note(state, "test push");
  tip(state,
      "Puts the tool on the wall, waits until it rests, and pushes with a step of 12 N. The perceived stiffness is "
      "this force divided by the depth at which the tool first reverses.\nK = F / depth at the first return");
  constexpr const char* grips[] = {"grip 40 N/m", "grip 400 N/m"};
  if (choice(state, grips, 2, state.grip.stiffness == kFirmGrip.stiffness ? 1 : 0, whole,
             "Stiffness of the hand: 40 N/m as in the paper, or a firm grip of 400 N/m (G).\n"
             "force = grip x (hand - tool), at most 15 N") >= 0)
    ask(Action::grip);
  state.asked.settings |= slider(state, state.settings.noise,
                                 {"tremor of the hand", "%.2f", "N", 0, 2,
                                  "Random force of the hand along the normal of the wall, N (standard deviation)."});
}

void drawBur(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.left.frame;
  const float third = (whole - 12 * s) / 3.0f;
  const auto ask = [&state](Action action) { state.asked.actions.push_back(action); };
  if (!input.bur) return;
  heading("Bur");
  ImGui::SameLine(whole - third);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 0});  // not higher than the heading
  if (bool sound = state.sound; ImGui::Checkbox("sound  (M)", &sound)) ask(Action::sound);
  ImGui::PopStyleVar();
  if (toggle("spin  (F)", frame.drilled.spins, third)) state.asked.spin = !frame.drilled.spins;
  tip(state, "Pedal of the bur. The removed volume follows Archard's law.\nvolume = wear x force x path / hardness");
  ImGui::SameLine(0, 6 * s);
  if (toggle("undo", false, third)) ask(Action::undo);
  tip(state, "Undo the last stroke of the bur (Ctrl+Z).");
  ImGui::SameLine(0, 6 * s);
  if (toggle("cut open", input.scene.isCutOpen, third)) ask(Action::cutAway);
  tip(state, "Show a section through the tooth along the tool (C).");
  if (state.sound && !state.soundTrouble.empty()) remark(state.soundTrouble, kWrong);
}

void drawDevice(OverlayState& state, float whole) {
  Settings& settings = state.settings;
  heading("Device");
  state.asked.settings |=
      slider(state, settings.extraMass,
             {"added mass", "%.0f", "g", 0, 300, "Mass added to the tool. The renderers do not know it.", 1e3});
  state.asked.settings |=
      slider(state, settings.friction,
             {"joint friction", "%.1f", "mN m s/rad", 0, 20,
              "Viscous friction in every joint, added to that of the device file.\ntorque = -friction x "
              "speed of the joint",
              1e3});
  state.asked.settings |=
      slider(state, settings.toolDamping,
             {"tool damping", "%.1f", "N s/m", 0, 20,
              "Viscous damping of the tool everywhere, added to that of the device file.\nforce = -damping x "
              "speed"});
  ImGui::AlignTextToFramePadding();
  label("delay, ms");
  ImGui::SameLine(0.32f * whole);
  constexpr Delay delays[] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 3}};
  constexpr const char* names[] = {"0", "1", "2", "3", "0-3"};
  int now = -1;
  for (int i = 0; i < 5; ++i)
    if (settings.delay.low == delays[i].low && settings.delay.high == delays[i].high) now = i;
  const int delay = choice(state, names, 5, now, ImGui::GetContentRegionAvail().x,
                           "Delay between a measurement and the torque that answers it: constant, or a random number "
                           "from 0 to 3 in each tick. It makes springs unstable.");
  if (delay >= 0) settings.delay = delays[delay];
  state.asked.settings |= delay >= 0;
  state.asked.settings |= ImGui::Checkbox("angles in encoder counts", &settings.encoders.quantised);
  tip(state, "On: joint angles are rounded to the encoders' steps, as in a real device. Off: they are exact.");
  ImGui::AlignTextToFramePadding();
  label("speeds");
  ImGui::SameLine(0.32f * whole);
  constexpr RateSource sources[] = {RateSource::exact, RateSource::difference, RateSource::lowPass};
  constexpr const char* rates[] = {"exact", "steps", "filtered"};
  const int chosen = static_cast<int>(std::find(sources, sources + 2, settings.encoders.rates) - sources);
  const int rate = choice(state, rates, 3, chosen, ImGui::GetContentRegionAvail().x,
                          "Source of the joint speeds: exact (impossible on a real device), from two angles, or the "
                          "same with a low-pass filter.\nsteps: (angle - previous angle) / 1 ms");
  if (rate >= 0) settings.encoders.rates = sources[rate];
  state.asked.settings |= rate >= 0;
}

void drawRunControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.left.frame;
  drawHand(input, state, s, whole);
  drawBur(input, state, s, whole);
  drawRendererChoice(input, state, s, whole);
  drawDevice(state, whole);

  heading("Time and view");
  actionButtons(
      state,
      {{frame.paused ? "continue" : "pause", frame.paused, Action::pause, "Stop time, also for the hand (Space)."},
       {"1 ms", false, Action::step, "Run one period of the loop, then pause (Right)."},
       {frame.slowdown == 1 ? "slower" : format("1:%d", frame.slowdown), frame.slowdown != 1, Action::slower,
        "Slow motion down to 1:1000: - is slower, + is faster."}},
      s, whole);
  drawViews(input, state, whole);
  ImGui::SetNextItemWidth(-1.0f);
  const bool wasOpen = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId),
             isOpen = ImGui::BeginCombo("##scene", input.scene.name.c_str());
  note(state, "scene");
  if (isOpen) {
    if (wasOpen && !state.list) ImGui::CloseCurrentPopup();
    for (std::size_t i = 0; i < input.scene.names.size(); ++i)
      if (ImGui::Selectable(input.scene.names[i].c_str(), i == input.scene.index)) state.asked.scene = i;
    ImGui::EndCombo();
  }
  state.list = isOpen;
  tip(state,
      "Scene of objects that the tool can touch. Drop a scan (PLY, OBJ, STL, OFF) or a scene file on the window to add "
      "your own.");
  if (!state.scanNote.empty()) {
    remark(state.scanNote);
    actionButtons(state,
                  {{"turn x", false, Action::turnX, "Turn the scan by 90 deg about x, to the right (X)."},
                   {"turn y", false, Action::turnY, "Turn the scan by 90 deg about y, upwards (Y)."},
                   {"turn z", false, Action::turnZ, "Turn the scan by 90 deg about z, towards you (Z)."}},
                  s, whole);
    actionButtons(state,
                  {{"unit", false, Action::scanUnit, "Read the file in the next unit: mm, m, um (U)."},
                   {"save as scene", false, Action::saveScene, "Write a scene file (Ctrl+S)."}},
                  s, whole);
  }
  for (const std::string& note : state.sceneNotes) remark(note);
  // At the end, because its height varies: nothing moves under the mouse.
  drawRendererSettings(input, state);
  remark("Drag the tool, or beside it to turn the view. F1 lists every key.");
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
  const auto draw = input.player != nullptr ? drawPlayerControls
                    : input.live != nullptr ? drawLiveDevice
                                            : drawRunControls;
  draw(input, state, layout.scale, whole);
  ImGui::End();
}

}  // namespace enamel::viewer
