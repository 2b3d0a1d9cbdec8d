// The panel on the left: what a person can set.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

void showTip(OverlayState& state, const char* text) {
  constexpr double patience = 0.35;  // s
  if (state.tip != text) state.tipSince = ImGui::GetTime();
  state.tip = text;
  state.tipSeen = true;
  if (ImGui::GetTime() - state.tipSince < patience) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(20.0f * gFonts.text->FontSize);
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

namespace {

void heading(const char* text) {
  ImGui::Dummy({0, 2});
  ImGui::PushFont(gFonts.bold);
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

void remark(const std::string& text, unsigned rgb = kMuted) {
  ImGui::PushFont(gFonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, tone(rgb));
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

// Where the last item stands.
void note(OverlayState& state, const std::string& name) {
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  state.controls[name] = {0.5f * (low.x + high.x), 0.5f * (low.y + high.y)};
}

// What the last item is for, while the mouse is on it. A formula stands in a line of its own.
void tip(OverlayState& state, const char* text) {
  if (ImGui::IsItemHovered()) showTip(state, text);
}

// What was typed for a value, in the shown unit, or why it is none.
std::optional<double> typedValue(const OverlayState& state, const char* name, const char* unit, double low, double high,
                                 std::string& problem) {
  const char* const text = state.typed.data();
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  const std::string rest(end), blank = " \t";
  const std::size_t word = rest.find_first_not_of(blank);
  const bool onlyUnit = word == std::string::npos || rest.compare(word, std::string::npos, unit) == 0;
  if (end == text || !onlyUnit || !std::isfinite(value))
    problem = format("%s: \"%s\" is no number of %s. It stays as it was.", name, text, unit);
  else if (value < low || value > high)
    problem = format("%s: %s is outside of %g to %g %s. It stays as it was.", name, text, low, high, unit);
  else
    return value;
  return std::nullopt;
}

// A slider with its name above, and its value, which a click lets one type; true when a change is complete. `factor`:
// shown unit per SI unit.
bool slider(OverlayState& state, const char* name, const char* pattern, const char* unit, double& value, double low,
            double high, const char* about, double factor = 1.0) {
  ImGui::PushID(name);
  ImGui::PushFont(gFonts.small);
  ImGui::TextColored(tone(kMuted), "%s", name);
  tip(state, about);
  bool done = false;
  const float field = 110.0f * gFonts.small->FontSize / 13.0f;
  ImGui::SameLine(ImGui::GetContentRegionMax().x - field);
  ImGui::SetNextItemWidth(field);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {4, 0});
  if (state.typedInto == name) {
    if (ImGui::InputText("##typed", state.typed.data(), state.typed.size(),
                         ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll)) {
      std::string problem;
      if (const auto typed = typedValue(state, name, unit, low, high, problem)) {
        value = *typed / factor;
        done = true;
      } else {
        state.problem = problem;
      }
      state.typedInto.clear();
    } else if (ImGui::IsItemDeactivated()) {
      state.typedInto.clear();
    } else if (!ImGui::IsItemActive()) {
      ImGui::SetKeyboardFocusHere(-1);
    }
  } else {
    const std::string shown = format(pattern, value * factor) + " " + unit;
    ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, {1.0f, 0.5f});
    if (ImGui::Button((shown + "##type").c_str(), {field, 0})) {
      state.typedInto = name;
      std::snprintf(state.typed.data(), state.typed.size(), pattern, value * factor);
    }
    ImGui::PopStyleVar();
    note(state, name);
    tip(state, "Click to type a value: Enter takes it, Esc leaves it.");
  }
  ImGui::PopStyleVar();
  ImGui::PopFont();
  float shown = static_cast<float>(value * factor);
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {4, 0});
  if (ImGui::SliderFloat("##value", &shown, static_cast<float>(low), static_cast<float>(high), "",
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput))
    value = static_cast<double>(shown) / factor;
  done |= ImGui::IsItemDeactivatedAfterEdit();
  tip(state, about);
  ImGui::PopStyleVar();
  ImGui::PopID();
  return done;
}

bool toggle(const char* name, bool on, float width, unsigned colour = kChosen) {
  ImGui::PushStyleColor(ImGuiCol_Button, on ? tone(colour) : tone(0xFFFFFF));
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, on ? tone(colour, 0.85) : tone(kLine));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, tone(colour, 0.7));
  ImGui::PushStyleColor(ImGuiCol_Text, on && colour != kSky ? tone(0xFFFFFF) : tone(kInk));
  const bool pressed = ImGui::Button(name, {width, 0});
  ImGui::PopStyleColor(4);
  return pressed;
}
// Whether a tool that is shown has that renderer, linked.
bool shows(const OverlayInput& input, RendererSlot slot) {
  return (input.frame.selected == slot || (input.right != nullptr && input.right->selected == slot)) &&
         !isPlugin(input, indexOf(slot));
}

