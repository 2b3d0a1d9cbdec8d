#include "enamel/study/monte_carlo.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/message.hpp"

namespace enamel {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string millimetres(double metres) { return formatNumber(1e-6 * std::nearbyint(1e9 * metres)); }

}  // namespace

std::size_t StudyPlan::size() const {
  return scenarios.size() * columns.size() * points() * static_cast<std::size_t>(runs);
}

void checkStudy(const StudyPlan& plan) {
  require(plan.grid >= 1 && plan.grid <= kMaxGrid, "grid is " + std::to_string(plan.grid) + ", must be in 1 to " +
                                                       std::to_string(kMaxGrid) + " query points a side");
  require(plan.runs >= 1 && plan.runs <= kMaxRuns,
          "runs is " + std::to_string(plan.runs) + ", must be in 1 to " + std::to_string(kMaxRuns) + " a query point");
  require(!plan.scenarios.empty(), "the study has no scenario");
  require(!plan.columns.empty(), "the study has no renderer");
  PushSetup setup = plan.setup;
  for (const int scenario : plan.scenarios) {
    setup.hand.scenario = scenario;
    checkPush(setup);
  }
  for (const StudyColumn& column : plan.columns)
    for (std::size_t point = 0; point < plan.points(); ++point) {
      Pose pose = plan.setup.start;
      pose.position = queryPoint(plan, point);
      Kinematics unused;
      const Status status = column.plant->reach(pose, Vec6::Zero(), false, unused);
      require(status == Status::ok, "query point (" + millimetres(pose.position.x()) + ", " +
                                        millimetres(pose.position.y()) + ") mm is " + toString(status));
    }
}

Vec3 queryPoint(const StudyPlan& plan, std::size_t point) noexcept {
  if (plan.grid <= 1) return plan.middle;
  const auto side = static_cast<std::size_t>(plan.grid);
  const auto along = [&plan](std::size_t i) {  // rounded to nanometres, so that the numbers are readable
    const double steps = static_cast<double>(plan.grid - 1);
    return std::nearbyint(1e9 * plan.halfWidth * (2.0 * static_cast<double>(i) - steps) / steps) / 1e9;
  };
  return plan.middle + Vec3(along(point % side), along(point / side), 0.0);
}

StudyRun runAt(const StudyPlan& plan, std::size_t index) {
  require(plan.runs >= 1 && index < plan.size(), "run " + std::to_string(index) + " does not exist, the study has " +
                                                     std::to_string(plan.runs >= 1 ? plan.size() : 0) + " runs");
  const auto runs = static_cast<std::size_t>(plan.runs);
  StudyRun run;
  run.run = static_cast<int>(index % runs);
  run.point = index / runs % plan.points();
  run.column = index / runs / plan.points() % plan.columns.size();
  run.scenario = plan.scenarios[index / runs / plan.points() / plan.columns.size()];
  run.stream =
      (static_cast<std::uint32_t>(run.scenario - 1) * kMaxGrid * kMaxGrid + static_cast<std::uint32_t>(run.point)) *
          kMaxRuns +
      static_cast<std::uint32_t>(run.run);
  const double share = RandomStream(plan.setup.seed, run.stream).uniform(RandomStream::Purpose::force, 0);
  run.force = plan.lowestForce + (plan.highestForce - plan.lowestForce) * share;
  return run;
}

PushSetup setupOf(const StudyPlan& plan, const StudyRun& run) {
  require(run.column < plan.columns.size() && run.point < plan.points(),
          "column " + std::to_string(run.column) + " or point " + std::to_string(run.point) +
              " does not exist, the study has " + std::to_string(plan.columns.size()) + " columns and " +
              std::to_string(plan.points()) + " points");
  PushSetup setup = plan.setup;
  setup.start.position = queryPoint(plan, run.point);
  setup.hand.scenario = run.scenario;
  setup.hand.force = run.force;
  setup.run = run.stream;
  if (plan.insideTick) setup.hand.instant = randomInstant(setup.seed, setup.run);
  if (const double period = plan.columns[run.column].period; period > 0.0) {
    const double ticks = std::nearbyint(setup.period / period);
    require(ticks >= 1.0 && std::abs(ticks * period - setup.period) < 1e-9 * setup.period,
            plan.columns[run.column].name + ": a period of " + formatNumber(setup.period) + " s is not a multiple of " +
                formatNumber(period) + " s");
    setup.period = period;
    setup.delay.low *= static_cast<int>(ticks);
    setup.delay.high *= static_cast<int>(ticks);
    setup.hand.noise *= std::sqrt(ticks);
  }
  return setup;
}

