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

constexpr double kLeastDepth = 5e-4;  // mm: smaller depths have no number

// Return the horizontal axis of the inset: tangential to the deepest contact's wall. The section is perpendicular to
// that wall, and also to the second contact's wall if it is near.
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

// Fill the part of the rectangle `low`..`high` behind the line through `point` with the outward normal `normal`.
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
  if (material.slidingFriction < material.friction) text += format(", sliding %g", material.slidingFriction);
  if (std::isfinite(material.stiffness)) text += ", " + stiffnessText(material.stiffness);
  return text;
}

// The plane of the inset, magnified: it contains the deepest contact's normal.
class Inset {
 public:
  Inset(const InsetView& view, OverlayState& state, const Brush& brush)
      : view_(view),
        area_(view.area),
        brush_(brush),
        s_(brush.s),
        bar_(view.isSplit ? rulerStep(view.layout) : 46 * s_),
        readouts_(state.readouts),
        toolRadius_(view.input.scene.toolRadius),
        frame_(view.tool.frame),
        shown_(shownOf(view.input, frame_)),
        contact_(frame_.record.nearest),
        normal_(contact_.normal),
        across_(insetAcross(normal_, frame_.contacts)),
        tool_(contact_.point),
        fromTcp_(tool_ - frame_.record.pose.position),
        reference_(view.tool.ghost.value_or(Vec3::Zero()) + fromTcp_),
        origin_([&]() -> Vec3 {
          const Vec3 surface = tool_ - contact_.gap * normal_;
          return view.tool.ghost ? Vec3(reference_ - normal_ * normal_.dot(reference_ - surface)) : surface;
        }()),
        barMillimetres_([&] {
          const Vec3 offset = tool_ - origin_;
          return chooseScale(state.zoom,
                             1e3 * std::max(std::abs(normal_.dot(offset)), 0.6 * std::abs(across_.dot(offset))));
        }()),
        perMillimetre_(static_cast<double>(bar_) / barMillimetres_),
        cx_(area_.x + 0.5f * area_.width),
        cy_(area_.y + (view.isSplit ? kWallShare : 0.56f) * area_.height),
        top_(area_.y + 26 * s_),
        bottom_(area_.y + area_.height - s_) {}

  void draw() const {
    if (view_.isSplit)
      brush_.list->AddRectFilled({area_.x, area_.y}, {area_.x + area_.width, area_.y + area_.height}, ink(kPaper));
    else
      brush_.box(area_, 1.0);
    brush_.list->PushClipRect({area_.x + s_, top_}, {area_.x + area_.width - s_, bottom_}, true);
    drawWalls();
    drawTools();
    drawForces();

    drawDepth();
    drawContacts();
    brush_.list->PopClipRect();
    drawLegend();
  }

 private:
  // Choose the length of the scale bar, mm, so that `reach` (mm) fits: grow at once, shrink after a while. Both panes
  // of the split screen have the scale of the deeper tool in this press, with a ruler of 0.01, 0.1 or 1 mm.
  double chooseScale(OverlayState::Zoom& zoom, double reach) const {
    constexpr double steps[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0}, rulers[] = {0.01, 0.1, 1.0};
    const Comparison& both = view_.input.comparison;
    const double deepest = 1e3 * std::max(both.deepest(0), both.deepest(1));
    if (view_.isSplit) reach = deepest > kLeastDepth ? deepest : rulers[2];
    const double* const scales = view_.isSplit ? rulers : steps;
    const int last = view_.isSplit ? 2 : 8;
    const float room = view_.isSplit ? (1.0f - kWallShare) * area_.height - 14 * s_ : 70 * s_;
    int wanted = 0;
    while (wanted < last && reach * bar_ / scales[wanted] > room) ++wanted;
    zoom.step = std::min(zoom.step, last);
    zoom.patience = wanted < zoom.step ? zoom.patience + 1 : 0;
    if (wanted > zoom.step || zoom.patience > 40) zoom.step = wanted;
    return scales[zoom.step];
  }

