#include "study/survey.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/control/device_plant.hpp"
#include "enamel/study/parallel.hpp"

namespace enamel::app {
namespace {

constexpr double kDuration = 1.15;     // s: the step comes at 1 s, the first impact ends within 50 ms
constexpr double kNeverReached = 1e6;  // N m

double stiffnessAt(const StudyColumn& column, const PushSetup& setup, std::size_t point) {
  const auto renderer = column.make(point);
  MetricsCollector collector(setup);
  (void)runPush(column.plant, *renderer, setup, [&](const TickRecord& tick) { collector.add(tick); });
  return collector.metrics().firstStiffness.value_or(std::nan(""));
}

}  // namespace

Survey surveyWall(const Study& study) {
  const StudyPlan& plan = study.plan;
  Survey survey(plan.columns.size(), std::vector<SurveyPoint>(plan.points()));
  parallelFor(survey.size() * plan.points(), study.options.threads, [&](std::size_t i) {
    const std::size_t point = i % plan.points();
    const StudyColumn& column = plan.columns[i / plan.points()];
    SurveyPoint& s = survey[i / plan.points()][point];
    PushSetup setup = plan.setup;
    setup.start.position = queryPoint(plan, point);
    setup.duration = kDuration;
    setup.person.scenario = 1;
    setup.person.noise = 0.0;
    setup.person.force = kSurveyForce;
    s.stiffness = stiffnessAt(column, setup, point);
    StudyColumn strong = column;
    strong.plant.maxTorque = kNeverReached;
    s.unlimited = stiffnessAt(strong, setup, point);

    setup.person.force = kHardForce;
    const auto renderer = column.make(point);
    (void)runPush(column.plant, *renderer, setup, [&](const TickRecord& tick) {
      s.peak = s.peak.cwiseMax(tick.torque.cwiseAbs());
      s.cutTicks += (tick.torque.array().abs() >= column.plant.maxTorque).cast<double>().matrix();
    });
    const DevicePlant plant = devicePlant(column.plant, setup.start);
    s.gravity = plant.u0;
    s.mass = plant.effectiveMass;
    s.lever = plant.jacobian.row(2).norm();
    s.forceLimit = plant.largestForce;
  });
  return survey;
}

double uniformityOf(const std::vector<SurveyPoint>& points) {
  double low = HUGE_VAL, high = -HUGE_VAL, sum = 0.0;
  for (const SurveyPoint& p : points) {
    if (std::isnan(p.stiffness)) return p.stiffness;
    low = std::min(low, p.stiffness);
    high = std::max(high, p.stiffness);
    sum += p.stiffness;
  }
  return (high - low) / (sum / static_cast<double>(points.size()));
}

std::vector<double> rowMeans(const Study& study, const std::vector<double>& values) {
  const auto side = static_cast<std::size_t>(study.plan.grid);
  std::vector<double> means(side, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) means[i / side] += values[i] / static_cast<double>(side);
  return means;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double meanA = spreadOf(a).mean, meanB = spreadOf(b).mean;
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - meanA) * (b[i] - meanB);
    aa += (a[i] - meanA) * (a[i] - meanA);
    bb += (b[i] - meanB) * (b[i] - meanB);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : std::nan("");
}

}  // namespace enamel::app