// A row of buttons of which one is on; the one that was pressed, or -1.
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

void label(const char* name) {
  ImGui::PushFont(gFonts.small);
  ImGui::TextColored(tone(kMuted), "%s", name);
  ImGui::PopFont();
}

void drawViews(const OverlayInput& input, OverlayState& state, float, float whole) {
  constexpr const char* views[] = {"user", "side", "top", "close", "follow"};
  constexpr int count = 5;
  const int on = static_cast<int>(
      std::find_if(views, views + count, [&](const char* name) { return std::string(name) == input.cameraName; }) -
      views);
  if (const int asked = choice(state, views, count, on, whole,
                               "Where one looks from (1 to 4); follow goes with the contact (5). Right drag turns the "
                               "view, Ctrl+wheel comes nearer.");
      asked >= 0)
    state.actions.push_back(static_cast<Action>(static_cast<int>(Action::camera1) + asked));
}

void drawPlayerControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Player& player = *input.player;
  const RecordingHeader& header = player.header();
  const float half = 0.5f * (whole - 6 * s), third = (whole - 12 * s) / 3.0f;
  const auto ask = [&state](Action action) { state.actions.push_back(action); };
  heading("Recording");
  ImGui::TextWrapped("%s", std::filesystem::path(player.path()).filename().c_str());
  remark(format("Renderer %s on %s.", header.renderer.c_str(), input.deviceName.c_str()));
  for (const auto& [key, value] : header.parameters) remark(key + " = " + value);
  remark(format("%.3f s, %g ticks a second", static_cast<double>(player.size()) * header.guard.period,
                1.0 / header.guard.period));
  for (const std::string& note : player.notes()) remark(note, kWrong);

  heading("Time");
  if (toggle("slower", false, third)) ask(Action::slower);
  ImGui::SameLine(0, 6 * s);
  if (toggle(player.playing() ? "pause" : "play", player.playing(), third)) ask(Action::pause);
  ImGui::SameLine(0, 6 * s);
  if (toggle("faster", false, third)) ask(Action::faster);
  if (toggle("< tick", false, half)) ask(Action::stepBack);
  ImGui::SameLine(0, 6 * s);
  if (toggle("tick >", false, half)) ask(Action::step);
  if (toggle("< event", false, half)) ask(Action::previousEvent);
  ImGui::SameLine(0, 6 * s);
  if (toggle("event >", false, half)) ask(Action::nextEvent);
  remark("An event: a contact begins, or the guard acts.");

  heading("View");
  drawViews(input, state, s, whole);
  ImGui::Dummy({0, 4 * s});
  remark("Drag the bar below to any time. F1 lists every key.");
}

constexpr const char* kRendererTip[kMaxRenderers] = {
    "A servo pushes the tool out of the wall as hard as it takes, with what the motors can give. It never pulls, so "
    "the "
    "tool slides.",
    "What most programs do: the wall is a spring.\nforce = stiffness x depth + wall damping x speed inwards",
    "The servo of the paper: it keeps the pose of the first touch, with all six joints. It cannot slide.\n"
    "torque = -K (state - state of first touch)",
    "The spring, with a watch on its energy: it takes away what the spring would give back more than it took "
    "(Hannaford and Ryu 2002).",
    "A renderer that was loaded from a file (--renderer)."};

void drawRendererChoice(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.frame;
  const float half = 0.5f * (whole - 6 * s), third = (whole - 12 * s) / 3.0f;
  const bool split = input.right != nullptr;
  const auto choose = [&](RendererSlot selected, unsigned side, int& asked) {
    ImGui::PushID(&asked);
    for (std::size_t slot = 0; slot < rendererCount(input); ++slot) {
      if (slot % 2 == 1) ImGui::SameLine(0, 6 * s);
      const std::string name = isPlugin(input, slot) ? input.plugin->description().name : kLinkedTitle[slot];
      if (toggle(name.c_str(), indexOf(selected) == slot, half, split ? side : kSlotColour[slot]))
        asked = static_cast<int>(slot);
      tip(state, kRendererTip[isPlugin(input, slot) ? indexOf(RendererSlot::plugin) : slot]);
    }
    ImGui::PopID();
  };
  heading(split ? "Left tool" : "Renderer");
  if (input.bur == nullptr) {
    ImGui::SameLine(whole - third);
    ImGui::PushFont(gFonts.small);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, s});  // no higher than the heading
    if (toggle("split  (V)", split, third)) state.actions.push_back(Action::split);
    ImGui::PopStyleVar();
    ImGui::PopFont();
    tip(state, "Two tools, two renderers, one hand: which one feels stiffer?");
  }
  choose(frame.selected, kSideColour[0], state.rendererAsked);
  if (!split) return;
  heading("Right tool");
  choose(input.right->selected, kSideColour[1], state.rightAsked);
}

