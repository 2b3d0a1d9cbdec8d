#include "study/survey.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/study/parallel.hpp"

namespace enamel::app {
namespace {

constexpr double kDuration = 1.15;     // s: the step comes at 1 s, and the first impact ends within 50 ms
constexpr double kNeverReached = 1e6;  // N m or N

// A mechanism with motors that never saturate.
class Strong final : public Mechanism {
 public:
  explicit Strong(std::shared_ptr<const Mechanism> weak)
      : Mechanism(weak->name(), {JointVector::Constant(weak->joints(), kNeverReached), weak->limits().encoderStep}),
        weak_(std::move(weak)) {
    setHome();
  }
  Status track(const JointVector& q, const JointVector& rates, bool withInertia,
               Kinematics& k) const noexcept override {
    return weak_->track(q, rates, withInertia, k);
  }
  Status reach(const Pose& pose, const Vec6& twist, bool withInertia, Kinematics& k) const noexcept override {
    return weak_->reach(pose, twist, withInertia, k);
  }
  Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                    Vec6& acceleration) const noexcept override {
    return weak_->accelerate(pose, twist, torque, wrench, acceleration);
  }
  std::vector<Bar> bars(const Pose& pose) const override { return weak_->bars(pose); }

 private:
  std::shared_ptr<const Mechanism> weak_;
};

double stiffnessAt(const StudyColumn& column, const PushSetup& setup, std::size_t point) {
  const auto renderer = column.make(point);
  MetricsCollector collector(setup);
  (void)runPush(*column.plant, *renderer, setup, [&](const TickRecord& tick) { collector.add(tick); });
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
    PushSetup setup = setupOf(plan, {1, i / plan.points(), point, 0, kSurveyForce, 0});
    setup.hand.instant = plan.setup.hand.instant;
    setup.duration = kDuration;
    setup.hand.noise = 0.0;
    s.stiffness = stiffnessAt(column, setup, point);
    StudyColumn strong = column;
    strong.plant = std::make_shared<Strong>(column.plant);
    s.unlimited = stiffnessAt(strong, setup, point);

    setup.hand.force = kHardForce;
    const JointVector& limit = column.plant->limits().effort;
    s.peak = s.cutTicks = JointVector::Zero(limit.size());
    const auto renderer = column.make(point);
    (void)runPush(*column.plant, *renderer, setup, [&](const TickRecord& tick) {
      s.peak = s.peak.cwiseMax(tick.torque.cwiseAbs());
      s.cutTicks += (tick.torque.array().abs() >= limit.array()).cast<double>().matrix();
    });
    Kinematics there;
    (void)column.plant->reach(setup.start, Vec6::Zero(), true, there);  // cannot fail: see checkStudy()
    s.gravity = there.gravity;
    s.mass = effectiveMass(there, setup.start.position, Vec3::UnitZ());
    s.lever = there.jacobian.row(2).norm();
    s.forceLimit = largestForce(there, limit, setup.start.position, Vec3::UnitZ());
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
