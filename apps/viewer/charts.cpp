#include "charts.hpp"

#include <vtkAxis.h>
#include <vtkContextActor.h>
#include <vtkDoubleArray.h>
#include <vtkPen.h>
#include <vtkPlotLine.h>
#include <vtkStringArray.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"

namespace enamel::viewer {
namespace {

constexpr std::size_t kTorqueChart = 2;

vtkColor4ub bytes(unsigned rgb, unsigned char alpha = 255) {
  return {static_cast<unsigned char>(rgb >> 16 & 255), static_cast<unsigned char>(rgb >> 8 & 255),
          static_cast<unsigned char>(rgb & 255), alpha};
}

// Return the smallest 1, 2 or 5 times a power of ten that is not below a value.
double niceAbove(double value, double smallest) {
  double nice = smallest;
  while (nice < value) {
    const double mantissa = nice / std::pow(10.0, std::floor(std::log10(nice) + 1e-9));
    nice *= mantissa > 1.5 && mantissa < 3.0 ? 2.5 : 2.0;
  }
  return nice;
}

void setTicks(vtkAxis* axis, const std::vector<double>& places, const std::vector<std::string>& names) {
  vtkNew<vtkDoubleArray> positions;
  vtkNew<vtkStringArray> labels;
  for (const double place : places) positions->InsertNextValue(place);
  for (const std::string& name : names) labels->InsertNextValue(name);
  axis->SetCustomTickPositions(positions, labels);
}

// Set ticks at 1, 2 and 5 times powers of ten.
void setTicks(vtkAxis* axis, double low, double high) {
  const double raw = high / 5.0, power = std::pow(10.0, std::floor(std::log10(raw) + 1e-9));
  const double step = raw / power < 1.01 ? power : raw / power < 2.01 ? 2.0 * power : 5.0 * power;
  std::vector<double> places;
  std::vector<std::string> names;
  for (int i = static_cast<int>(std::ceil(low / step)); i * step <= high * (1.0 + 1e-9); ++i) {
    char text[16];
    std::snprintf(text, sizeof(text), "%g", i * step);
    places.push_back(i * step);
    names.emplace_back(text);
  }
  setTicks(axis, places, names);
}

}  // namespace

Charts::Charts(vtkRenderer* renderer, const std::string& font, const TorqueStyle& torques, double period, bool about)
    : torques_(torques), signals_(static_cast<std::size_t>(2 + torques.joints)) {
  const Colour paper = colour(kPaper);
  renderer->SetBackground(paper.r, paper.g, paper.b);
  vtkNew<vtkContextActor> actor;
  scene_ = actor->GetScene();
  scene_->SetRenderer(renderer);
  renderer->AddActor(actor);

  const double window = History::kBins * History::kBinTicks * period, end = about ? 0.5 * window : 0.0;
  makeTables(end - window, end);
  for (auto& chart : charts_) {
    chart = vtkSmartPointer<vtkChartXY>::New();
    makeChart(*chart, font, end - window, end);
    scene_->AddItem(chart);
  }
  plotLimit(0, 0);
  plotLimit(1, 1);
  plotLimit(kTorqueChart, 2);
  plotLimit(kTorqueChart, 3);
  plotSignal(0, 0, kDepth, false);
  plotSignal(1, 1, kForce, false);
  for (int joint = 0; joint < torques_.joints; ++joint)
    plotSignal(kTorqueChart, 2 + joint, torques_.colourOf(joint), torques_.dashed(joint));
}

void Charts::makeTables(double begin, double end) {
  constexpr int rows = 2 * History::kBins;
  const double window = end - begin;
  time_->SetName("time");
  time_->SetNumberOfValues(rows);
  for (int i = 0; i < rows; ++i)
    time_->SetValue(i, static_cast<float>(begin + window * (0.5 * i + 0.25) / History::kBins));
  table_->AddColumn(time_);
  for (std::size_t s = 0; s < signals_; ++s) {
    values_[s]->SetName(("signal" + std::to_string(s)).c_str());
    values_[s]->SetNumberOfValues(rows);
    table_->AddColumn(values_[s]);
  }
  limitTime_->SetName("time");
  limitTime_->InsertNextValue(static_cast<float>(begin));
  limitTime_->InsertNextValue(static_cast<float>(end));
  limits_->AddColumn(limitTime_);
  for (std::size_t i = 0; i < limitValues_.size(); ++i) {
    limitValues_[i]->SetName(("limit" + std::to_string(i)).c_str());
    limitValues_[i]->SetNumberOfValues(2);
    limits_->AddColumn(limitValues_[i]);
  }
}

void Charts::makeChart(vtkChartXY& chart, const std::string& font, double begin, double end) {
  chart.SetAutoSize(false);
  chart.SetShowLegend(false);
  chart.SetHiddenAxisBorder(0);
  chart.SetBackgroundBrush(nullptr);
  const bool about = end > 0.0;
  for (const int side : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
    vtkAxis* axis = chart.GetAxis(side);
    axis->SetTitle("");
    axis->SetBehavior(vtkAxis::FIXED);
    axis->GetGridPen()->SetColorF(colour(kLine).r, colour(kLine).g, colour(kLine).b);
    axis->GetPen()->SetColorF(colour(kCubeLine).r, colour(kCubeLine).g, colour(kCubeLine).b);
    axis->SetGridVisible(side == vtkAxis::LEFT || about);
    vtkTextProperty* text = axis->GetLabelProperties();
    text->SetColor(colour(kMuted).r, colour(kMuted).g, colour(kMuted).b);
    text->SetFontSize(13);
    if (!font.empty()) {
      text->SetFontFamily(VTK_FONT_FILE);
      text->SetFontFile(font.c_str());
    }
  }
  vtkAxis* bottom = chart.GetAxis(vtkAxis::BOTTOM);
  bottom->SetRange(begin, end);
  const auto time = [](double seconds) {
    char text[16];
    std::snprintf(text, sizeof(text), "%+g s", seconds);
    return std::string(text);
  };
  if (about)
    setTicks(bottom, {begin, 0.0, end}, {time(begin), "here", time(end)});
  else
    setTicks(bottom, {begin, 2 * begin / 3, begin / 3, 0.0},
             {time(begin), time(2 * begin / 3), time(begin / 3), "now"});
}

void Charts::plotSignal(std::size_t chart, int signal, unsigned colour, bool dashed) {
  vtkPlot* plot = charts_[chart]->AddPlot(vtkChart::LINE);
  plot->SetInputData(table_, 0, 1 + signal);
  const vtkColor4ub c = bytes(colour);
  plot->SetColor(c[0], c[1], c[2], 255);
  plot->GetPen()->SetLineType(dashed ? vtkPen::DASH_LINE : vtkPen::SOLID_LINE);
  lines_.push_back(plot);
  widths_.push_back(chart == kTorqueChart ? 1.3f : 1.8f);
}

void Charts::plotLimit(std::size_t chart, int index) {
  vtkPlot* plot = charts_[chart]->AddPlot(vtkChart::LINE);
  plot->SetInputData(limits_, 0, 1 + index);
  const vtkColor4ub c = bytes(kInk);
  plot->SetColor(c[0], c[1], c[2], 200);
  plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
  limitLines_.push_back(plot);
}

void Charts::add(const Sample& sample) {
  std::array<float, kMaxSignals> now{};
  now[0] = static_cast<float>(-1e3 * std::min(sample.gap, 0.0));  // NaN remains NaN, which interrupts the line
  now[1] = static_cast<float>(sample.normalForce);
  for (int i = 0; i < torques_.joints; ++i)
    now[static_cast<std::size_t>(2 + i)] = static_cast<float>(torques_.factor[i] * sample.torque[i]);
  history_.add(now);
}

void Charts::update(const std::array<Rect, kCharts>& places, float scale, double forceLimit) {
  updateSignals();
  const std::array<double, kCharts> wanted{niceAbove(1.08 * largest_[0], 0.05), niceAbove(1.08 * largest_[1], 5.0),
                                           1.5 * torques_.limit};
  for (std::size_t i = 0; i < kCharts; ++i) {
    updateAxis(i, wanted[i], scale);
    charts_[i]->SetSize(vtkRectf(places[i].x, places[i].y, places[i].width, places[i].height));
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) lines_[i]->GetPen()->SetWidth(widths_[i] * scale);
  updateLimits({1.0, forceLimit, torques_.limit, -torques_.limit}, scale);
  scene_->SetDirty(true);
}

void Charts::updateSignals() {
  largest_.fill(0.0);
  lowestForce_ = 0.0;
  for (int b = 0; b < History::kBins; ++b)
    for (std::size_t s = 0; s < signals_; ++s) {
      const History::Range& range = history_.range(s, b);
      values_[s]->SetValue(2 * b, range.lowFirst ? range.low : range.high);
      values_[s]->SetValue(2 * b + 1, range.lowFirst ? range.high : range.low);
      if (s == 1) lowestForce_ = std::min(lowestForce_, static_cast<double>(range.low));
      largest_[s] = std::max(largest_[s], static_cast<double>(std::max(range.high, -range.low)));
    }
  for (std::size_t s = 0; s < signals_; ++s) values_[s]->Modified();
  table_->Modified();
}

void Charts::updateLimits(const std::array<double, 4>& limits, float scale) {
  for (std::size_t i = 0; i < limits.size(); ++i) {
    limitValues_[i]->SetValue(0, static_cast<float>(limits[i]));
    limitValues_[i]->SetValue(1, static_cast<float>(limits[i]));
    limitValues_[i]->Modified();
    limitLines_[i]->GetPen()->SetWidth(scale);
    limitLines_[i]->SetVisible(std::abs(limits[i]) <= ranges_[i < 2 ? i : kTorqueChart]);
  }
  limits_->Modified();
}

// Grow a range at once, and shrink it after a while.
void Charts::updateAxis(std::size_t chart, double wanted, float scale) {
  double& range = ranges_[chart];
  shrink_[chart] = wanted < range ? shrink_[chart] + 1 : 0;
  if (wanted > range || shrink_[chart] > 30) range = wanted;
  vtkAxis* axis = charts_[chart]->GetAxis(vtkAxis::LEFT);
  // A force that pulls is drawn below the zero line.
  double low = chart == kTorqueChart ? -1.1 * torques_.limit : -0.03 * range;
  if (chart == 1 && lowestForce_ < low) low = -niceAbove(-1.08 * lowestForce_, 0.1 * range);
  if (range != drawnRanges_[chart] || low != drawnLows_[chart]) {
    drawnRanges_[chart] = range;
    drawnLows_[chart] = low;
    axis->SetRange(low, range);
    setTicks(axis, low, chart == kTorqueChart ? torques_.limit : range);
  }
  axis->GetGridPen()->SetWidth(scale);
}

}  // namespace enamel::viewer