void drawRendererSettings(const OverlayInput& input, OverlayState& state) {
  const Frame& frame = input.frame;
  Settings& settings = state.settings;
  if (shows(input, RendererSlot::impedance) || shows(input, RendererSlot::passivity)) {
    state.settingsChanged |=
        slider(state, "stiffness", "%.0f", "N/m", settings.spring.stiffness, 200, 20000,
               "Of the wall's spring: newtons for each metre of depth.\nforce = stiffness x depth + damping x speed");
    if (input.right != nullptr) return;
    state.settingsChanged |= slider(state, "wall damping", "%.1f", "N s/m", settings.spring.damping, 0, 20,
                                    "Of the wall: newtons for each m/s inwards.\nforce = stiffness x depth + damping x "
                                    "speed");
    const double required = requiredDamping(settings.spring, kPeriod);
    const bool late = settings.delay.high > 0, met = settings.toolDamping > required && !late;
    remark(
        format(met ? "Safe: the tool's damping of %.1f is more than the %.1f N s/m that this wall needs."
               : late
                   ? "May vibrate: the tool's damping is %.1f, and the %.1f N s/m that this wall needs are not enough "
                     "with a delay."
                   : "May vibrate: the tool's damping of %.1f is not more than the %.1f N s/m that this wall needs.",
               settings.toolDamping, required),
        met ? kMuted : kWrong);
    tip(state,
        "A wall of a loop that runs every T = 1 ms gives back energy unless the device brakes as much "
        "(Colgate and Brown 1994; the paper's equation 16).\ntool damping > stiffness x T / 2 + wall damping, without "
        "a delay");
    return;
  }
  if (input.right != nullptr) return;
  if (isPlugin(input, indexOf(frame.selected))) {
    const EnamelDescription& plugin = input.plugin->description();
    remark(format("Plugin %s %s: %s", plugin.name, plugin.version, plugin.summary));
    const double given = deliveredOf(frame.record).normal, told = frame.record.normalForce;
    const bool silent = told == 0.0 && std::abs(given) > 0.5;
    if (frame.record.guard == GuardReason::none)
      remark("Its own word of the normal force: " + (silent ? "not reported" : tenths(told) + " N") + ".");
  } else if (frame.selected == RendererSlot::hold) {
    state.settingsChanged |= ImGui::Checkbox("let go when pulled", &settings.hold.release);
    tip(state, "Off, the tool sticks to the wall: the servo also pulls it back.");
    state.settingsChanged |= ImGui::Checkbox("spare the motors' limits", &settings.hold.antiWindup);
    tip(state,
        "While a motor is at its limit the servo's sum of past errors does not grow (anti-windup), or it would push on "
        "long after.");
    remark("Holds the pose of first touch: it cannot slide.");
  } else {
    remark("Pushes out of the wall, never pulls: the tool slides.");
    remark(format("It has learnt that the tool has %.0f %% of the model's mass.", 100.0 / frame.inertiaScale));
    tip(state, format("From how the tool answers to what the motors do. So far %.0f sudden changes of the hand's push "
                      "were seen, which it leaves out.",
                      frame.jumps)
                   .c_str());
    const SurfaceServoOptions* file = input.surface;
    if (file != nullptr && (file->delayLow != settings.delay.low || file->delayHigh != settings.delay.high))
      remark(format("Its file is for a delay of %d to %d ms.", file->delayLow, file->delayHigh), kWrong);
  }
}

