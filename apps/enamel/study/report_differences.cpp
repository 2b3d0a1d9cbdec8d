#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"
#include "study/report_parts.hpp"

namespace enamel::app {
namespace {

double stiffnessOf(const SurveyPoint& p) { return p.stiffness; }

// Return the means over x at each y for a column.
template <typename Value>
std::vector<double> row(const Study& study, const Findings& findings, std::size_t column, const Value& value) {
  return rowMeans(study, over(findings.survey[column], value));
}

// Describe how a value changes over a wall, from the lowest y to the highest.
std::string trend(double low, double high) {
  return fmt::format("{} by {}", high > low ? "rises" : "falls", percent(std::abs(high / low - 1.0)));
}

std::string alongY(const Study& study, const std::vector<double>& k) {
  return fmt::format(
      "<b>K_z1 along y.</b> The paper's rises with y. Here, K_z1 of hold (no noise, {:.0f} N, means over x) {} from "
      "y = {} to {} mm: {} to {} kN/m.",
      kSurveyForce, trend(k.front(), k.back()), givenText(-1e3 * study.plan.halfWidth),
      givenText(1e3 * study.plan.halfWidth), numberText(1e-3 * k.front()), numberText(1e-3 * k.back()));
}

std::string saturation(const Study& study, const std::vector<SurveyPoint>& points) {
  double unlimitedDifference = 0.0;
  for (const SurveyPoint& p : points)
    unlimitedDifference = std::max(unlimitedDifference, std::abs(p.unlimited / p.stiffness - 1.0));
  const int joints = study.mechanism->joints();
  JointVector peak = JointVector::Zero(joints), gravity = peak;
  std::vector<int> saturated(static_cast<std::size_t>(joints), 0);
  for (const SurveyPoint& p : points) {
    peak = peak.cwiseMax(p.peak);
    gravity = gravity.cwiseMax(p.gravity.cwiseAbs());
    for (int j = 0; j < joints; ++j) saturated[static_cast<std::size_t>(j)] += p.cutTicks[j] > 0.0;
  }
  Eigen::Index most = 0, heaviest = 0;
  peak.maxCoeff(&most);
  gravity.maxCoeff(&heaviest);
  std::string saturatedText;
  for (int j = 0; j < joints; ++j)
    if (const int count = saturated[static_cast<std::size_t>(j)]; count > 0)
      saturatedText += fmt::format("{}joint {} at {} of {} points", saturatedText.empty() ? "" : ", ", j + 1, count,
                                   study.plan.points());
  const double limit = study.mechanism->limits().effort[most];
  return fmt::format(
      "<b>Saturation.</b> {}Under {:.0f} N {}; the most loaded joint is {} with at most {:.2f} of {:.3g} N m. "
      "Gravity takes at most {:.3f} N m (joint {}{}). With motors that never saturate, K_z1 changes by at most {:.2g} "
      "%: saturation {} the reason for the trend.",
      study.isTau() ? "The paper suspects joint 6, which carries most of its device's weight. " : "", kHardForce,
      saturatedText.empty() ? "no joint saturates" : "motors saturate (" + saturatedText + ")", most + 1, peak[most],
      limit, gravity[heaviest], heaviest + 1, study.isTau() ? fmt::format("; joint 6: {:.3f}", gravity[5]) : "",
      100.0 * unlimitedDifference, unlimitedDifference < 0.01 ? "is not" : "is part of");
}

// A correlation is not a reason: name the reason only if both correlations are as strong as it predicts.
std::string reason(const Study& study, const Findings& findings, std::size_t hold, const std::vector<double>& k) {
  const std::vector<SurveyPoint>& points = findings.survey[hold];
  const std::vector<double> values = over(points, stiffnessOf);
  const double withMass = correlation(values, over(points, [](const SurveyPoint&p) { return p.mass; })),
               withLever = correlation(values, over(points, [](const SurveyPoint&p) { return 1.0 / p.lever; }));
  std::string text = fmt::format(
      "<b>Reason.</b> Over the wall, the correlation of K_z1 with the device's effective mass is {:.2f}. Its "
      "correlation with the inverse of the lever |dz/dq| of the joints is {:.2f}{}.",
      withMass, withLever,
      withMass > 0.7 && withLever > 0.7 ? ". The servo has the same stiffness in the joints everywhere: the tool is "
                                          "softer at points where the joints move it more"
                                        : "");
  if (const std::size_t scheduled = study.column(ColumnKind::scheduled); scheduled < study.plan.columns.size()) {
    const std::vector<double> s = row(study, findings, scheduled, stiffnessOf);
    const double gone = (s.back() / s.front() - 1.0) / (k.back() / k.front() - 1.0);
    text += fmt::format(
        " With a servo designed at every query point, K_z1 {} by {} instead of {}. Thus {:.0f} % of the trend is due "
        "to the device, the rest to the design at home.",
        s.back() > s.front() ? "rises" : "falls", percent(std::abs(s.back() / s.front() - 1.0)),
        percent(std::abs(k.back() / k.front() - 1.0)), 100.0 * gone);
  }
  return text;
}

std::string lastJoint(const Study& study, const std::vector<SurveyPoint>& points) {
  const int last = study.mechanism->joints() - 1;
  const auto low = rowMeans(study, over(points, [last](const SurveyPoint& p) { return p.peak[last]; }));
  return fmt::format(
      "<b>Joint 6.</b> {}: its largest torque under {:.0f} N is {:.3f} N m at the lowest y and {:.3f} N m at the "
      "highest.",
      low.front() > low.back() ? "As in the paper, its torque is larger at the bottom"
                               : "Unlike in the paper, its torque is larger at the top",
      kHardForce, low.front(), low.back());
}

std::string impedance(const Study& study, const Findings& findings, std::size_t spring) {
  const std::vector<double> k = row(study, findings, spring, stiffnessOf);
  const double uniformity = uniformityOf(findings.survey[spring]), rendered = study.options.impedance.stiffness;
  return fmt::format(
      "<b>Impedance.</b> {}: uniformity {} without noise. The first impact reaches {} of the rendered {:.0f} N/m.",
      uniformity < 0.05 ? "As in the paper, the map is flat" : "Unlike in the paper, the map is not flat",
      percent(uniformity), percent(spreadOf(k).mean / rendered), rendered);
}

std::string steady(const Study& study, const Findings& findings, const WallSummary& w) {
  return fmt::format(
      "<b>K_zs, scenario {}.</b> The lowest is {} N/m, the paper's is {} N/m. The servo's integrators reduce the mean "
      "penetration to zero, the rest is {}.",
      w.scenario, steadyText(pointOf(findings, w, w.lowestSteady->point).of(&PushMetrics::steadyCompliance)),
      w.scenario == 1 ? "92 387" : "65 002",
      w.scenario == 1 ? "the first impact averaged over 2 s"
      : w.unresolved > 0
          ? fmt::format("noise, so that {} of {} points are not resolved", w.unresolved, study.plan.points())
          : std::string("noise"));
}

}  // namespace

void addDifferences(Page& page, const Study& study, const Findings& findings) {
  if (study.plan.grid < 2) return;
  page.heading("Differences from the paper's device and their reasons");
  for (const auto& points : findings.survey)
    if (!std::isfinite(uniformityOf(points))) {
      page.paragraph("At some query points a push has no first impact, so this report states no trend.");
      return;
    }
  const std::size_t hold = study.column(ColumnKind::hold), spring = study.column(ColumnKind::impedance),
                    none = study.plan.columns.size();
  std::vector<std::string> items;
  if (hold < none) {
    const std::vector<double> k = row(study, findings, hold, stiffnessOf);
    items.push_back(alongY(study, k));
    items.push_back(saturation(study, findings.survey[hold]));
    items.push_back(reason(study, findings, hold, k));
    if (study.isTau()) items.push_back(lastJoint(study, findings.survey[hold]));
  }
  if (spring < none) items.push_back(impedance(study, findings, spring));
  for (const WallSummary& w : findings.walls)
    if (w.column == hold && w.lowestSteady) items.push_back(steady(study, findings, w));
  page.list(items);
}

}  // namespace enamel::app