  ImVec2 at(const Vec3& point) const {
    const Vec3 d = 1e3 * (point - origin_);
    return {cx_ + static_cast<float>(std::clamp(perMillimetre_ * across_.dot(d), -1e4, 1e4)),
            cy_ - static_cast<float>(std::clamp(perMillimetre_ * normal_.dot(d), -1e4, 1e4))};
  }

  // Draw the deepest contact's wall, with its normal and a grid of one bar. The other walls are planes that cross the
  // inset.
  void drawWalls() const {
    ImDrawList* const list = brush_.list;
    const float right = area_.x + area_.width;
    list->AddRectFilled({area_.x, cy_}, {right, bottom_}, ink(kEnamel));
    for (float x = std::fmod(cx_ - area_.x, bar_) + area_.x; x < right; x += bar_)
      list->AddLine({x, cy_}, {x, bottom_}, ink(kEnamelGrid, 0.6), s_);
    for (float y = cy_ + bar_; y < bottom_; y += bar_)
      list->AddLine({area_.x, y}, {right, y}, ink(kEnamelGrid, 0.6), s_);
    list->AddLine({area_.x, cy_}, {right, cy_}, ink(kEnamelEdge), 2 * s_);
    for (int i = 1; i < frame_.contacts.count; ++i) {
      const Contact& other = frame_.contacts.contacts[i];
      const float mx = static_cast<float>(across_.dot(other.normal)),
                  my = static_cast<float>(-normal_.dot(other.normal));
      const float length = std::hypot(mx, my);
      // Skip walls along the section, and continuations of the deepest contact's wall.
      if (length < 0.1f || normal_.dot(other.normal) > 0.9) continue;
      const ImVec2 foot = at(other.point - other.gap * other.normal);
      fillBehind(list, {area_.x, top_}, {right, bottom_}, foot, {mx, my}, ink(kEnamel));
      const float far = 2 * area_.width / length;
      list->AddLine({foot.x - far * my, foot.y + far * mx}, {foot.x + far * my, foot.y - far * mx}, ink(kEnamelEdge),
                    2 * s_);
    }
    list->AddLine({cx_, cy_}, {cx_, top_}, ink(kMuted, 0.6), s_);
  }

  // Draw a sphere, or a wedge for a point. A colour of 0 omits that part.
  void drawTool(ImVec2 lowest, ImU32 fill, ImU32 outline) const {
    constexpr int sides = 256;
    ImDrawList* const list = brush_.list;
    if (toolRadius_ > 0.0) {
      const float radius = static_cast<float>(1e3 * toolRadius_ * perMillimetre_);
      const ImVec2 centre{lowest.x, lowest.y - radius};
      if (fill != 0) list->AddCircleFilled(centre, radius, fill, sides);
      if (outline != 0) list->AddCircle(centre, radius, outline, sides, 1.5f * s_);
      return;
    }
    const float height = std::max(lowest.y - top_ + 4 * s_, 20 * s_), wide = 0.17f * height;
    const ImVec2 a{lowest.x - wide, lowest.y - height}, b{lowest.x + wide, lowest.y - height};
    if (fill != 0) list->AddTriangleFilled(lowest, a, b, fill);
    if (outline == 0) return;
    list->AddLine(lowest, a, outline, 1.5f * s_);
    list->AddLine(lowest, b, outline, 1.5f * s_);
  }

