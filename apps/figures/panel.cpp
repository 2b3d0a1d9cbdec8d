#include "panel.hpp"

#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkChartXY.h>
#include <vtkContext2D.h>
#include <vtkDoubleArray.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkPlotPoints.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "annotations.hpp"
#include "enamel/core/error.hpp"

namespace enamel::figures {
namespace {

constexpr const char* kInk = "#1F262E";
constexpr const char* kMuted = "#4A535E";
constexpr const char* kGridLine = "#E1E5EA";
constexpr double kLabel = 28.0, kTitle = 30.0;  // pixels

// viridis (van der Walt and Smith 2015) at nine places: rises evenly in lightness, also for the colour-blind.
const glm::vec3 kViridis[] = {{68, 1, 84},    {71, 45, 123}, {59, 82, 139},  {44, 114, 142}, {33, 145, 140},
                              {40, 174, 128}, {94, 201, 98}, {173, 220, 48}, {253, 231, 37}};
const glm::vec3 kNoValue(217, 217, 217);

struct Cell {
  float x, y;
  glm::vec3 colour;
};

// Coloured rectangles in the coordinates of the axes.
class Cells final : public vtkPlot {
 public:
  static Cells* New();
  vtkTypeMacro(Cells, vtkPlot) bool Paint(vtkContext2D* painter) override {
    painter->GetPen()->SetLineType(vtkPen::NO_PEN);
    for (const Cell& cell : cells) {
      painter->GetBrush()->SetColor(static_cast<unsigned char>(cell.colour.r),
                                    static_cast<unsigned char>(cell.colour.g),
                                    static_cast<unsigned char>(cell.colour.b), 255);
      painter->DrawRect(cell.x, cell.y, size.x, size.y);
    }
    painter->GetPen()->SetLineType(vtkPen::SOLID_LINE);
    return true;
  }
  void GetBounds(double bounds[4]) override {
    bounds[0] = bounds[2] = 0.0;
    bounds[1] = bounds[3] = 1.0;
  }
  std::vector<Cell> cells;
  glm::vec2 size{1.0f};
};
vtkStandardNewMacro(Cells)

    glm::vec3 viridis(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (std::size(kViridis) - 1);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), std::size(kViridis) - 2);
  return glm::mix(kViridis[i], kViridis[i + 1], static_cast<float>(at - static_cast<double>(i)));
}

void addCells(vtkChartXY* chart, const Json& description) {
  vtkNew<Cells> cells;
  const double x = description.at("x")[0], dx = description.at("x")[1], y = description.at("y")[0],
               dy = description.at("y")[1];
  const auto columns = description.at("columns").get<std::size_t>();
  const Json& values = description.at("values");
  const Json& palette = description.at("palette");
  cells->size = {static_cast<float>(dx), static_cast<float>(dy)};
  for (std::size_t i = 0; i < values.size(); ++i) {
    glm::vec3 colour = kNoValue;
    if (!values[i].is_null() && palette.is_array()) {
      colour = colourOf(palette.at(values[i].get<std::size_t>()));
    } else if (!values[i].is_null()) {
      const double low = description.at("scale")[0], high = description.at("scale")[1];
      colour = viridis((values[i].get<double>() - low) / (high - low));
    }
    cells->cells.push_back({static_cast<float>(x + dx * static_cast<double>(i % columns)),
                            static_cast<float>(y + dy * static_cast<double>(i / columns)), colour});
  }
  chart->AddPlot(cells);
}

void addCurve(vtkChartXY* chart, const Json& curve) {
  vtkNew<vtkDoubleArray> x, y;
  x->SetName("x");
  y->SetName("y");
  for (const Json& value : curve.at("x")) x->InsertNextValue(value);
  for (const Json& value : curve.at("y")) y->InsertNextValue(value);
  if (x->GetNumberOfValues() != y->GetNumberOfValues()) throw Error("a curve has as many x as y");
  const bool marks = curve.value("marks", false);
  if (!marks && x->GetNumberOfValues() < 2) return;  // of a run that ended at once
  vtkNew<vtkTable> table;
  table->AddColumn(x);
  table->AddColumn(y);
  vtkPlot* plot = chart->AddPlot(marks ? vtkChart::POINTS : vtkChart::LINE);
  plot->SetInputData(table, 0, 1);
  const glm::u8vec3 c = colourOf(curve.at("colour"));
  plot->SetColor(c.r, c.g, c.b, 255);
  plot->SetWidth(static_cast<float>(kOversampling * curve.value("width", marks ? 1.0 : 3.0)));
  plot->GetPen()->SetLineType(curve.value("dash", false) ? vtkPen::DASH_LINE : vtkPen::SOLID_LINE);
  if (auto* points = vtkPlotPoints::SafeDownCast(plot)) {
    points->SetMarkerStyle(marks ? vtkPlotPoints::CIRCLE : vtkPlotPoints::NONE);
    points->SetMarkerSize(static_cast<float>(kOversampling * curve.value("size", 15.0)));
  }
}

