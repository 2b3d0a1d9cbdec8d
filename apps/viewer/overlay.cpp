#include "overlay.hpp"

#include <imgui.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <filesystem>

#include "palette.hpp"
#include "tour.hpp"

namespace enamel::viewer {
namespace {

ImFont* gText = nullptr;  // ImGui keeps fonts for the life of its context, of which there is one
ImFont* gSmall = nullptr;
ImFont* gBold = nullptr;
ImFont* gLarge = nullptr;
ImFont* gHuge = nullptr;  // digits

ImU32 ink(unsigned rgb, double alpha = 1.0) {
  return IM_COL32(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255, static_cast<int>(255.0 * alpha));
}

ImVec4 tone(unsigned rgb, double alpha = 1.0) { return ImGui::ColorConvertU32ToFloat4(ink(rgb, alpha)); }

std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));
std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof(text), pattern, arguments);
  va_end(arguments);
  return text;
}

// Never "-0.0".
std::string tenths(double value) { return format("%.1f", std::abs(value) < 0.05 ? 0.0 : value); }

constexpr unsigned kSlotColour[kMaxRenderers] = {kBlue, kOrange, kPurple, kGreen, kSky};
constexpr unsigned kSideColour[] = {kBlue, kPurple};  // of the split screen
constexpr const char* kLinkedTitle[kLinkedRenderers] = {"Position control", "Spring", "Hold (paper)", "Passive spring"};

// ---- drawing primitives ------------------------------------------------------------------------------------------

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
  // So that words can be read where the device stands behind them.
  void clear(float x, float y, float width, float height) const {
    list->AddRectFilled({x - 6 * s, y}, {x + width + 6 * s, y + height}, ink(kGround, 0.8), 6 * s);
  }
  void card(const Area& a, double alpha) const {
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

// ---- controls ----------------------------------------------------------------------------------------------------

void heading(const char* text) {
  ImGui::Dummy({0, 2});
  ImGui::PushFont(gBold);
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

void remark(const std::string& text, unsigned rgb = kMuted) {
  ImGui::PushFont(gSmall);
  ImGui::PushStyleColor(ImGuiCol_Text, tone(rgb));
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

// A slider with its name above; true when a change is complete. `factor`: shown unit per SI unit.
bool slider(const char* name, const char* pattern, double& value, double low, double high, double factor = 1.0) {
  float shown = static_cast<float>(value * factor);
  ImGui::PushID(name);
  ImGui::PushFont(gSmall);
  ImGui::TextColored(tone(kMuted), "%s", name);
  ImGui::PopFont();
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::SliderFloat("##value", &shown, static_cast<float>(low), static_cast<float>(high), pattern,
                         ImGuiSliderFlags_AlwaysClamp))
    value = static_cast<double>(shown) / factor;
  const bool done = ImGui::IsItemDeactivatedAfterEdit();
  ImGui::PopID();
  return done;
}

bool toggle(const char* name, bool on, float width, unsigned colour = kBlue) {
  ImGui::PushStyleColor(ImGuiCol_Button, on ? tone(colour) : tone(0xFFFFFF));
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, on ? tone(colour, 0.85) : tone(kLine));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, tone(colour, 0.7));
  ImGui::PushStyleColor(ImGuiCol_Text, on && (colour == kBlue || colour == kGreen) ? tone(0xFFFFFF) : tone(kInk));
  const bool pressed = ImGui::Button(name, {width, 0});
  ImGui::PopStyleColor(4);
  return pressed;
}

bool isPlugin(const OverlayInput& input, std::size_t slot) {
  return input.plugin != nullptr && indexOf(slotOf(*input.plugin)) == slot;
}

// Whether a tool that is shown has that renderer, linked.
bool shows(const OverlayInput& input, RendererSlot slot) {
  return (input.frame.selected == slot || (input.right != nullptr && input.right->selected == slot)) &&
         !isPlugin(input, indexOf(slot));
}

std::size_t rendererCount(const OverlayInput& input) {
  return isPlugin(input, indexOf(RendererSlot::plugin)) ? kMaxRenderers : kLinkedRenderers;
}

// Never the title of the linked renderer that a plugin stands for.
std::string titleOf(const OverlayInput& input, std::size_t slot) {
  return isPlugin(input, slot) ? format("Plugin %s", input.plugin->description().name)
                               : std::string(kLinkedTitle[slot]);
}

