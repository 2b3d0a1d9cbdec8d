#include "annotations.hpp"

#include <vtkAbstractContextItem.h>
#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <functional>

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

void addText(Canvas& canvas, const Json& text) {
  const Scale scale{static_cast<float>(canvas.size().y)};
  addDrawing(canvas, [text, scale](vtkContext2D* painter) {
    vtkTextProperty* property = painter->GetTextProp();
    setText(property, text.value("size", kSize), text.value("colour", "#1F262E"));
    const std::string align = text.value("align", "left");
    property->SetJustification(align == "left" ? VTK_TEXT_LEFT : align == "right" ? VTK_TEXT_RIGHT : VTK_TEXT_CENTERED);
    property->SetVerticalJustificationToBottom();
    painter->DrawString(scale.x(text.at("x").get<double>()), scale.y(text.at("y").get<double>()),
                        text.at("text").get<std::string>().c_str());
  });
}

void addLegend(Canvas& canvas, const Json& legend, const Json& place) {
  const Scale scale{static_cast<float>(canvas.size().y)};
  addDrawing(canvas, [legend, place, scale](vtkContext2D* painter) {
    constexpr double line = 40.0, sample = 54.0, gap = 14.0, border = 16.0;
    vtkTextProperty* property = painter->GetTextProp();
    setText(property, kSize, "#1F262E");
    property->SetJustificationToLeft();
    property->SetVerticalJustificationToCentered();
    const Json& entries = legend.at("entries");
    double widest = 0.0;
    for (const Json& entry : entries) {
      float bounds[4];
      painter->ComputeStringBounds(entry.at("name").get<std::string>().c_str(), bounds);
      widest = std::max(widest, static_cast<double>(bounds[2]) / kOversampling);
    }
    const double width = sample + gap + widest + 2.0 * border,
                 height = line * static_cast<double>(entries.size()) + border;
    const std::string corner = legend.at("corner");
    const double inset = 10.0;
    const double left = corner.find("right") != std::string::npos
                            ? place[0].get<double>() + place[2].get<double>() - width - inset
                            : place[0].get<double>() + inset;
    const double top = corner.find("bottom") != std::string::npos
                           ? place[1].get<double>() + place[3].get<double>() - height - inset
                           : place[1].get<double>() + inset;
    pen(painter, "#D3D9E0", 1.0, false);
    brush(painter, "#FFFFFF");
    painter->DrawRect(scale.x(left), scale.y(top + height), scale.x(width), scale.x(height));
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Json& entry = entries[i];
      const double y = top + 0.5 * border + line * (static_cast<double>(i) + 0.5), x = left + border;
      const std::string colour = entry.at("colour");
      if (entry.value("box", false)) {
        pen(painter, "#66707C", 1.0, false);
        brush(painter, colour);
        painter->DrawRect(scale.x(x + 12.0), scale.y(y + 13.0), scale.x(30.0), scale.x(26.0));
      } else if (entry.value("marks", false)) {
        pen(painter, colour, 14.0, false);
        painter->DrawPoint(scale.x(x + 0.5 * sample), scale.y(y));
      } else {
        pen(painter, colour, 4.0, entry.value("dash", false));
        painter->DrawLine(scale.x(x), scale.y(y), scale.x(x + sample), scale.y(y));
      }
      setText(property, kSize, "#1F262E");
      property->SetJustificationToLeft();
      property->SetVerticalJustificationToCentered();
      painter->DrawString(scale.x(x + sample + gap), scale.y(y), entry.at("name").get<std::string>().c_str());
    }
  });
}

}  // namespace enamel::figures
