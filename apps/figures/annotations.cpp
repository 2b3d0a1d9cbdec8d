#include "annotations.hpp"

#include <vtkAbstractContextItem.h>
#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace enamel::figures {
namespace {

constexpr double kSize = 28.0;  // of texts, pixels

// An item that draws by a function.
class Drawing final : public vtkAbstractContextItem {
 public:
  static Drawing* New();
  vtkTypeMacro(Drawing, vtkAbstractContextItem) bool Paint(vtkContext2D* painter) override {
    draw(painter);
    return true;
  }
  std::function<void(vtkContext2D*)> draw;
};
vtkStandardNewMacro(Drawing)

    void addDrawing(Canvas& canvas, std::function<void(vtkContext2D*)> draw) {
  vtkNew<Drawing> drawing;
  drawing->draw = std::move(draw);
  canvas.charts()->AddItem(drawing);
}

// From the finished figure's pixels to those that are drawn.
struct Scale {
  float height;
  float x(double value) const { return static_cast<float>(kOversampling * value); }
  float y(double value) const { return static_cast<float>(kOversampling * (height - value)); }
};

void pen(vtkContext2D* painter, const std::string& colour, double width, bool dashed) {
  const glm::u8vec3 c = colourOf(colour);
  painter->GetPen()->SetColor(c.r, c.g, c.b, 255);
  painter->GetPen()->SetWidth(static_cast<float>(kOversampling * width));
  painter->GetPen()->SetLineType(dashed ? vtkPen::DASH_LINE : vtkPen::SOLID_LINE);
}

void brush(vtkContext2D* painter, const std::string& colour) {
  const glm::u8vec3 c = colourOf(colour);
  painter->GetBrush()->SetColor(c.r, c.g, c.b, 255);
}

}  // namespace

// A description is read here, not while painting: an exception must not pass through VTK.
void addText(Canvas& canvas, const Json& text) {
  const Scale scale{static_cast<float>(canvas.size().y)};
  const std::string words = text.at("text"), colour = text.value("colour", "#1F262E"),
                    align = text.value("align", "left");
  const double x = text.at("x"), y = text.at("y"), size = text.value("size", kSize);
  const bool turned = text.value("turned", false);
  (void)colourOf(colour);
  addDrawing(canvas, [=](vtkContext2D* painter) {
    vtkTextProperty* property = painter->GetTextProp();
    setText(property, size, colour);
    property->SetJustification(align == "left" ? VTK_TEXT_LEFT : align == "right" ? VTK_TEXT_RIGHT : VTK_TEXT_CENTERED);
    property->SetVerticalJustificationToBottom();
    property->SetOrientation(turned ? 90.0 : 0.0);
    painter->DrawString(scale.x(x), scale.y(y), words.c_str());
    property->SetOrientation(0.0);
  });
}

void addLegend(Canvas& canvas, const Json& legend, const Json& place) {
  const Scale scale{static_cast<float>(canvas.size().y)};
  struct Entry {
    std::string name, colour;
    bool box, dash;
  };
  std::vector<Entry> entries;
  for (const Json& entry : legend.at("entries")) {
    entries.push_back({entry.at("name"), entry.at("colour"), entry.value("box", false), entry.value("dash", false)});
    (void)colourOf(entries.back().colour);
  }
  const std::string corner = legend.at("corner");
  const double panelLeft = place.at(0), panelTop = place.at(1), panelWidth = place.at(2), panelHeight = place.at(3),
               lift = legend.value("lift", 54.0);
  if (entries.empty()) return;
  addDrawing(canvas, [=](vtkContext2D* painter) {
    constexpr double line = 40.0, sample = 54.0, gap = 14.0, border = 16.0;
    vtkTextProperty* property = painter->GetTextProp();
    setText(property, kSize, "#1F262E");
    property->SetJustificationToLeft();
    property->SetVerticalJustificationToCentered();
    std::vector<double> widths;
    for (const Entry& entry : entries) {
      float bounds[4];
      painter->ComputeStringBounds(entry.name.c_str(), bounds);
      widths.push_back(static_cast<double>(bounds[2]) / kOversampling);
    }
    const bool above = corner == "above";
    double left = panelLeft, top = panelTop - lift;
    if (!above) {
      const double inset = 10.0, width = sample + gap + *std::max_element(widths.begin(), widths.end()) + 2.0 * border,
                   height = line * static_cast<double>(entries.size()) + border;
      left = corner.find("right") != std::string::npos ? panelLeft + panelWidth - width - inset : panelLeft + inset;
      top = corner.find("bottom") != std::string::npos ? panelTop + panelHeight - height - inset : panelTop + inset;
      pen(painter, "#D3D9E0", 1.0, false);
      brush(painter, "#FFFFFF");
      painter->DrawRect(scale.x(left), scale.y(top + height), scale.x(width), scale.x(height));
      left += border;
      top += 0.5 * border;
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Entry& entry = entries[i];
      const double y = top + 0.5 * line, x = left;
      if (entry.box) {
        pen(painter, "#66707C", 1.0, false);
        brush(painter, entry.colour);
        painter->DrawRect(scale.x(x + 12.0), scale.y(y + 13.0), scale.x(30.0), scale.x(26.0));
      } else {
        pen(painter, entry.colour, 4.0, entry.dash);
        painter->DrawLine(scale.x(x), scale.y(y), scale.x(x + sample), scale.y(y));
      }
      setText(property, kSize, "#1F262E");
      property->SetJustificationToLeft();
      property->SetVerticalJustificationToCentered();
      painter->DrawString(scale.x(x + sample + gap), scale.y(y), entry.name.c_str());
      if (above)
        left += sample + gap + widths[i] + 44.0;
      else
        top += line;
    }
  });
}

}  // namespace enamel::figures