void drawViews(const OverlayInput& input, OverlayState& state, float s, float whole) {
  constexpr const char* views[] = {"user", "side", "top", "close"};
  for (int i = 0; i < 4; ++i) {
    if (i > 0) ImGui::SameLine(0, 4 * s);
    if (toggle(views[i], std::string(input.cameraName) == views[i], (whole - 12 * s) / 4.0f))
      state.actions.push_back(static_cast<Action>(static_cast<int>(Action::camera1) + i));
  }
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
  for (const std::string& note : player.notes()) remark(note, kVermilion);

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

void drawLiveControls(const OverlayInput& input, OverlayState& state, float s, float whole) {
  const Frame& frame = input.frame;
  const float half = 0.5f * (whole - 6 * s), third = (whole - 12 * s) / 3.0f;
  const auto ask = [&state](Action action) { state.actions.push_back(action); };
  Settings& settings = state.settings;

  const bool split = input.right != nullptr;
  const auto choose = [&](RendererSlot selected, unsigned side, int& asked) {
    ImGui::PushID(&asked);
    for (std::size_t slot = 0; slot < rendererCount(input); ++slot) {
      if (slot % 2 == 1) ImGui::SameLine(0, 6 * s);
      const std::string label = isPlugin(input, slot) ? input.plugin->description().name : kLinkedTitle[slot];
      if (toggle(label.c_str(), indexOf(selected) == slot, half, split ? side : kSlotColour[slot]))
        asked = static_cast<int>(slot);
    }
    ImGui::PopID();
  };
  heading(split ? "Left tool" : "Renderer");
  if (input.bur == nullptr) {
    ImGui::SameLine(whole - third);
    ImGui::PushFont(gSmall);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, s});  // no higher than the heading
    if (toggle("split  (V)", split, third)) ask(Action::split);
    ImGui::PopStyleVar();
    ImGui::PopFont();
  }
  choose(frame.selected, kSideColour[0], state.rendererAsked);
  if (split) {
    heading("Right tool");
    choose(input.right->selected, kSideColour[1], state.rightAsked);
  }
  const bool spring = shows(input, RendererSlot::impedance) || shows(input, RendererSlot::passivity);
  if (split) {
    if (spring) state.settingsChanged |= slider("stiffness", "%.0f N/m", settings.spring.stiffness, 200, 20000);
  } else if (isPlugin(input, indexOf(frame.selected))) {
    const EnamelDescription& plugin = input.plugin->description();
    remark(format("Plugin %s %s: %s", plugin.name, plugin.version, plugin.summary));
    const double given = deliveredOf(frame.record).normal, told = frame.record.normalForce;
    const bool silent = told == 0.0 && std::abs(given) > 0.5;
    if (frame.record.guard == GuardReason::none)
      remark("Its own word of the normal force: " + (silent ? "not reported" : tenths(told) + " N") + ".");
  } else if (spring) {
    state.settingsChanged |= slider("stiffness", "%.0f N/m", settings.spring.stiffness, 200, 20000);
    state.settingsChanged |= slider("wall damping", "%.1f N s/m", settings.spring.damping, 0, 20);
    const double required = requiredDamping(settings.spring, kPeriod);
    const bool met = settings.toolDamping > required;
    if (frame.selected == RendererSlot::passivity) remark("Gives back no more energy than it took.");
    remark(format("eq. 16 asks for %.1f N s/m of device damping, the tool has %.1f%s", required, settings.toolDamping,
                  met ? "" : ": not met"),
           met ? kMuted : kVermilion);
  } else if (frame.selected == RendererSlot::hold) {
    state.settingsChanged |= ImGui::Checkbox("let go when pulled", &settings.hold.release);
    state.settingsChanged |= ImGui::Checkbox("anti-windup", &settings.hold.antiWindup);
    remark("Holds the pose of first touch: it cannot slide.");
  } else {
    remark("Pushes out of the wall, never pulls: the tool slides.");
    remark(format("Learnt inertia: %.0f %% of the model's. Jumps of the push: %.0f.", 100.0 / frame.inertiaScale,
                  frame.jumps));
    const SurfaceServoOptions* file = input.surface;
    if (file != nullptr && (file->delayLow != settings.delay.low || file->delayHigh != settings.delay.high))
      remark(format("Its file is for a delay of %d to %d ticks.", file->delayLow, file->delayHigh), kVermilion);
  }

  heading("Hand");
  const bool firm = state.grip.stiffness == kFirmGrip.stiffness;
  if (toggle("40 N/m", !firm, half) && firm) ask(Action::grip);
  ImGui::SameLine(0, 6 * s);
  if (toggle("400 N/m", firm, half) && !firm) ask(Action::grip);
  if (toggle(frame.testing ? "pushing ..." : "Test push 12 N  (P)", frame.testing, whole, kGreen))
    ask(Action::testPush);
  state.settingsChanged |= slider("tremor of the hand", "%.2f N", settings.noise, 0, 2);

  if (input.bur != nullptr) {
    heading("Bur");
    ImGui::SameLine(whole - third);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 0});  // no higher than the heading
    if (bool sound = state.sound; ImGui::Checkbox("sound  (M)", &sound)) ask(Action::sound);
    ImGui::PopStyleVar();
    if (toggle("spin  (F)", frame.drilled.spins, third, kGreen)) state.spinAsked = !frame.drilled.spins;
    ImGui::SameLine(0, 6 * s);
    if (toggle("undo", false, third)) ask(Action::undo);
    ImGui::SameLine(0, 6 * s);
    if (toggle("cut open", input.isCutOpen, third)) ask(Action::cutAway);
    if (state.sound && !state.soundTrouble.empty()) remark(state.soundTrouble, kVermilion);
  }

  heading("Device");
  state.settingsChanged |= slider("added mass", "%.0f g", settings.extraMass, 0, 300, 1e3);
  state.settingsChanged |= slider("joint friction", "%.1f mN m s/rad", settings.friction, 0, 20, 1e3);
  state.settingsChanged |= slider("tool damping", "%.1f N s/m", settings.toolDamping, 0, 20);
  ImGui::PushFont(gSmall);
  ImGui::TextColored(tone(kMuted), "delay, ticks");
  ImGui::PopFont();
  constexpr Delay delays[] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 3}};
  constexpr const char* names[] = {"0", "1", "2", "3", "0-3"};
  for (int i = 0; i < 5; ++i) {
    if (i > 0) ImGui::SameLine(0, 4 * s);
    const bool on = settings.delay.low == delays[i].low && settings.delay.high == delays[i].high;
    if (toggle(names[i], on, (whole - 16 * s) / 5.0f) && !on) {
      settings.delay = delays[i];
      state.settingsChanged = true;
    }
  }
  state.settingsChanged |= ImGui::Checkbox("encoders round to counts", &settings.encoders.quantised);
  ImGui::PushFont(gSmall);
  ImGui::TextColored(tone(kMuted), "joint rates");
  ImGui::PopFont();
  constexpr RateSource sources[] = {RateSource::exact, RateSource::difference, RateSource::lowPass};
  constexpr const char* rates[] = {"exact", "differ.", "low pass"};
  for (int i = 0; i < 3; ++i) {
    if (i > 0) ImGui::SameLine(0, 6 * s);
    const bool on = settings.encoders.rates == sources[i];
    if (toggle(rates[i], on, third) && !on) {
      settings.encoders.rates = sources[i];
      state.settingsChanged = true;
    }
  }

  heading("Time and view");
  if (toggle(frame.paused ? "go on" : "pause", frame.paused, third)) ask(Action::pause);
  ImGui::SameLine(0, 6 * s);
  if (toggle("tick", false, third)) ask(Action::step);
  ImGui::SameLine(0, 6 * s);
  if (toggle(frame.slowdown == 1 ? "slow" : format("1:%d", frame.slowdown).c_str(), frame.slowdown != 1, third))
    ask(Action::slower);
  drawViews(input, state, s, whole);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::BeginCombo("##scene", input.sceneName.c_str())) {
    for (int i = 0; i < static_cast<int>(input.scenes.size()); ++i)
      if (ImGui::Selectable(input.scenes[static_cast<std::size_t>(i)].c_str(), i == input.sceneIndex))
        state.sceneAsked = i;
    ImGui::EndCombo();
  }
  ImGui::Dummy({0, 4 * s});
  remark("Drag moves the hand, the wheel presses it into the wall. F1 lists every key.");
}

