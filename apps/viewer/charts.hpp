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
#include "torque_style.hpp"

namespace enamel::viewer {

class Charts {
 public:
  static constexpr int kBins = 250;  ///< that are shown, each with its smallest and largest value
  static constexpr int kBinTicks = 12;

  /// `font`: a TrueType file, or empty. `period`: of the samples, s. `about`: the middle is now, not the end.
  Charts(vtkRenderer* renderer, const std::string& font, const TorqueStyle& torques, double period, bool about);

  void add(const Sample& sample);
  void clear();

  /// Draws the last kBins bins that were added and are complete. `places`: pixels from the bottom left of the
  /// renderer's viewport. `forceLimit`: what the motors can give along the normal, N.
  void update(const std::array<Rect, kCharts>& places, float scale, double forceLimit);

  /// Upper ends of the axes: mm, N, and as TorqueStyle has it.
  const std::array<double, kCharts>& ranges() const { return ranges_; }

 private:
  static constexpr int kMaxSignals = 2 + kMaxJoints;  // penetration [mm], force [N], torques

  struct Bin {
    std::array<float, kMaxSignals> low, high;
    std::array<bool, kMaxSignals> lowFirst;
    int count = 0;
  };

  void plotSignal(int chart, int signal, unsigned colour, bool dashed);
  void plotLimit(int chart, int index);

  vtkSmartPointer<vtkContextScene> scene_;
  std::array<vtkSmartPointer<vtkChartXY>, kCharts> charts_;
  vtkNew<vtkTable> table_, limits_;
  vtkNew<vtkFloatArray> time_, limitTime_;
  std::array<vtkNew<vtkFloatArray>, kMaxSignals> values_;
  std::array<vtkNew<vtkFloatArray>, 4> limitValues_;
  std::vector<vtkPlot*> lines_, limitLines_;
  std::vector<float> widths_;
  std::vector<Bin> bins_;  // a ring
  std::size_t current_ = 0;
  TorqueStyle torques_;
  std::size_t signals_;
  std::array<double, kCharts> ranges_{0.1, 5.0, 2.0};
  std::array<double, kCharts> drawnRanges_{}, drawnLows_{};
  std::array<int, kCharts> shrink_{};  // frames since a smaller range would do
};

}  // namespace enamel::viewer
