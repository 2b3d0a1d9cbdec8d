// Pushes without noise that explain the maps: how the stiffness runs over the wall, which motor saturates, and whether
// that is why.
#pragma once

#include "study/study.hpp"

namespace enamel::app {

inline constexpr double kSurveyForce = 12.0, kHardForce = 15.0;  // N

/// One query point and column: steps of scenario 1 without noise.
struct SurveyPoint {
  double stiffness = 0.0;   ///< K_z1 at kSurveyForce, N/m; NaN where there is no first impact
  double unlimited = 0.0;   ///< the same with motors that never saturate
  JointVector peak;         ///< largest |torque| of each joint at kHardForce, N m or N
  JointVector cutTicks;     ///< ticks that each joint spends at its limit at kHardForce
  JointVector gravity;      ///< torque that balances gravity, N m or N
  double mass = 0.0;        ///< effective along the normal, kg
  double lever = 0.0;       ///< |dz/dq| of the joints together, m/rad
  double forceLimit = 0.0;  ///< what the motors can give along the normal after gravity, N
};

/// Column by column, point by point.
using Survey = std::vector<std::vector<SurveyPoint>>;
Survey surveyWall(const Study& study);

/// (largest - smallest) / mean of K_z1. NaN where a point has none.
double uniformityOf(const std::vector<SurveyPoint>& points);

/// Mean over x of a quantity at each y, from the lowest y.
std::vector<double> rowMeans(const Study& study, const std::vector<double>& values);

/// Correlation of two quantities over the wall (Pearson). NaN where one of them is constant.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

template <typename Function>
std::vector<double> over(const std::vector<SurveyPoint>& points, const Function& value) {
  std::vector<double> values;
  for (const SurveyPoint& point : points) values.push_back(value(point));
  return values;
}

}  // namespace enamel::app