void drawPanel(const Layout& layout, const OverlayInput& input, OverlayState& state) {
  ImGui::SetNextWindowPos({layout.panel.x, layout.panel.y});
  ImGui::SetNextWindowSize({layout.panel.width, layout.panel.height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoNav);
  const float whole = ImGui::GetContentRegionAvail().x;
  (input.player != nullptr ? drawPlayerControls : drawLiveControls)(input, state, layout.scale, whole);
  ImGui::End();
}

// ---- over the scene ----------------------------------------------------------------------------------------------

double handForce(const Frame& frame) { return -frame.record.nearest.normal.dot(frame.record.person.head<3>()); }

// What the tool is doing, in a word.
void drawChip(float right, float y, const OverlayInput& input, const Frame& frame, const Brush& brush) {
  const float s = brush.s;
  const Player* const player = input.player;
  const bool contact = frame.record.nearest.gap <= 0.0 || frame.record.mode == RenderMode::contact;
  std::string chip = contact ? "contact" : "free";
  unsigned fill = contact ? kVermilion : kMuted;
  if (frame.testing) chip = "test push", fill = kGreen;
  if (frame.record.status != Status::ok) chip = std::string("fault: ") + toString(frame.record.status), fill = kInk;
  if (frame.record.guard != GuardReason::none)
    chip = std::string("guard: ") + toString(frame.record.guard) +
           (isFault(frame.record.guard) && player == nullptr ? ": select again" : ""),
    fill = kInk;
  if (player != nullptr && player->gap() > 0)
    chip = format("%llu ticks missing here", static_cast<unsigned long long>(player->gap())), fill = kInk;
  if (frame.plant != Status::ok) chip = std::string("stopped: ") + toString(frame.plant), fill = kInk;
  const float chipWidth = Brush::width(gBold, chip) + 20 * s;
  brush.list->AddRectFilled({right - chipWidth, y}, {right, y + 24 * s}, ink(fill), 12 * s);
  brush.text(gBold, right - chipWidth + 10 * s, y + 4 * s, 0xFFFFFF, chip);
}

// What is wrong, each in its pill, from the right.
void drawBadges(float right, float y, const Frame& frame, const Brush& brush) {
  const float s = brush.s;
  const Conditions& c = frame.conditions;
  const std::pair<bool, const char*> badges[] = {
      {c.unstable, "unstable"}, {c.saturated, "saturated"}, {c.slipped, "slipped"}, {c.edge, "edge of workspace"}};
  for (const auto& [on, name] : badges) {
    if (!on) continue;
    const float wide = Brush::width(gSmall, name) + 16 * s;
    brush.list->AddRectFilled({right - wide, y}, {right, y + 20 * s}, ink(kInk), 10 * s);
    brush.text(gSmall, right - wide + 8 * s, y + 3 * s, 0xFFFFFF, name);
    right -= wide + 6 * s;
  }
}

void drawHeader(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Frame& frame = input.frame;
  const Area& area = layout.scene;
  const float x = area.x + 18 * s, right = area.x + area.width - 18 * s;
  brush.clear(x, area.y + 10 * s, Brush::width(gLarge, input.sceneName), 32 * s);
  brush.text(gLarge, x, area.y + 12 * s, kInk, input.sceneName);
  const std::size_t slot = indexOf(frame.selected);
  const Player* const player = input.player;
  const float y = area.y + 46 * s;
  const std::string renderer = player != nullptr ? "Recording of " + player->header().renderer : titleOf(input, slot);
  const std::string who = format("%s on %s", renderer.c_str(), input.deviceName.c_str());
  brush.clear(x, y - 3 * s, 16 * s + Brush::width(gText, who), 24 * s);
  brush.list->AddCircleFilled({x + 5 * s, y + 8.5f * s}, 5 * s, ink(player != nullptr ? kInk : kSlotColour[slot]));
  brush.text(gText, x + 16 * s, y, kMuted, who);

  drawChip(right, area.y + 16 * s, input, frame, brush);
  drawBadges(right, area.y + 72 * s, frame, brush);
  if (player != nullptr) return;  // its time stands at the bar
  std::string time = format("%.3f s", input.simulated);
  if (frame.paused) time += "   paused";
  if (frame.slowdown != 1) time += format("   slow motion 1:%d", frame.slowdown);
  brush.clear(right - Brush::width(gText, time), y - 3 * s, Brush::width(gText, time), 24 * s);
  brush.textRight(gText, right, y, kMuted, time);
}

void drawNumbers(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Frame& frame = input.frame;
  const Area& area = layout.scene;
  const double depth = -1e3 * frame.record.nearest.gap;
  struct Number {
    std::string value;
    const char* unit;
    std::string name;
    unsigned colour;
  };
  const Delivered force = deliveredOf(frame.record);
  const double now = handForce(frame) / std::max(1e-9, -frame.record.nearest.gap);
  const bool inside = depth > 1e-3 && handForce(frame) > 0.0;
  // Beside the inset, as much as there is room for.
  const float room = layout.inset.width > 0 ? layout.inset.x - area.x - 36 * s : area.width;
  const std::string across = tenths(force.tangential), total = tenths(force.total);
  std::string forces = format("normal; tangential %s N, total %s N", across.c_str(), total.c_str());
  if (Brush::width(gSmall, forces) > room) forces = format("tang. %s, total %s N", across.c_str(), total.c_str());
  const Number numbers[] = {
      {depth > -0.0005 ? format("%.3f", std::max(0.0, depth))
       : depth > -0.1  ? format("%.3f", -depth)
                       : format("%.1f", -depth),
       "mm", depth > -0.0005 ? "penetration" : "to the wall", kBlue},
      {tenths(force.normal), "N", forces, kVermilion},
      {tenths(handForce(frame)), "N", "force of the hand", kOrange},
      {!inside     ? "-"
       : now < 1e6 ? format("%.1f", 1e-3 * now)
                   : "> 1000",
       "kN/m", "hand force / depth now", kInk},
  };
  const int count = input.player != nullptr ? 2 : 4;  // a recording does not know the hand
  float y = area.y + area.height - static_cast<float>(count) * 46 * s - 14 * s;
  const float x = area.x + 18 * s;
  float wide = 0.0f;
  for (int i = 0; i < count; ++i) wide = std::max(wide, 12 * s + Brush::width(gSmall, numbers[i].name));
  brush.clear(x, y - 3 * s, wide, area.y + area.height - 5 * s - y);
  for (int i = 0; i < count; ++i) {
    const Number& n = numbers[i];
    brush.list->AddRectFilled({x, y + 3 * s}, {x + 3 * s, y + 38 * s}, ink(n.colour));
    brush.text(gLarge, x + 12 * s, y, kInk, n.value);
    brush.text(gText, x + 18 * s + Brush::width(gLarge, n.value), y + 8 * s, kMuted, n.unit);
    brush.text(gSmall, x + 12 * s, y + 27 * s, kMuted, n.name);
    y += 46 * s;
  }
}

// The inset's section stands on the deepest contact's wall, and on the next one's too where that is near.
Vec3 insetAcross(const Vec3& n, const ContactSnapshot& contacts) {
  constexpr double near = 3e-3;  // m
  const Vec3 vertical = std::abs(n.y()) < 0.95 ? Vec3(0.0, 1.0, 0.0) : Vec3(0.0, 0.0, -1.0);
  const Vec3 usual = vertical.cross(n).normalized();
  if (contacts.count < 2 || contacts.contacts[1].gap > near) return usual;
  const Vec3& next = contacts.contacts[1].normal;
  const Vec3 both = next - n.dot(next) * n;
  if (both.norm() < 0.1) return usual;
  return (both.dot(usual) < 0.0 ? -1.0 : 1.0) * both.normalized();
}

// What lies behind the line through `point` with the outward normal `normal`, of the rectangle from `low` to `high`.
void fillBehind(ImDrawList* list, ImVec2 low, ImVec2 high, ImVec2 point, ImVec2 normal, ImU32 fill) {
  const ImVec2 corners[] = {low, {high.x, low.y}, high, {low.x, high.y}};
  const auto side = [&](ImVec2 p) { return normal.x * (p.x - point.x) + normal.y * (p.y - point.y); };
  for (int i = 0; i < 4; ++i) {
    const ImVec2 a = corners[i], b = corners[(i + 1) % 4];
    const float da = side(a), db = side(b);
    if (da <= 0.0f) list->PathLineTo(a);
    if ((da <= 0.0f) != (db <= 0.0f)) {
      const float share = da / (da - db);
      list->PathLineTo({a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)});
    }
  }
  list->PathFillConvex(fill);
}

std::string materialText(const Material& material) {
  std::string text = "no friction";
  if (material.friction > 0.0) text = format("friction %g", material.friction);
  if (material.sliding < material.friction) text += format(", sliding %g", material.sliding);
  if (std::isfinite(material.stiffness)) text += ", " + stiffnessText(material.stiffness);
  return text;
}

// What an inset shows.
struct InsetView {
  const Area& area;
  const Frame& frame;
  bool ghost;
  Vec3 ghostPosition;
  const std::vector<Vec3>& trail;
  bool half;      // of the split screen: at one fixed scale, and its head says whose it is
  unsigned tool;  // its colour
};