StudyResult performRun(const StudyPlan& plan, const StudyRun& run,
                       const std::function<void(const TickRecord&)>& record) {
  const PushSetup setup = setupOf(plan, run);
  const StudyColumn& column = plan.columns[run.column];
  const std::unique_ptr<Renderer> renderer = column.make(run.point);
  MetricsCollector collector(setup, largestStiffness(*column.plant, setup), column.plant->limits().effort);
  StudyResult result;
  result.run = run;
  std::unique_ptr<Plant> plant =
      column.makePlant ? column.makePlant(run.stream)
                       : std::make_unique<ClosedFormPlant>(*column.plant, setup.integrator, setup.substeps);
  const PushResult push = runPush(std::move(plant), column.model ? *column.model : *column.plant, *renderer, setup,
                                  [&](const TickRecord& tick, const VirtualLoop&) {
                                    collector.add(tick);
                                    if (record) record(tick);
                                  });
  result.status = push.status;
  if (result.status == Status::ok) result.metrics = collector.metrics();
  if (result.status == Status::stopped) result.metrics.verdict = FirstImpactVerdict::unstable;
  return result;
}

bool isLost(const StudyResult& run) noexcept {
  return run.status != Status::ok || run.metrics.verdict == FirstImpactVerdict::unstable;
}

Spread spreadOf(const std::vector<double>& values) {
  Spread spread{static_cast<int>(values.size()), kNone, kNone};
  if (values.empty()) return spread;
  const double count = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  spread.mean = sum / count;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  if (values.size() > 1) spread.deviation = std::sqrt(squares / (count - 1.0));
  return spread;
}

PointStatistics statisticsOf(const std::vector<StudyResult>& runs) {
  PointStatistics s;
  s.runs = static_cast<int>(runs.size());
  if (runs.empty()) return s;
  s.scenario = runs.front().run.scenario;
  s.column = runs.front().run.column;
  s.point = runs.front().run.point;
  std::array<std::vector<double>, kMetrics> values;
  std::vector<double> overRms, over95;
  for (const StudyResult& result : runs) {
    if (result.status != Status::ok) {
      ++s.failed;
      s.stopped += result.status == Status::stopped;
      continue;
    }
    const PushMetrics& m = result.metrics;
    ++s.verdicts[static_cast<std::size_t>(m.verdict)];
    for (std::size_t i = 0; i < kMetrics; ++i)
      if (const auto value = valueOf(m, allMetrics()[i])) values[i].push_back(*value);
    if (m.rmsDepth > 0.0) overRms.push_back(result.run.force / m.rmsDepth);
    if (m.depth95 > 0.0) over95.push_back(result.run.force / m.depth95);
    s.largestDepth = std::max(s.largestDepth, m.largestDepth);
    s.drift = std::max(s.drift, m.drift);
    s.faults += m.faults;
  }
  for (std::size_t i = 0; i < kMetrics; ++i) s.metrics[i] = spreadOf(values[i]);
  s.forceOverRms = spreadOf(overRms);
  s.forceOver95 = spreadOf(over95);
  const Spread& compliance = s.of(&PushMetrics::steadyCompliance);
  // A deviation of NaN (fewer than two runs) never gives a stiffness.
  const double standardError = compliance.deviation / std::sqrt(static_cast<double>(compliance.count));
  const double mean = std::abs(compliance.mean);
  const bool stable = s.verdicts[static_cast<std::size_t>(FirstImpactVerdict::unstable)] == 0;
  if (stable && mean >= 2.0 * standardError && mean > 0.0) s.steadyStiffness = 1.0 / mean;
  return s;
}