  // Draw past positions, the present one, and the reference pose.
  void drawTools() const {
    if (view_.isSplit &&
        view_.deepest > 0.0) {  // how deep it sank in this press; the mark remains when the tool has gone
      const float deep = static_cast<float>(1e3 * view_.deepest * perMillimetre_), wide = 46 * s_;
      brush_.list->AddRectFilled({cx_ - wide, cy_}, {cx_ + wide, cy_ + deep}, ink(view_.colour, 0.35));
      brush_.list->AddLine({cx_ - wide, cy_ + deep}, {cx_ + wide, cy_ + deep}, ink(view_.colour), 3 * s_);
    }
    const std::vector<Vec3>& trail = view_.trail;
    for (std::size_t i = 1; i < trail.size(); ++i)
      brush_.list->AddLine(at(trail[i - 1] + fromTcp_), at(trail[i] + fromTcp_),
                           ink(kReference, static_cast<double>(i) / static_cast<double>(trail.size())), 1.5f * s_);
    drawTool(at(tool_), ink(view_.colour, view_.isSplit ? 1.0 : 0.88), 0);
    if (!view_.tool.ghost) return;
    const ImVec2 rest = at(reference_);
    const ImU32 outline = ink(view_.isSplit ? kInk : kReference);
    drawTool(rest, 0, outline);
    brush_.list->AddCircle(rest, 4 * s_, outline, 0, 1.5f * s_);
  }

  // Draw the forces of motors and hand. The motors' force points away from the wall, or into it if they pull.
  void drawForces() const {
    const ImVec2 tip = at(tool_);
    const double force = deliveredOf(shown_.force, contact_).normal, out = force > 0.0 ? 1.0 : -1.0;
    const auto forceLength = static_cast<float>(out * (std::min(4.0 * std::abs(force), 80.0) + 8.0)) * s_;
    if (std::abs(force) > 0.05 && (frame_.record.mode == RenderMode::contact || contact_.gap <= 0.0))
      brush_.arrow({tip.x, tip.y}, {tip.x, tip.y - forceLength}, kForce, 3 * s_);
    const double pressed = shown_.hand;
    if (!(pressed > 0.05)) return;
    const float from = std::max(top_, tip.y - 118 * s_);
    const float length = static_cast<float>(std::clamp(3.0 * pressed, 0.0, 50.0)) * s_ + 8 * s_;
    brush_.arrow({tip.x - 26 * s_, from}, {tip.x - 26 * s_, from + length}, kHand, 3 * s_);
  }

  // Number all contacts that touch, and list their depths. A wall along the section has a mark, but no line.
  void drawContacts() const {
    int count = 0;
    while (count < frame_.contacts.count && frame_.contacts.contacts[count].gap <= 0.0) ++count;  // deepest first
    if (count < 2) return;
    const float row = 16 * s_, wide = 104 * s_,
                x = view_.isSplit ? area_.x + area_.width - wide - 8 * s_ : area_.x + 8 * s_;
    float y = top_ + 2 * s_;
    brush_.list->AddRectFilled({x, y}, {x + wide, y + static_cast<float>(count) * row + 4 * s_}, ink(kPaper, 0.92),
                               4 * s_);
    for (int i = 0; i < count; ++i, y += row) {
      const Contact& contact = frame_.contacts.contacts[i];
      const ImVec2 foot = at(contact.point - contact.gap * contact.normal);
      brush_.list->AddLine(at(contact.point), foot, ink(kInk), 1.5f * s_);
      brush_.list->AddCircleFilled(foot, 7 * s_, ink(kForce));
      const std::string number = format("%d", i + 1), depth = format("%.3f mm", -1e3 * contact.gap);
      brush_.text(gFonts.small, foot.x - 0.5f * Brush::width(gFonts.small, number), foot.y - 7 * s_, 0xFFFFFF, number);
      brush_.text(gFonts.small, x + 6 * s_, y, kInk, number + ":");
      brush_.textRight(gFonts.small, x + wide - 6 * s_, y, kInk, depth);
      readouts_.push_back("contact " + number + ": " + depth);
    }
  }