// The contacts, seen along the walls, magnified: the deepest one's wall below, the tool above, whatever the normal.
void drawInset(const InsetView& view, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  constexpr int kHalfStep = 6;  // of the split screen: what a spring of 6 kN/m sinks under 12 N fills its half
  constexpr double steps[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0};  // mm a bar
  constexpr int kSteps = 9, kCircleSides = 256;
  const float s = brush.s;
  const Area& area = view.area;
  const Frame& frame = view.frame;
  const Contact& contact = frame.record.nearest;
  const Vec3 n = contact.normal;
  const Vec3 across = insetAcross(n, frame.contacts);
  // Everything is shown where the tool's nearest point is, not its TCP.
  const Vec3 tool = contact.point, fromTcp = tool - frame.record.pose.position;
  const Vec3 reference = view.ghostPosition + fromTcp;
  const Vec3 surface = tool - contact.gap * n;
  const Vec3 origin = view.ghost ? reference - n * n.dot(reference - surface) : surface;
  const float bar = 46 * s;

  const Vec3 offset = tool - origin;
  const double reach = 1e3 * std::max(std::abs(n.dot(offset)), 0.6 * std::abs(across.dot(offset)));
  int step = kHalfStep;
  if (!view.half) {
    int wanted = 0;
    while (wanted < kSteps - 1 && reach * bar / steps[wanted] > 70 * s) ++wanted;
    state.insetPatience = wanted < state.insetStep ? state.insetPatience + 1 : 0;
    if (wanted > state.insetStep || state.insetPatience > 20) state.insetStep = wanted;
    step = state.insetStep;
  }
  const double perMillimetre = static_cast<double>(bar) / steps[step];

  const float cx = area.x + 0.5f * area.width, cy = area.y + (view.half ? 0.45f : 0.56f) * area.height;
  const auto at = [&](const Vec3& point) {
    const Vec3 d = 1e3 * (point - origin);
    return ImVec2(cx + static_cast<float>(std::clamp(perMillimetre * across.dot(d), -1e4, 1e4)),
                  cy - static_cast<float>(std::clamp(perMillimetre * n.dot(d), -1e4, 1e4)));
  };
  if (view.half)
    brush.list->AddRectFilled({area.x, area.y}, {area.x + area.width, area.y + area.height}, ink(kPaper));
  else
    brush.card(area, 1.0);
  const float top = area.y + 26 * s, bottom = area.y + area.height - s;
  brush.list->PushClipRect({area.x + s, top}, {area.x + area.width - s, bottom}, true);
  // The wall, with a grid of one bar.
  brush.list->AddRectFilled({area.x, cy}, {area.x + area.width, bottom}, ink(kEnamel));
  for (float x = std::fmod(cx - area.x, bar) + area.x; x < area.x + area.width; x += bar)
    brush.list->AddLine({x, cy}, {x, bottom}, ink(kEnamelGrid, 0.6), s);
  for (float y = cy + bar; y < bottom; y += bar)
    brush.list->AddLine({area.x, y}, {area.x + area.width, y}, ink(kEnamelGrid, 0.6), s);
  brush.list->AddLine({area.x, cy}, {area.x + area.width, cy}, ink(kEnamelEdge), 2 * s);
  // The other contacts' walls, as planes, where they cross the inset.
  for (int i = 1; i < frame.contacts.count; ++i) {
    const Contact& other = frame.contacts.contacts[i];
    const float mx = static_cast<float>(across.dot(other.normal)), my = static_cast<float>(-n.dot(other.normal));
    const float length = std::hypot(mx, my);
    // The section lies along this wall, or it is the deepest one's, a little further on.
    if (length < 0.1f || n.dot(other.normal) > 0.9) continue;
    const ImVec2 foot = at(other.point - other.gap * other.normal);
    fillBehind(brush.list, {area.x, top}, {area.x + area.width, bottom}, foot, {mx, my}, ink(kEnamel));
    const float far = 2 * area.width / length;
    brush.list->AddLine({foot.x - far * my, foot.y + far * mx}, {foot.x + far * my, foot.y - far * mx},
                        ink(kEnamelEdge), 2 * s);
  }
  // Normal.
  brush.list->AddLine({cx, cy}, {cx, top}, ink(kMuted, 0.6), s);

  const auto wedge = [&](ImVec2 apex, ImU32 fill, ImU32 outline) {
    const float height = std::max(apex.y - top + 4 * s, 20 * s), wide = 0.17f * height;
    const ImVec2 a{apex.x - wide, apex.y - height}, b{apex.x + wide, apex.y - height};
    if (fill != 0) brush.list->AddTriangleFilled(apex, a, b, fill);
    if (outline != 0) {
      brush.list->AddLine(apex, a, outline, 1.5f * s);
      brush.list->AddLine(apex, b, outline, 1.5f * s);
    }
  };
  const ImVec2 tip = at(tool);
  for (std::size_t i = 1; i < view.trail.size(); ++i)
    brush.list->AddLine(at(view.trail[i - 1] + fromTcp), at(view.trail[i] + fromTcp),
                        ink(kBlue, static_cast<double>(i) / static_cast<double>(view.trail.size())), 1.5f * s);
  const auto drawTool = [&](ImVec2 lowest, ImU32 fill, ImU32 outline) {
    if (input.toolRadius == 0.0) return wedge(lowest, fill, outline);
    const float radius = static_cast<float>(1e3 * input.toolRadius * perMillimetre);
    const ImVec2 centre{lowest.x, lowest.y - radius};
    if (fill != 0) brush.list->AddCircleFilled(centre, radius, fill, kCircleSides);
    if (outline != 0) brush.list->AddCircle(centre, radius, outline, kCircleSides, 1.5f * s);
  };
  drawTool(tip, ink(view.tool, view.half ? 1.0 : 0.88), 0);
  if (view.ghost) {
    const ImVec2 rest = at(reference);
    const unsigned outline = view.half ? kInk : kBlue;
    drawTool(rest, 0, ink(outline));
    brush.list->AddCircle(rest, 4 * s, ink(outline), 0, 1.5f * s);
  }
  // Away from the wall, or, where the motors pull, into it.
  const double force = deliveredOf(frame.record).normal, out = force > 0.0 ? 1.0 : -1.0;
  const auto forceLength = static_cast<float>(out * (std::min(4.0 * std::abs(force), 80.0) + 8.0)) * s;
  if (std::abs(force) > 0.05 && (frame.record.mode == RenderMode::contact || contact.gap <= 0.0))
    brush.arrow({tip.x, tip.y}, {tip.x, tip.y - forceLength}, kVermilion, 3 * s);
  const double pressed = handForce(frame);
  if (pressed > 0.05) {
    const float from = std::max(top, tip.y - 118 * s);
    const float length = static_cast<float>(std::clamp(3.0 * pressed, 0.0, 50.0)) * s + 8 * s;
    brush.arrow({tip.x - 26 * s, from}, {tip.x - 26 * s, from + length}, kOrange, 3 * s);
  }
  bool labelled = false;  // the next deepest: more numbers would hide each other
  for (int i = 1; i < frame.contacts.count; ++i) {
    const Contact& other = frame.contacts.contacts[i];
    if (other.gap > 0.0) continue;
    const ImVec2 foot = at(other.point - other.gap * other.normal);
    brush.list->AddLine(at(other.point), foot, ink(kInk), 1.5f * s);
    brush.list->AddCircleFilled(foot, 3 * s, ink(kVermilion));
    if (labelled) continue;
    labelled = true;
    const std::string text = format("%.3f mm", -1e3 * other.gap);
    const bool right = across.dot(other.normal) < 0.0;  // within its wall
    brush.text(gSmall, foot.x + (right ? 8 * s : -8 * s - Brush::width(gSmall, text)), foot.y - 7 * s, kInk, text);
  }
  // Dimension of the depth.
  const double depth = -1e3 * frame.record.nearest.gap;
  if (depth > 5e-4) {
    const float x = cx + 62 * s, y = tip.y;
    brush.list->AddLine({tip.x, y}, {x + 5 * s, y}, ink(kInk, 0.5), s);
    brush.list->AddLine({x, cy}, {x, y}, ink(kInk), 1.5f * s);
    brush.list->AddLine({x - 4 * s, cy}, {x + 4 * s, cy}, ink(kInk), 1.5f * s);
    brush.list->AddLine({x - 4 * s, y}, {x + 4 * s, y}, ink(kInk), 1.5f * s);
    const std::string text = format("%.3f mm", depth);
    brush.text(gText, std::min(cx + 40 * s, area.x + area.width - 6 * s - Brush::width(gText, text)),
               std::min(std::max(y, cy) + 4 * s, bottom - 20 * s), kInk, text);
  }
  brush.list->PopClipRect();

  brush.text(
      gBold, area.x + 10 * s, area.y + 6 * s, kInk,
      frame.contacts.count > 1 && frame.contacts.contacts[1].gap <= 0.0 ? "Contacts, magnified" : "Contact, magnified");
  const float bx = area.x + 12 * s, by = area.y + area.height - 12 * s;
  brush.list->AddLine({bx, by}, {bx + bar, by}, ink(kInk), 2 * s);
  brush.list->AddLine({bx, by - 4 * s}, {bx, by + 4 * s}, ink(kInk), 1.5f * s);
  brush.list->AddLine({bx + bar, by - 4 * s}, {bx + bar, by + 4 * s}, ink(kInk), 1.5f * s);
  brush.text(gSmall, bx, by - 19 * s, kInk, format("%g mm", steps[step]));
  const std::string material = materialText(contact.material);
  const float right = area.x + area.width - 10 * s, left = right - Brush::width(gSmall, material);
  brush.list->AddRectFilled({left - 4 * s, by - 7 * s}, {right + 4 * s, by + 9 * s}, ink(kEnamel, 0.9));
  brush.text(gSmall, left, by - 7 * s, kInk, material);
}