std::vector<PointStatistics> pointStatistics(const StudyPlan& plan, const std::vector<StudyResult>& results) {
  require(plan.runs >= 1, "runs is " + std::to_string(plan.runs) + ", must be at least 1 a query point");
  const auto runs = static_cast<std::size_t>(plan.runs);
  std::vector<PointStatistics> points;
  for (std::size_t first = 0; first + runs <= results.size(); first += runs) {
    const auto begin = results.begin() + static_cast<std::ptrdiff_t>(first);
    points.push_back(statisticsOf({begin, begin + plan.runs}));
  }
  return points;
}

std::vector<WallSummary> summarise(const StudyPlan& plan, const std::vector<PointStatistics>& points) {
  const auto lower = [](std::optional<Extreme>& extreme, double value, std::size_t point) {
    if (std::isfinite(value) && (!extreme || value < extreme->value)) extreme = Extreme{value, point};
  };
  const auto higher = [](std::optional<Extreme>& extreme, double value, std::size_t point) {
    if (std::isfinite(value) && (!extreme || value > extreme->value)) extreme = Extreme{value, point};
  };
  // A missing mean (every run failed) must not count as the smallest.
  const auto larger = [](double a, double b) { return std::isnan(b) ? a : std::max(a, b); };
  require(plan.grid >= 1, "grid is " + std::to_string(plan.grid) + ", must be at least 1 query point a side");
  std::vector<WallSummary> summaries;
  for (std::size_t first = 0; first + plan.points() <= points.size(); first += plan.points()) {
    WallSummary w;
    w.scenario = points[first].scenario;
    w.column = points[first].column;
    std::optional<Extreme> overRms, over95;
    std::vector<double> steady, depthStiffness;
    for (std::size_t i = first; i < first + plan.points(); ++i) {
      const PointStatistics& p = points[i];
      lower(w.lowestFirst, p.of(&PushMetrics::firstStiffness).mean, p.point);
      lower(w.lowestDepthStiffness, p.of(&PushMetrics::depthStiffness).mean, p.point);
      if (const double k = p.of(&PushMetrics::depthStiffness).mean; std::isfinite(k)) depthStiffness.push_back(k);
      lower(w.lowestShare, p.of(&PushMetrics::limitShare).mean, p.point);
      higher(w.highestFirst, p.of(&PushMetrics::firstStiffness).mean, p.point);
      if (p.steadyStiffness) {
        lower(w.lowestSteady, *p.steadyStiffness, p.point);
        higher(w.highestSteady, *p.steadyStiffness, p.point);
        steady.push_back(*p.steadyStiffness);
      } else {
        ++w.unresolved;
      }
      lower(w.lowestCompliance, std::abs(p.of(&PushMetrics::steadyCompliance).mean), p.point);
      higher(w.highestCompliance, std::abs(p.of(&PushMetrics::steadyCompliance).mean), p.point);
      lower(overRms, p.forceOverRms.mean, p.point);
      lower(over95, p.forceOver95.mean, p.point);
      w.largestDepth = larger(w.largestDepth, p.largestDepth);
      w.drift = larger(w.drift, p.drift);
      w.chatter = larger(w.chatter, p.of(&PushMetrics::chatter).mean);
      w.saturatedShare = larger(w.saturatedShare, p.of(&PushMetrics::saturatedShare).mean);
      w.bounce = larger(w.bounce, p.of(&PushMetrics::bounce).mean);
      w.tangentialForce = larger(w.tangentialForce, p.of(&PushMetrics::tangentialForce).mean);
      w.failed += p.failed;
      w.stopped += p.stopped;
      w.faults += p.faults;
      for (int v = 0; v < kVerdicts; ++v) w.verdicts[v] += p.verdicts[v];
    }
    w.lowestOverRms = overRms ? overRms->value : kNone;
    w.lowestOver95 = over95 ? over95->value : kNone;
    w.steady = spreadOf(steady);
    w.depthStiffness = spreadOf(depthStiffness);
    summaries.push_back(w);
  }
  return summaries;
}

int WallSummary::withoutFirst() const noexcept {
  int count = 0;
  for (const FirstImpactVerdict v : {FirstImpactVerdict::noReturn, FirstImpactVerdict::rings, FirstImpactVerdict::slips,
                                     FirstImpactVerdict::flies, FirstImpactVerdict::unstable})
    count += verdicts[static_cast<std::size_t>(v)];
  return count;
}

}  // namespace enamel