  void drawDepth() const {
    const double depth = 1e3 * shown_.depth;
    if (!(depth > kLeastDepth && contact_.gap < 0.0)) return;
    ImDrawList* const list = brush_.list;
    const ImVec2 tip = at(tool_);
    const float x = cx_ + 62 * s_, y = tip.y;
    list->AddLine({tip.x, y}, {x + 5 * s_, y}, ink(kInk, 0.5), s_);
    list->AddLine({x, cy_}, {x, y}, ink(kInk), 1.5f * s_);
    for (const float end : {cy_, y}) list->AddLine({x - 4 * s_, end}, {x + 4 * s_, end}, ink(kInk), 1.5f * s_);
    const std::string text = format("%.3f mm", depth);
    brush_.text(gFonts.text, std::min(cx_ + 40 * s_, area_.x + area_.width - 6 * s_ - Brush::width(gFonts.text, text)),
                std::min(std::max(y, cy_) + 4 * s_, bottom_ - 20 * s_), kInk, text);
  }

  // Draw a ruler from the surface downwards, with ten parts each step.
  void drawRuler() const {
    const float x = area_.x + 12 * s_;
    const auto tick = [&](float y, float wide) { brush_.list->AddLine({x, y}, {x + wide * s_, y}, ink(kInk), s_); };
    brush_.list->AddLine({x, cy_}, {x, bottom_ - 6 * s_}, ink(kInk), 1.5f * s_);
    for (int i = 0; cy_ + 0.1f * static_cast<float>(i) * bar_ < bottom_ - 6 * s_; ++i) {
      const float y = cy_ + 0.1f * static_cast<float>(i) * bar_;
      tick(y, i % 10 == 0 ? 10.0f : i % 5 == 0 ? 6.0f : 3.0f);
      if (i == 0 || i % 10 != 0) continue;
      const double length = 0.1 * i * barMillimetres_;
      brush_.text(gFonts.small, x + 14 * s_, y - 8 * s_, kInk,
                  length < 0.0999 ? format("%.0f \u00b5m", 1e3 * length) : format("%g mm", length));
    }
  }

  // Draw title, scale and material.
  void drawLegend() const {
    const float x = area_.x + 12 * s_, y = area_.y + area_.height - 12 * s_;
    if (view_.isSplit) {
      drawRuler();
    } else {
      const bool several = frame_.contacts.count > 1 && frame_.contacts.contacts[1].gap <= 0.0;
      brush_.text(gFonts.bold, area_.x + 10 * s_, area_.y + 6 * s_, kInk,
                  several ? "Contacts, magnified" : "Contact, magnified");
      brush_.list->AddLine({x, y}, {x + bar_, y}, ink(kInk), 2 * s_);
      for (const float end : {x, x + bar_})
        brush_.list->AddLine({end, y - 4 * s_}, {end, y + 4 * s_}, ink(kInk), 1.5f * s_);
      brush_.text(gFonts.small, x, y - 19 * s_, kInk, format("%g mm", barMillimetres_));
    }
    const std::string material = materialText(contact_.material);
    const float right = area_.x + area_.width - 10 * s_, left = right - Brush::width(gFonts.small, material);
    brush_.list->AddRectFilled({left - 4 * s_, y - 7 * s_}, {right + 4 * s_, y + 9 * s_}, ink(kEnamel, 0.9));
    brush_.text(gFonts.small, left, y - 7 * s_, kInk, material);
  }

  const InsetView& view_;
  const Rect& area_;
  const Brush& brush_;
  const float s_, bar_;  // scale; length of the scale bar
  std::vector<std::string>& readouts_;
  const double toolRadius_;
  const Frame& frame_;
  const Readout shown_;
  const Contact& contact_;  // the deepest contact
  // The inset shows positions of the tool's nearest point, not of its TCP.
  const Vec3 normal_, across_, tool_, fromTcp_, reference_, origin_;
  const double barMillimetres_;  // length of the scale bar
  const double perMillimetre_;
  const float cx_, cy_, top_, bottom_;  // centre of the wall's line; ends of the drawing
};

}  // namespace

void drawInset(const InsetView& view, OverlayState& state, const Brush& brush) { Inset(view, state, brush).draw(); }

}  // namespace enamel::viewer