void drawChartTitles(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const TickRecord& record = input.frame.record;
  const TorqueStyle& torques = input.torques;
  const std::string values[] = {format("%.3f mm", std::max(0.0, -1e3 * record.nearest.gap)),
                                tenths(deliveredOf(record).normal) + " N",
                                format(torques.shares ? "%.0f %%" : "%.2f N m",
                                       record.torque.cwiseProduct(torques.factor).cwiseAbs().maxCoeff())};
  const std::string limits[] = {"paper's bound 1 mm", format("motors allow %.0f N", input.limit.largestForce),
                                torques.shares ? "share of each joint's limit" : format("limit %g N m", torques.limit)};
  const char* names[] = {"Penetration", "Normal force", "Joint torques"};
  for (std::size_t i = 0; i < kCharts; ++i) {
    const Area& a = layout.chart[i];
    const float x = a.x + 14 * s;
    brush.text(gBold, x, a.y + 6 * s, kInk, names[i]);
    brush.text(gSmall, x + Brush::width(gBold, names[i]) + 8 * s, a.y + 8 * s, kMuted, limits[i]);
    brush.textRight(gBold, a.x + a.width - 14 * s, a.y + 6 * s, kInk, values[i]);
  }
  // Key of the torques.
  const Area& a = layout.chart[2];
  float x = a.x + 56 * s;
  const float y = a.y + 34 * s;
  bool dashed = false;
  for (int joint = 0; joint < torques.joints; ++joint) {
    dashed = dashed || torques.dashed(joint);
    if (torques.perChain > 0 ? joint % torques.perChain > 0 : joint >= 3) continue;
    brush.list->AddLine({x, y + 7 * s}, {x + 14 * s, y + 7 * s}, ink(torques.colourOf(joint)), 3 * s);
    brush.text(gSmall, x + 18 * s, y, kMuted,
               torques.perChain > 0 ? format("chain %d", joint / torques.perChain + 1) : format("joint %d", joint + 1));
    x += 66 * s;
  }
  if (dashed) brush.text(gSmall, x, y, kMuted, torques.perChain > 0 ? "second dashed" : "from 4 on dashed");
}

// Why a test push gave no stiffness.
std::string verdictText(const TestPush& test) {
  switch (test.unrest) {
    case Unrest::noWall: return "no wall was reached";
    case Unrest::chatters: return format("chattering at \u00b1%.1f N", test.amount);
    case Unrest::moves: return format("not at rest: %.2g mm", 1e3 * test.amount);
    case Unrest::none: break;
  }
  if (test.verdict == FirstImpactVerdict::slips) return format("slipped by %.2g mm", 1e3 * test.amount);
  return format("none: %s", toString(test.verdict));
}

// What a test push was made with and is no longer so, or nothing.
std::string conditionsText(const TestPush& test, std::size_t slot, const Settings& now) {
  const Settings& then = test.settings;
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (then.delay.low != now.delay.low || then.delay.high != now.delay.high)
    add(then.delay.low == then.delay.high ? format("delay %d", then.delay.high)
                                          : format("delay %d-%d", then.delay.low, then.delay.high));
  if (then.extraMass != now.extraMass) add(format("+%.0f g", 1e3 * then.extraMass));
  if (then.toolDamping != now.toolDamping) add(format("%.1f N s/m", then.toolDamping));
  if (then.friction != now.friction) add("other friction");
  if (then.noise != now.noise) add(format("tremor %.1f N", then.noise));
  if (then.encoders.quantised != now.encoders.quantised || then.encoders.rates != now.encoders.rates)
    add("other encoders");
  const bool spring = slot == indexOf(RendererSlot::impedance) || slot == indexOf(RendererSlot::passivity);
  if (spring && (then.spring.stiffness != now.spring.stiffness || then.spring.damping != now.spring.damping))
    add(format("spring %.1f kN/m", 1e-3 * then.spring.stiffness));
  if (slot == indexOf(RendererSlot::hold) &&
      (then.hold.release != now.hold.release || then.hold.antiWindup != now.hold.antiWindup))
    add("other hold");
  return text.empty() ? text : "at " + text;
}

void drawGauge(const Layout& layout, const OverlayInput& input, const OverlayState& state, const Brush& brush) {
  const float s = layout.scale;
  const Area& a = layout.gauge;
  const float x = a.x + 14 * s, right = a.x + a.width - 14 * s;
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper));
  brush.list->AddLine({x, a.y}, {right, a.y}, ink(kLine), s);
  brush.text(gBold, x, a.y + 8 * s, kInk, "Perceived stiffness K_z1");
  brush.text(gSmall, x + Brush::width(gBold, "Perceived stiffness K_z1") + 8 * s, a.y + 10 * s, kMuted,
             "first impact of a 12 N step");
  float y = a.y + 32 * s;
  for (std::size_t i = 0; i < rendererCount(input); ++i) {
    const TestPush& test = input.frame.tests[i];
    const bool active = indexOf(input.frame.selected) == i;
    brush.list->AddCircleFilled({x + 5 * s, y + 9 * s}, 5 * s, ink(kSlotColour[i]));
    brush.text(active ? gBold : gText, x + 17 * s, y, kInk, titleOf(input, i));
    if (test.verdict == FirstImpactVerdict::measured) {
      brush.text(gBold, x + 150 * s, y, kInk, stiffnessText(test.stiffness));
      const std::string then = conditionsText(test, i, state.settings);
      const std::string share = format("%.1f %% of the limit", 100.0 * test.stiffness / test.limit);
      // In what room there is; a longer one ends in dots.
      std::string shown = then.empty() ? share : then;
      const float room = right - x - 158 * s - Brush::width(gBold, stiffnessText(test.stiffness));
      while (shown.size() > 4 && Brush::width(gText, shown) > room) shown = shown.substr(0, shown.size() - 4) + "...";
      brush.textRight(gText, right, y, kMuted, shown);
    } else {
      brush.text(gText, x + 150 * s, y, kMuted, test.made ? verdictText(test) : "press P to measure");
    }
    y += kGaugeRow * s;
  }
  // A logarithmic bar from 1 kN/m to 1 MN/m.
  const float bar = y + 30 * s, height = 8 * s;
  const auto place = [&](double stiffness) {
    const double share = std::log10(std::clamp(stiffness, 1e3, 1e6) / 1e3) / 3.0;
    return x + static_cast<float>(share) * (right - x);
  };
  brush.list->AddRectFilled({x, bar}, {right, bar + height}, ink(kLine), 3 * s);
  const float limit = place(input.limit.stiffness);
  brush.list->AddRectFilled({limit, bar}, {right, bar + height}, ink(kMuted, 0.55), 3 * s);
  brush.list->AddLine({limit, bar - 6 * s}, {limit, bar + height + 6 * s}, ink(kInk), 2 * s);
  const std::string text = "limit " + stiffnessText(input.limit.stiffness);
  const float wide = Brush::width(gSmall, text);
  brush.text(gSmall, std::min(limit - 0.5f * wide, right - wide), bar - 22 * s, kInk, text);
  constexpr const char* ticks[] = {"1 kN/m", "10", "100", "1 MN/m"};
  for (int i = 0; i < 4; ++i) {
    const float tx = x + static_cast<float>(i) * (right - x) / 3.0f, tw = Brush::width(gSmall, ticks[i]);
    brush.list->AddLine({tx, bar + height}, {tx, bar + height + 4 * s}, ink(kMuted), s);
    brush.text(gSmall, std::clamp(tx - 0.5f * tw, x, right - tw), bar + height + 6 * s, kMuted, ticks[i]);
  }
  for (std::size_t i = 0; i < rendererCount(input); ++i)
    if (input.frame.tests[i].verdict == FirstImpactVerdict::measured) {
      const ImVec2 centre{place(input.frame.tests[i].stiffness), bar + 0.5f * height};
      brush.list->AddCircleFilled(centre, 8 * s, ink(0xFFFFFF));
      brush.list->AddCircleFilled(centre, 6.5f * s, ink(kSlotColour[i]));
    }
}

