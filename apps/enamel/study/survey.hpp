// Pushes without noise that explain the maps: how the stiffness varies over the wall, which motor saturates, and
// whether saturation is the reason.
#pragma once

#include "study/study.hpp"

namespace enamel::app {

inline constexpr double kSurveyForce = 12.0, kHardForce = 15.0;  // N

/// One query point and column: steps of scenario 1 without noise.
struct SurveyPoint {
  double stiffness = 0.0;   ///< K_z1 at kSurveyForce, N/m; NaN without a first impact
  double unlimited = 0.0;   ///< the same with motors that never saturate
  JointVector peak;         ///< largest |torque| of each joint at kHardForce, N m or N
  JointVector cutTicks;     ///< ticks at the limit of each joint at kHardForce
  JointVector gravity;      ///< torque that balances gravity, N m or N
  double mass = 0.0;        ///< effective mass along the normal, kg
  double lever = 0.0;       ///< |dz/dq| over all joints, m/rad
  double forceLimit = 0.0;  ///< largest force of the motors along the normal in addition to gravity, N
};

/// survey[column][point].
using Survey = std::vector<std::vector<SurveyPoint>>;
Survey surveyWall(const Study& study);

/// Return (largest - smallest) / mean of K_z1. NaN if a point has no K_z1.
double uniformityOf(const std::vector<SurveyPoint>& points);

/// Return the mean over x of a quantity at each y, in ascending order of y.
std::vector<double> rowMeans(const Study& study, const std::vector<double>& values);

/// Return the correlation of two quantities over the wall (Pearson). NaN if one of them is constant.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

template <typename Function>
std::vector<double> over(const std::vector<SurveyPoint>& points, const Function& value) {
  std::vector<double> values;
  for (const SurveyPoint& point : points) values.push_back(value(point));
  return values;
}

}  // namespace enamel::app