void setAxis(vtkAxis* axis, const Json& description, bool grid) {
  const glm::u8vec3 pen = colourOf(kMuted), line = colourOf(kGridLine);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetRange(description.at("range")[0].get<double>(), description.at("range")[1].get<double>());
  axis->SetTitle("");  // addTitles() places it
  setText(axis->GetLabelProperties(), kLabel, kMuted);
  axis->GetPen()->SetColor(pen.r, pen.g, pen.b, 255);
  axis->GetPen()->SetWidth(static_cast<float>(1.5 * kOversampling));
  axis->GetGridPen()->SetColor(line.r, line.g, line.b, 255);
  axis->GetGridPen()->SetWidth(static_cast<float>(1.0 * kOversampling));
  axis->SetGridVisible(grid);
  axis->SetTickLength(static_cast<float>(8 * kOversampling));
  axis->SetLabelOffset(static_cast<float>(14 * kOversampling));
  vtkNew<vtkDoubleArray> places;
  vtkNew<vtkStringArray> labels;
  for (const Json& place : description.at("ticks")) places->InsertNextValue(place);
  for (const Json& label : description.at("labels")) labels->InsertNextValue(label.get<std::string>());
  axis->SetCustomTickPositions(places, labels);
}

// Titles of the panel and its axes, clear of the numbers; a colour bar's numbers.
void addTitles(Canvas& canvas, const Json& panel, bool right) {
  const Json& place = panel.at("place");
  const double x = place[0], y = place[1], width = place[2], height = place[3];
  constexpr double kDigit = 16.0;  // width of a character of a label, about
  std::size_t longest = 0;
  for (const Json& label : panel.at("y").at("labels")) longest = std::max(longest, label.get<std::string>().size());
  const double numbers = kDigit * static_cast<double>(longest);
  if (panel.contains("title"))
    addText(
        canvas,
        {{"x", x + 0.5 * width}, {"y", y - 14.0}, {"text", panel.at("title")}, {"size", kTitle}, {"align", "centre"}});
  if (const std::string title = panel.at("x").value("title", ""); !title.empty())
    addText(canvas,
            {{"x", x + 0.5 * width}, {"y", y + height + 92.0}, {"text", title}, {"size", kTitle}, {"align", "centre"}});
  if (const std::string title = panel.at("y").value("title", ""); !title.empty())
    addText(canvas, {{"x", right ? x + width + numbers + 66.0 : x - numbers - 36.0},
                     {"y", y + 0.5 * height},
                     {"text", title},
                     {"size", kTitle},
                     {"align", "centre"},
                     {"turned", true}});
  if (!right) return;
  const Json& axis = panel.at("y");
  const double low = axis.at("range")[0], high = axis.at("range")[1];
  for (std::size_t i = 0; i < axis.at("ticks").size(); ++i)
    addText(canvas, {{"x", x + width + 14.0},
                     {"y", y + height * (high - axis.at("ticks")[i].get<double>()) / (high - low) + 13.0},
                     {"text", axis.at("labels")[i]},
                     {"size", kLabel},
                     {"colour", kMuted}});
}

}  // namespace

void addPanel(Canvas& canvas, const Json& panel) {
  vtkNew<vtkChartXY> chart;
  const Json& place = panel.at("place");
  const double left = place[0], top = place[1], width = place[2], height = place[3];
  chart->SetAutoSize(false);
  chart->SetLayoutStrategy(vtkChart::AXES_TO_RECT);
  chart->SetSize(vtkRectf(static_cast<float>(kOversampling * left),
                          static_cast<float>(kOversampling * (canvas.size().y - top - height)),
                          static_cast<float>(kOversampling * width), static_cast<float>(kOversampling * height)));
  chart->SetShowLegend(false);
  chart->SetBackgroundBrush(nullptr);
  const bool cells = panel.contains("cells"), right = panel.at("y").value("side", "left") == "right";
  setAxis(chart->GetAxis(vtkAxis::BOTTOM), panel.at("x"), !cells);
  Json y = panel.at("y");
  if (right) y["ticks"] = y["labels"] = Json::array();  // they stand on the other side
  setAxis(chart->GetAxis(vtkAxis::LEFT), y, !cells);
  if (cells) addCells(chart, panel.at("cells"));
  for (const Json& curve : panel.value("curves", Json::array())) addCurve(chart, curve);
  canvas.charts()->AddItem(chart);
  addTitles(canvas, panel, right);
  if (panel.contains("legend")) addLegend(canvas, panel.at("legend"), place);
}

}  // namespace enamel::figures