// ---- split screen ------------------------------------------------------------------------------------------------

// Two axes from 0 on, and what stands at a value on each. The vertical one begins at `low`, at most 0.
struct Plot {
  Area area;
  double low, right, top;
  ImVec2 at(double x, double y) const {
    return {area.x + area.width * static_cast<float>(x / right),
            area.y + area.height * static_cast<float>((top - y) / (top - low))};
  }
};

// The smallest of 1, 2, 5 times a power of ten of which five reach so far.
double stepFor(double far) {
  const double raw = 0.2 * far, power = std::pow(10.0, std::floor(std::log10(raw)));
  return power * (raw <= power ? 1.0 : raw <= 2.0 * power ? 2.0 : raw <= 5.0 * power ? 5.0 : 10.0);
}

// The first step's end at or beyond a value.
double endFor(double value, double least) {
  const double far = std::max(1.04 * value, least), step = stepFor(far);
  return step * std::ceil(far / step - 1e-9);
}

void drawAxes(const Plot& plot, const char* name, const Brush& brush) {
  const float s = brush.s;
  const Area& a = plot.area;
  brush.text(gBold, a.x - 34 * s, a.y - 24 * s, kInk, name);
  const double step = stepFor(plot.top);
  for (int i = static_cast<int>(std::ceil(plot.low / step)); i * step <= plot.top * (1 + 1e-9); ++i) {
    const float y = plot.at(0.0, i * step).y;
    brush.list->AddLine({a.x, y}, {a.x + a.width, y}, ink(i == 0 ? kCubeLine : kLine), s);
    brush.textRight(gSmall, a.x - 6 * s, y - 8 * s, kMuted, format("%g", i * step));
  }
}

void drawLine(const std::vector<ImVec2>& points, unsigned rgb, const Brush& brush) {
  for (std::size_t i = 1; i < points.size(); ++i)  // a polyline loses turns by half a circle
    brush.list->AddLine(points[i - 1], points[i], ink(rgb), 1.8f * brush.s);
}

void drawDepths(const Area& area, const Comparison& both, const Brush& brush) {
  constexpr double window = Comparison::kBins * Comparison::kBinTicks * kPeriod;  // s
  float largest = 0.0f;
  for (std::size_t side = 0; side < 2; ++side)
    for (int bin = 0; bin < Comparison::kBins; ++bin) largest = std::max(largest, both.depth(side, bin).high);
  const Plot plot{area, 0.0, window, endFor(1e3 * static_cast<double>(largest), 0.05)};
  drawAxes(plot, "Depth, mm", brush);
  const std::string from = format("-%g s", window);
  brush.text(gSmall, area.x, area.y + area.height + 3 * brush.s, kMuted, from);
  brush.textRight(gSmall, area.x + area.width, area.y + area.height + 3 * brush.s, kMuted, "now");
  for (const std::size_t side : {1u, 0u}) {
    std::vector<ImVec2> points;
    for (int bin = 0; bin < Comparison::kBins; ++bin) {
      const Comparison::Band band = both.depth(side, bin);
      const double time = window * (bin + 0.5) / Comparison::kBins;
      points.push_back(plot.at(time, 1e3 * static_cast<double>(band.low)));
      if (band.high > band.low) points.push_back(plot.at(time, 1e3 * static_cast<double>(band.high)));
    }
    drawLine(points, kSideColour[side], brush);
  }
}

void drawCurves(const Area& area, const Comparison& both, const Brush& brush) {
  float lowest = 0.0f;
  for (std::size_t side = 0; side < 2; ++side)
    for (const Comparison::Point& point : both.curve(side)) lowest = std::min(lowest, point.force);
  const double deepest = 1e3 * std::max(both.deepest(0), both.deepest(1));
  Plot plot{area, 0.0, endFor(deepest, 0.05), endFor(std::max(both.strongest(0), both.strongest(1)), 5.0)};
  if (lowest < -0.05f * static_cast<float>(plot.top)) plot.low = 1.05 * static_cast<double>(lowest);
  drawAxes(plot, "Force over depth, N", brush);
  const double step = stepFor(plot.right);
  for (int i = 0; i * step <= plot.right * (1 + 1e-9); ++i) {
    const float x = plot.at(i * step, 0.0).x;
    const std::string text = format(i * step > 0.999 * plot.right ? "%g mm" : "%g", i * step);
    brush.list->AddLine({x, area.y}, {x, area.y + area.height}, ink(kLine), brush.s);
    brush.text(gSmall, x - 0.5f * Brush::width(gSmall, text), area.y + area.height + 3 * brush.s, kMuted, text);
  }
  brush.list->PushClipRect({area.x - 1, area.y}, {area.x + area.width, area.y + area.height + 1}, true);
  for (const std::size_t side : {1u, 0u}) {
    std::vector<ImVec2> points;
    for (const Comparison::Point& p : both.curve(side))
      points.push_back(plot.at(1e3 * std::max(0.0, static_cast<double>(p.depth)), static_cast<double>(p.force)));
    drawLine(points, kSideColour[side], brush);
  }
  brush.list->PopClipRect();
}

std::string timesText(const Comparison::Ratio& ratio) {
  const bool above = ratio.atLeast || ratio.times > 9999.0;
  return std::string(above ? "> " : "") +
         format(ratio.times >= 9.95 ? "%.0f\u00d7" : "%.1f\u00d7", std::min(ratio.times, 9999.0));
}

// How many times as deep the one went as the other.
void drawRatio(const Area& area, const OverlayInput& input, const Brush& brush) {
  const float s = brush.s, x = area.x;
  const Comparison& both = input.comparison;
  const Frame* const frames[] = {&input.frame, input.right};
  const auto titled = [&](float y, std::size_t side, const char* before) {
    const float at = x + Brush::width(gText, before);
    brush.text(gText, x, y, kInk, before);
    brush.list->AddCircleFilled({at + 5 * s, y + 9 * s}, 5 * s, ink(kSideColour[side]));
    brush.text(gBold, at + 15 * s, y, kInk, titleOf(input, indexOf(frames[side]->selected)));
  };
  const std::optional<Comparison::Ratio> ratio = both.ratio();
  float y = area.y + 10 * s;
  if (!ratio) {
    brush.text(gBold, x, y, kInk, "Which one is stiffer?");
    brush.text(gText, x, y + 24 * s, kMuted, "Press both into the wall with");
    brush.text(gText, x, y + 43 * s, kMuted, "1 N or more, or P: test push.");
    return;
  }
  titled(y, ratio->deeper, "");
  brush.text(gText, x, y + 18 * s, kMuted, "sinks");
  brush.text(gHuge, x, y + 28 * s, kInk, timesText(*ratio));
  titled(y + 82 * s, 1 - ratio->deeper, "as deep as ");
  y += 103 * s;
  const auto depth = [&](std::size_t side) {
    return both.deepest(side) < Comparison::kLeast ? format("< %g", 1e3 * Comparison::kLeast)
                                                   : format("%.3f", 1e3 * both.deepest(side));
  };
  brush.text(gSmall, x, y, kMuted, format("deepest of this press: %s and %s mm", depth(0).c_str(), depth(1).c_str()));
  const TestPush* tests[2];
  for (std::size_t i = 0; i < 2; ++i) tests[i] = &frames[i]->tests[indexOf(frames[i]->selected)];
  if (!tests[0]->made && !tests[1]->made) return;
  const auto result = [](const TestPush& test) {
    return test.verdict == FirstImpactVerdict::measured ? stiffnessText(test.stiffness)
           : test.made                                  ? verdictText(test)
                                                        : std::string("not measured");
  };
  brush.text(gSmall, x, y + 17 * s, kMuted,
             format("K_z1: %s and %s", result(*tests[0]).c_str(), result(*tests[1]).c_str()));
}