void drawHandAndBur(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.frame;
  const float third = (whole - 12 * s) / 3.0f;
  const auto ask = [&state](Action action) { state.actions.push_back(action); };
  heading("Hand");
  constexpr const char* grips[] = {"40 N/m", "400 N/m"};
  if (choice(state, grips, 2, state.grip.stiffness == kFirmGrip.stiffness ? 1 : 0, whole,
             "How firmly the hand holds the tool: 40 N/m as in the paper, or a firm grip (G).\n"
             "force = grip x (hand - tool), at most 15 N") >= 0)
    ask(Action::grip);
  if (toggle(frame.testing ? "pushing ..." : "Test push 12 N  (P)", frame.testing, whole)) ask(Action::testPush);
  note(state, "test push");
  tip(state,
      "Puts the tool on the wall, waits until it rests, and pushes with 12 N at once. The stiffness that one feels is "
      "that force over how deep the tool goes before it first comes back.\nK = F / depth at the first return");
  state.settingsChanged |= slider(state, "tremor of the hand", "%.2f", "N", state.settings.noise, 0, 2,
                                  "A random force of the hand into the wall and out of it, N (standard deviation).");
  if (input.bur == nullptr) return;
  heading("Bur");
  ImGui::SameLine(whole - third);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 0});  // no higher than the heading
  if (bool sound = state.sound; ImGui::Checkbox("sound  (M)", &sound)) ask(Action::sound);
  ImGui::PopStyleVar();
  if (toggle("spin  (F)", frame.drilled.spins, third)) state.spinAsked = !frame.drilled.spins;
  tip(state, "The pedal. Removed volume follows Archard's law.\nvolume = wear x force x path / hardness");
  ImGui::SameLine(0, 6 * s);
  if (toggle("undo", false, third)) ask(Action::undo);
  tip(state, "What the last stroke took comes back (Ctrl+Z).");
  ImGui::SameLine(0, 6 * s);
  if (toggle("cut open", input.isCutOpen, third)) ask(Action::cutAway);
  tip(state, "A section through the tooth along the tool (C).");
  if (state.sound && !state.soundTrouble.empty()) remark(state.soundTrouble, kWrong);
}

void drawDevice(OverlayState& state, float whole) {
  Settings& settings = state.settings;
  heading("Device");
  state.settingsChanged |= slider(state, "added mass", "%.0f", "g", settings.extraMass, 0, 300,
                                  "Screwed to the tool without telling the renderers.", 1e3);
  state.settingsChanged |= slider(state, "joint friction", "%.1f", "mN m s/rad", settings.friction, 0, 20,
                                  "Viscous, in every joint, beyond that of the device file.\ntorque = -friction x "
                                  "speed of the joint",
                                  1e3);
  state.settingsChanged |= slider(state, "tool damping", "%.1f", "N s/m", settings.toolDamping, 0, 20,
                                  "Brakes the tool wherever it is, beyond the device file's.\nforce = -damping x "
                                  "speed");
  label("delay, ms");
  constexpr Delay delays[] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 3}};
  constexpr const char* names[] = {"0", "1", "2", "3", "0-3"};
  int now = -1;
  for (int i = 0; i < 5; ++i)
    if (settings.delay.low == delays[i].low && settings.delay.high == delays[i].high) now = i;
  const int delay = choice(state, names, 5, now, whole,
                           "Between a measurement and the torque that answers it: so many periods of 1 ms, or a random "
                           "number from 0 to 3 every time. Springs get unstable with it.");
  if (delay >= 0) settings.delay = delays[delay];
  state.settingsChanged |= delay >= 0;
  state.settingsChanged |= ImGui::Checkbox("angles in encoder counts", &settings.encoders.quantised);
  tip(state, "Joint angles are known only in the encoders' steps, as in a real device; off: exactly.");
  label("speeds of the joints");
  constexpr RateSource sources[] = {RateSource::exact, RateSource::difference, RateSource::lowPass};
  constexpr const char* rates[] = {"exact", "from steps", "filtered"};
  const int chosen = static_cast<int>(std::find(sources, sources + 2, settings.encoders.rates) - sources);
  const int rate = choice(state, rates, 3, chosen, whole,
                          "How the loop knows them: exactly (no real device does), from two angles, or so and "
                          "smoothed.\nfrom steps: (angle - angle before) / 1 ms");
  if (rate >= 0) settings.encoders.rates = sources[rate];
  state.settingsChanged |= rate >= 0;
}

void drawLiveControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.frame;
  const float third = (whole - 12 * s) / 3.0f;
  const auto ask = [&state](Action action) { state.actions.push_back(action); };
  drawRendererChoice(input, state, s, whole);
  drawRendererSettings(input, state);
  drawHandAndBur(input, state, s, whole);
  drawDevice(state, whole);

  heading("Time and view");
  if (toggle(frame.paused ? "go on" : "pause", frame.paused, third)) ask(Action::pause);
  tip(state, "Time stands still, also the hand (Space).");
  ImGui::SameLine(0, 6 * s);
  if (toggle("1 ms", false, third)) ask(Action::step);
  tip(state, "One period of the loop, then pause (Right).");
  ImGui::SameLine(0, 6 * s);
  if (toggle(frame.slowdown == 1 ? "slower" : format("1:%d", frame.slowdown).c_str(), frame.slowdown != 1, third))
    ask(Action::slower);
  tip(state, "Slow motion down to 1:1000: - is slower, + is faster.");
  drawViews(input, state, s, whole);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::BeginCombo("##scene", input.sceneName.c_str())) {
    for (int i = 0; i < static_cast<int>(input.scenes.size()); ++i)
      if (ImGui::Selectable(input.scenes[static_cast<std::size_t>(i)].c_str(), i == input.sceneIndex))
        state.sceneAsked = i;
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
