// The magnified contact.
#include <imgui.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

namespace {

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

}  // namespace

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

  const float cx = area.x + 0.5f * area.width, cy = area.y + (view.half ? kWallShare : 0.56f) * area.height;
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
                        ink(kReference, static_cast<double>(i) / static_cast<double>(view.trail.size())), 1.5f * s);
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
    const unsigned outline = view.half ? kInk : kReference;
    drawTool(rest, 0, ink(outline));
    brush.list->AddCircle(rest, 4 * s, ink(outline), 0, 1.5f * s);
  }
  // Away from the wall, or, where the motors pull, into it.
  const double force = deliveredOf(frame.record).normal, out = force > 0.0 ? 1.0 : -1.0;
  const auto forceLength = static_cast<float>(out * (std::min(4.0 * std::abs(force), 80.0) + 8.0)) * s;
  if (std::abs(force) > 0.05 && (frame.record.mode == RenderMode::contact || contact.gap <= 0.0))
    brush.arrow({tip.x, tip.y}, {tip.x, tip.y - forceLength}, kForce, 3 * s);
  const double pressed = handForce(frame);
  if (pressed > 0.05) {
    const float from = std::max(top, tip.y - 118 * s);
    const float length = static_cast<float>(std::clamp(3.0 * pressed, 0.0, 50.0)) * s + 8 * s;
    brush.arrow({tip.x - 26 * s, from}, {tip.x - 26 * s, from + length}, kHand, 3 * s);
  }
  bool labelled = false;  // the next deepest: more numbers would hide each other
  for (int i = 1; i < frame.contacts.count; ++i) {
    const Contact& other = frame.contacts.contacts[i];
    if (other.gap > 0.0) continue;
    const ImVec2 foot = at(other.point - other.gap * other.normal);
    brush.list->AddLine(at(other.point), foot, ink(kInk), 1.5f * s);
    brush.list->AddCircleFilled(foot, 3 * s, ink(kForce));
    if (labelled || -1e3 * other.gap < 5e-4) continue;  // as the first one's
    labelled = true;
    const std::string text = format("%.3f mm", -1e3 * other.gap);
    const bool right = across.dot(other.normal) < 0.0;  // within its wall
    brush.text(gFonts.small, foot.x + (right ? 8 * s : -8 * s - Brush::width(gFonts.small, text)), foot.y - 7 * s, kInk,
               text);
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
    brush.text(gFonts.text, std::min(cx + 40 * s, area.x + area.width - 6 * s - Brush::width(gFonts.text, text)),
               std::min(std::max(y, cy) + 4 * s, bottom - 20 * s), kInk, text);
  }
  brush.list->PopClipRect();

  brush.text(
      gFonts.bold, area.x + 10 * s, area.y + 6 * s, kInk,
      frame.contacts.count > 1 && frame.contacts.contacts[1].gap <= 0.0 ? "Contacts, magnified" : "Contact, magnified");
  const float bx = area.x + 12 * s, by = area.y + area.height - 12 * s;
  brush.list->AddLine({bx, by}, {bx + bar, by}, ink(kInk), 2 * s);
  brush.list->AddLine({bx, by - 4 * s}, {bx, by + 4 * s}, ink(kInk), 1.5f * s);
  brush.list->AddLine({bx + bar, by - 4 * s}, {bx + bar, by + 4 * s}, ink(kInk), 1.5f * s);
  brush.text(gFonts.small, bx, by - 19 * s, kInk, format("%g mm", steps[step]));
  const std::string material = materialText(contact.material);
  const float right = area.x + area.width - 10 * s, left = right - Brush::width(gFonts.small, material);
  brush.list->AddRectFilled({left - 4 * s, by - 7 * s}, {right + 4 * s, by + 9 * s}, ink(kEnamel, 0.9));
  brush.text(gFonts.small, left, by - 7 * s, kInk, material);
}

}  // namespace enamel::viewer