// What the tour says, and how far it is: between the tools, above the magnifications' scales.
void drawTour(const Layout& layout, double time, const Brush& brush) {
  const float s = layout.scale, whole = 2 * layout.scene.width, pad = 14 * s, high = 76 * s;
  const std::size_t part = Tour::part(time);
  const Tour::Words& words = Tour::words(part);
  const float wide = std::max(Brush::width(gText, words.sentence), 320 * s) + 2 * pad;
  const Area& above = layout.inset.width > 0 ? layout.inset : layout.scene;
  const float x = layout.scene.x + 0.5f * (whole - wide), left = x + pad, right = x + wide - pad;
  const float y = std::max(0.0f, above.y + above.height - 38 * s - high);
  brush.list->AddRectFilled({x, y}, {x + wide, y + high}, ink(kInk, 0.93), 8 * s);
  brush.text(gLarge, left, y + 6 * s, 0xFFFFFF, words.title);
  brush.textRight(gSmall, right, y + 15 * s, kLine, format("%zu of %zu   Esc: skip", part + 1, Tour::kParts));
  brush.text(gText, left, y + 40 * s, 0xFFFFFF, words.sentence);
  const float done = (right - left) * static_cast<float>(std::min(1.0, time / Tour::kLength));
  brush.list->AddRectFilled({left, y + 66 * s}, {right, y + 69 * s}, ink(kMuted));
  brush.list->AddRectFilled({left, y + 66 * s}, {left + done, y + 69 * s}, ink(0xFFFFFF));
}

// Of a half: where the tool is, and the motors' force on it as delivered.
void drawForces(const Area& inset, const Frame& frame, const Brush& brush) {
  const float s = brush.s, x = inset.x + 10 * s;
  const Delivered force = deliveredOf(frame.record);
  const double depth = -1e3 * frame.record.nearest.gap;
  const std::pair<const char*, std::string> rows[] = {
      {depth >= 0.0 ? "depth" : "to the wall", format(std::abs(depth) < 10.0 ? "%.3f mm" : "%.1f mm", std::abs(depth))},
      {"normal", tenths(force.normal) + " N"},
      {"tangential", tenths(force.tangential) + " N"},
      {"total", tenths(force.total) + " N"}};
  float y = inset.y + 28 * s;
  for (const auto& [name, value] : rows) {
    brush.text(gSmall, x, y, kMuted, name);
    brush.textRight(gSmall, x + 134 * s, y, kInk, value);
    y += 17 * s;
  }
}

void drawHalves(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  static const std::vector<Vec3> noTrail;
  const float s = layout.scale;
  const Frame* const frames[] = {&input.frame, input.right};
  const Area* const scenes[] = {&layout.scene, &layout.right};
  const Area* const insets[] = {&layout.inset, &layout.rightInset};
  for (std::size_t side = 0; side < 2; ++side) {
    const Frame& frame = *frames[side];
    const Area& scene = *scenes[side];
    const bool ghost = side == 0 ? input.ghost : input.rightGhost;
    if (insets[side]->width > 0)
      drawInset({*insets[side], frame, ghost, side == 0 ? input.ghostPosition : input.rightGhostPosition, noTrail, true,
                 kSideColour[side]},
                input, state, brush);
    if (insets[side]->width > 0) drawForces(*insets[side], frame, brush);
    const std::string title = titleOf(input, indexOf(frame.selected));
    const float x = scene.x + 14 * s, y = scene.y + 10 * s, right = scene.x + scene.width - 14 * s;
    brush.list->PushClipRect({scene.x, scene.y}, {scene.x + scene.width, scene.y + scene.height}, true);
    brush.clear(x, y, Brush::width(gLarge, title) + 24 * s, 32 * s);
    brush.list->AddCircleFilled({x + 8 * s, y + 16 * s}, 8 * s, ink(kSideColour[side]));
    brush.text(gLarge, x + 24 * s, y + 1 * s, kInk, title);
    drawChip(right, y, input, frame, brush);
    drawBadges(right, y + 32 * s, frame, brush);
    brush.list->PopClipRect();
  }
  const Area& a = layout.compare;
  brush.list->AddLine({layout.right.x, 0}, {layout.right.x, a.y}, ink(kCubeLine), 2 * s);
  if (a.height <= 0) return;
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper));
  brush.list->AddLine({a.x, a.y}, {a.x + a.width, a.y}, ink(kCubeLine), 2 * s);
  const float card = std::min(250 * s, 0.4f * a.width), top = a.y + 34 * s, high = a.height - 34 * s - 26 * s;
  const float plots = a.width - card - 14 * s;
  const float share = plots >= 480 * s ? 0.5f : 1.0f;  // else one plot
  drawDepths({a.x + 48 * s, top, share * plots - 74 * s, high}, input.comparison, brush);
  if (share < 1.0f)
    drawCurves({a.x + share * plots + 48 * s, top, share * plots - 80 * s, high}, input.comparison, brush);
  drawRatio({a.x + a.width - card, a.y, card, a.height}, input, brush);
}

void drawBar(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const Player& player = *input.player;
  const float s = layout.scale;
  const Area& bar = layout.bar;
  const auto place = [&](std::uint64_t position) {
    return bar.x + bar.width * static_cast<float>(static_cast<double>(position) /
                                                  std::max(1.0, static_cast<double>(player.size() - 1)));
  };
  const float top = bar.y + 14 * s, bottom = top + 8 * s;
  brush.list->AddRectFilled({layout.scene.x, bar.y}, {layout.scene.x + layout.scene.width, bar.y + bar.height},
                            ink(kPaper));
  brush.list->AddRectFilled({bar.x, top}, {bar.x + bar.width, bottom}, ink(kLine));
  // Never thinner than a line, at most one a pixel: an hour has 28000 chunks.
  float contacts = -1.0f, gaps = -1.0f, acts = -1.0f;  // where the last marks end
  const auto mark = [&](float& drawn, std::uint64_t from, std::uint64_t to, float up, unsigned colour) {
    const float end = std::max(place(to), place(from) + 1.5f * s);
    if (end < drawn + 1.0f) return;
    brush.list->AddRectFilled({place(from) < drawn + 1.0f ? drawn : place(from), top - up}, {end, bottom}, ink(colour));
    drawn = end;
  };
  const auto& stretches = player.stretches();
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (stretches[i].contact) mark(contacts, stretches[i].begin, stretches[i].end, 0.0f, kVermilion);
    if (i > 0 && stretches[i].begin > stretches[i - 1].end)
      mark(gaps, stretches[i - 1].end, stretches[i].begin, 4 * s, kInk);
  }
  for (const PlayerEvent& event : player.events())
    if (event.reason != GuardReason::none) mark(acts, event.position, event.position, 6 * s, kPurple);
  const float now = place(player.position());
  brush.list->AddLine({now, bar.y + 5 * s}, {now, bottom + 4 * s}, ink(kBlue), 2 * s);
  brush.list->AddCircleFilled({now, 0.5f * (top + bottom)}, 6 * s, ink(kBlue));

  const std::string time =
      format("%s%.3f of %.3f s   tick %llu   %g x", player.playing() ? "" : "paused   ", input.simulated,
             static_cast<double>(player.size() - 1) * player.header().guard.period,
             static_cast<unsigned long long>(input.frame.record.tick), player.speed());
  const float y = bottom + 6 * s, right = bar.x + bar.width - Brush::width(gSmall, time);
  brush.text(gSmall, right, y, kInk, time);
  float x = bar.x;
  const auto key = [&](unsigned colour, const char* name) {
    if (x + Brush::width(gSmall, name) + 24 * s > right) return;
    brush.list->AddRectFilled({x, y + 5 * s}, {x + 10 * s, y + 11 * s}, ink(colour));
    brush.text(gSmall, x + 14 * s, y, kMuted, name);
    x += Brush::width(gSmall, name) + 30 * s;
  };
  key(kVermilion, "contact");
  key(kPurple, "guard");
  key(kInk, "missing");
}

