// Live charts of penetration, normal force and joint torques.
#pragma once

#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPlot.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>

#include <array>
#include <string>
#include <vector>

#include "layout.hpp"
#include "runner.hpp"
#include "signal_history.hpp"
#include "torque_style.hpp"

namespace enamel::viewer {

class Charts {
 public:
  static constexpr int kMaxSignals = 2 + kMaxJoints;  ///< penetration [mm], force [N], torques
  using History = SignalHistory<kMaxSignals>;

  /// `font`: a TrueType file, or empty. `period`: of the samples, s. `about`: the current time is in the middle, not at
  /// the end.
  Charts(vtkRenderer* renderer, const std::string& font, const TorqueStyle& torques, double period, bool about);

  void add(const Sample& sample);
  void clear() { history_.clear(); }

  /// Draw the samples. `places`: pixels from the bottom left of the renderer's viewport. `forceLimit`: largest force of
  /// the motors along the normal, N.
  void update(const std::array<Rect, kCharts>& places, float scale, double forceLimit);

 private:
  void makeTables(double begin, double end);
  void makeChart(vtkChartXY& chart, const std::string& font, double begin, double end);
  void updateSignals();
  void updateLimits(const std::array<double, 4>& limits, float scale);
  void updateAxis(std::size_t chart, double wanted, float scale);
  void plotSignal(std::size_t chart, int signal, unsigned colour, bool dashed);
  void plotLimit(std::size_t chart, int index);

  vtkSmartPointer<vtkContextScene> scene_;
  std::array<vtkSmartPointer<vtkChartXY>, kCharts> charts_;
  vtkNew<vtkTable> table_, limits_;
  vtkNew<vtkFloatArray> time_, limitTime_;
  std::array<vtkNew<vtkFloatArray>, kMaxSignals> values_;
  std::array<vtkNew<vtkFloatArray>, 4> limitValues_;
  std::vector<vtkPlot*> lines_, limitLines_;
  std::vector<float> widths_;
  History history_;
  TorqueStyle torques_;
  std::size_t signals_;
  std::array<double, kMaxSignals> largest_{};  // largest shown values
  double lowestForce_ = 0.0;
  // Upper ends of the axes: mm, N, and the unit of TorqueStyle.
  std::array<double, kCharts> ranges_{0.1, 5.0, 2.0};
  std::array<double, kCharts> drawnRanges_{}, drawnLows_{};
  std::array<int, kCharts> shrink_{};  // frames since a smaller range would suffice
};

}  // namespace enamel::viewer