// What the bur does, and what it has taken away.
constexpr float kDrillRow = 20.0f;
Area drillCard(const Layout& layout, const OverlayInput& input) {
  if (input.bur == nullptr) return {};
  const float s = layout.scale, rows = static_cast<float>(input.layers->size());
  return {layout.scene.x + 18 * s, layout.scene.y + 76 * s, 186 * s, (80 + kDrillRow * rows) * s};
}

void drawDrill(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Drilled& drilled = input.frame.drilled;
  const Area card = drillCard(layout, input);
  brush.card(card, 0.88);
  const float x = card.x + 12 * s, right = card.x + card.width - 12 * s;
  float y = card.y + 8 * s;
  brush.list->AddCircleFilled({x + 5 * s, y + 9 * s}, 5 * s, ink(drilled.spins ? kGreen : kMuted));
  brush.text(gBold, x + 16 * s, y, kInk, "Bur");
  brush.textRight(gText, right, y, kMuted, drilled.spins ? format("%.0f turns/s", input.bur->turns) : "at rest");
  const auto line = [&](const char* name, const std::string& value) {
    y += kDrillRow * s;
    brush.text(gText, x + 16 * s, y, kMuted, name);
    brush.textRight(gBold, right, y, kInk, value);
  };
  line("depth", format("%.2f mm", 1e3 * input.burDepth));
  line("feed", format("%.2f mm/s", 1e3 * std::max(0.0, drilled.feed)));
  y += 4 * s;
  for (std::size_t i = 0; i < input.layers->size(); ++i) {
    line((*input.layers)[i].name.c_str(), format("%.2f mm\u00b3", 1e9 * std::max(0.0, drilled.removed[i])));
    brush.list->AddRectFilled({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(layerColour(static_cast<int>(i))), 2 * s);
    brush.list->AddRect({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(kEnamelEdge), 2 * s);
  }
}

void drawTiming(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const TimingNumbers& t = input.timing;
  const Area above = drillCard(layout, input);
  const Area card{layout.scene.x + 18 * s, layout.scene.y + 76 * s + (above.height > 0 ? above.height + 8 * s : 0.0f),
                  300 * s, (t.available ? 104 : 38) * s};
  brush.card(card, 0.94);
  const float x = card.x + 12 * s;
  float y = card.y + 8 * s;
  const auto line = [&](const std::string& text) {
    brush.text(gText, x, y, kInk, text);
    y += 22 * s;
  };
  if (t.available) {
    line(format("haptic loop 1 kHz, %s", t.realtime ? "real-time class" : "normal class"));
    line(format("wake-up  median %.0f us, p99.9 %.0f us", 1e6 * t.wakeMedian, 1e6 * t.wakeHigh));
    line(format("compute  median %.1f us, p99.9 %.1f us", 1e6 * t.computeMedian, 1e6 * t.computeHigh));
    line(format("missed %llu of %llu    %.0f pictures/s", t.missed, t.periods, t.framesPerSecond));
  } else {
    line(input.player != nullptr ? "a recording: no haptic thread" : "simulated time: no haptic thread");
  }
}

void drawHelp(const Layout& layout, bool recording, const Brush& brush) {
  std::vector<HelpRow> help;
  const auto add = [&](const auto& row) {
    if (row.source == Source::both || (row.source == Source::recording) == recording)
      help.push_back({row.keys, row.meaning});
  };
  for (const HelpRow& row : drivingRows()) add(row);
  for (const ActionRow& row : actionRows()) add(row);
  const std::size_t all = help.size(), left = all / 2;
  const float rows = static_cast<float>(all - left);
  const float w = static_cast<float>(layout.size.x), h = static_cast<float>(layout.size.y);
  // Smaller where the window is too small for it.
  const float fit = std::min({1.0f, w / (740 * layout.scale), h / ((76 + 23 * rows) * layout.scale)});
  const float s = layout.scale * fit, wide = 720 * s, high = (66 + 23 * rows) * s;
  const Area card{0.5f * (w - wide), 0.5f * (h - high), wide, high};
  const auto text = [&](ImFont* font, float x, float y, unsigned rgb, const char* words) {
    brush.list->AddText(font, fit * font->FontSize, {std::round(x), std::round(y)}, ink(rgb), words);
  };
  brush.list->AddRectFilled({0, 0}, {w, h}, ink(kInk, 0.25));
  brush.card(card, 1.0);
  text(gLarge, card.x + 20 * s, card.y + 12 * s, kInk,
       recording ? "Look at a recording" : "Push the tool against the wall");
  for (std::size_t i = 0; i < all; ++i) {
    const bool second = i >= left;
    const float x = card.x + 20 * s + (second ? 0.53f * wide : 0.0f);
    const float y = card.y + (52 + 23 * static_cast<float>(second ? i - left : i)) * s;
    text(gBold, x, y, kInk, help[i].keys);
    text(gText, x + 92 * s, y, kMuted, help[i].meaning);
  }
}

}  // namespace

std::string stiffnessText(double stiffness) {
  if (stiffness >= 999.5e3) return format("%.2f MN/m", 1e-6 * stiffness);
  if (stiffness >= 99.95e3) return format("%.0f kN/m", 1e-3 * stiffness);
  if (stiffness >= 9.995e3) return format("%.1f kN/m", 1e-3 * stiffness);
  return format("%.2f kN/m", 1e-3 * stiffness);
}

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
  gText = load(font, 15.0f);
  gSmall = load(font, 13.0f);
  gBold = load(boldFont, 15.0f);
  gLarge = load(boldFont, 26.0f);
  gHuge = load(boldFont, 52.0f, kDigits);
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
  c[ImGuiCol_SliderGrab] = tone(kBlue, 0.8);
  c[ImGuiCol_SliderGrabActive] = tone(kBlue);
  c[ImGuiCol_CheckMark] = tone(kBlue);
  c[ImGuiCol_Header] = tone(kBlue, 0.2);
  c[ImGuiCol_HeaderHovered] = tone(kBlue, 0.3);
  c[ImGuiCol_Button] = tone(0xFFFFFF);
  c[ImGuiCol_ButtonHovered] = tone(kLine);
}

void drawOverlay(const Layout& layout, const OverlayInput& input, OverlayState& state) {
  if (layout.panel.width > 0) drawPanel(layout, input, state);
  const Brush brush{ImGui::GetBackgroundDrawList(), layout.scale};
  if (layout.isSplit() && input.right != nullptr) {
    drawHalves(layout, input, state, brush);
    if (input.tour >= 0.0) drawTour(layout, input.tour, brush);
  } else {
    drawHeader(layout, input, brush);
    drawNumbers(layout, input, brush);
    if (layout.inset.width > 0)
      drawInset({layout.inset, input.frame, input.ghost, input.ghostPosition, input.trail, false, kNeedle}, input,
                state, brush);
  }
  if (layout.charts.width > 0) {
    drawChartTitles(layout, input, brush);
    if (layout.gauge.height > 0) drawGauge(layout, input, state, brush);
  }
  if (layout.bar.width > 0) drawBar(layout, input, brush);
  if (input.bur != nullptr && layout.scene.height >= 420 * layout.scale) drawDrill(layout, input, brush);
  if (state.timing) drawTiming(layout, input, brush);
  if (!state.notice.empty()) {
    const float s = layout.scale, wide = Brush::width(gText, state.notice) + 24 * s;
    const float whole = (layout.isSplit() ? 2 : 1) * layout.scene.width;
    const float x = layout.scene.x + 0.5f * (whole - wide), y = layout.scene.y + 76 * s;
    brush.list->AddRectFilled({x, y}, {x + wide, y + 28 * s}, ink(kInk, 0.85), 14 * s);
    brush.text(gText, x + 12 * s, y + 5 * s, 0xFFFFFF, state.notice);
  }
  if (state.help) drawHelp(layout, input.player != nullptr, Brush{ImGui::GetForegroundDrawList(), layout.scale});
}

}  // namespace enamel::viewer
