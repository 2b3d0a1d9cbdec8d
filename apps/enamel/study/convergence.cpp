#include "study/convergence.hpp"

#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "enamel/study/parallel.hpp"

namespace enamel::app {
namespace {

constexpr IntegrationMethod kMethods[] = {
    {Integrator::semiImplicitEuler, 1}, {Integrator::semiImplicitEuler, 2}, {Integrator::semiImplicitEuler, 4},
    {Integrator::semiImplicitEuler, 8}, {Integrator::midpoint, 1},          {Integrator::midpoint, 2},
    {Integrator::midpoint, 4},          {Integrator::midpoint, 8},          {Integrator::rungeKutta4, 1},
    {Integrator::rungeKutta4, 2},       {Integrator::rungeKutta4, 4},       {Integrator::rungeKutta4, 8}};

using MetricValues = std::array<double, kMetrics>;

// Return the metrics of a run; NaN for a missing one.
MetricValues valuesOf(const StudyResult& result) {
  MetricValues v;
  v.fill(std::nan(""));
  if (result.status != Status::ok) return v;
  for (std::size_t i = 0; i < kMetrics; ++i)
    if (const auto value = valueOf(result.metrics, allMetrics()[i])) v[i] = *value;
  return v;
}

// Smaller values (SI) are rounding errors: for example, the impedance wall has no tangential force.
constexpr double kSmallest = 1e-9;

struct RunRecord {
  StudyResult result;
  double seconds = 0.0;  // processor time for a simulated second
  std::vector<Vec3> positions;
};

double processorSeconds() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

RunRecord recordRun(const StudyPlan& study, const StudyRun& run, const IntegrationMethod& method) {
  StudyPlan plan = study;
  plan.setup.integrator = method.integrator;
  plan.setup.substeps = method.substeps;
  plan.setup.jitter = plan.setup.lostSamples = 0.0;
  for (StudyColumn& column : plan.columns) column.makePlant = {};  // use the closed form
  RunRecord record;
  const double begun = processorSeconds();
  record.result = performRun(plan, run, [&](const TickRecord& t) { record.positions.push_back(t.pose.position); });
  record.seconds = (processorSeconds() - begun) / plan.setup.duration;
  return record;
}

// Return the first run at the middle and at two opposite corners of the wall.
std::vector<StudyRun> runsOf(const StudyPlan& plan) {
  const std::size_t last = plan.points() - 1;
  const std::size_t points[] = {0, last / 2, last};
  std::vector<StudyRun> runs;
  for (std::size_t i = 0; i < plan.size(); i += static_cast<std::size_t>(plan.runs)) {
    const StudyRun run = runAt(plan, i);
    if (std::binary_search(std::begin(points), std::end(points), run.point)) runs.push_back(run);
  }
  return runs;
}

MethodError compare(const std::vector<StudyRun>& runs, const std::vector<RunRecord>& records,
                    const std::vector<RunRecord>& reference) {
  MethodError error;
  error.metrics.assign(kMetrics, 0.0);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    error.secondsPerSecond += records[i].seconds / static_cast<double>(runs.size());
    const std::size_t ticks = std::min(records[i].positions.size(), reference[i].positions.size());
    for (std::size_t t = 0; t < ticks; ++t)
      error.trajectory = std::max(error.trajectory, (records[i].positions[t] - reference[i].positions[t]).norm());
    const MetricValues ours = valuesOf(records[i].result), theirs = valuesOf(reference[i].result);
    for (std::size_t m = 0; m < kMetrics; ++m) {
      if (std::isnan(ours[m]) && std::isnan(theirs[m])) continue;
      double scale = kSmallest;
      for (std::size_t j = 0; j < runs.size(); ++j)
        if (runs[j].column == runs[i].column && runs[j].scenario == runs[i].scenario) {
          const double value = std::abs(valuesOf(reference[j].result)[m]);
          if (value > scale) scale = value;
        }
      const double difference = std::abs(ours[m] - theirs[m]);
      const double relative = difference == 0.0 ? 0.0 : difference / scale;  // NaN if one of both is missing
      error.metrics[m] = std::isnan(relative) ? HUGE_VAL : std::max(error.metrics[m], relative);
    }
  }
  error.worst = *std::max_element(error.metrics.begin(), error.metrics.end());
  return error;
}

}  // namespace

std::string nameOf(Integrator integrator) {
  switch (integrator) {
    case Integrator::midpoint: return "midpoint (Runge-Kutta 2)";
    case Integrator::semiImplicitEuler: return "semi-implicit Euler";
    case Integrator::rungeKutta4: break;
  }
  return "Runge-Kutta 4";
}

Convergence measureConvergence(const Study& study) {
  const StudyPlan& plan = study.plan;
  const std::vector<StudyRun> runs = runsOf(plan);
  Convergence convergence;
  for (const Metric& metric : allMetrics()) convergence.metrics.emplace_back(metric.symbol);
  const auto record = [&](const IntegrationMethod& method) {
    std::vector<RunRecord> records(runs.size());
    parallelFor(runs.size(), study.options.threads,
                [&](std::size_t i) { records[i] = recordRun(plan, runs[i], method); });
    return records;
  };
  const std::vector<RunRecord> reference = record(convergence.reference);
  for (const IntegrationMethod& method : kMethods) {
    MethodError error = compare(runs, record(method), reference);
    error.method = method;
    convergence.methods.push_back(error);
  }
  convergence.referenceError = convergence.methods.back().worst;
  const std::vector<MethodError>& methods = convergence.methods;
  convergence.cheapest = methods.size();
  for (std::size_t i = 0; i < methods.size(); ++i) {
    if (!(methods[i].worst < convergence.allowed)) continue;
    // More steps always cost more: do not let a noisy clock decide.
    if (i > 0 && methods[i - 1].method.integrator == methods[i].method.integrator &&
        methods[i - 1].worst < convergence.allowed)
      continue;
    if (convergence.cheapest == methods.size() ||
        methods[i].secondsPerSecond < methods[convergence.cheapest].secondsPerSecond)
      convergence.cheapest = i;
  }
  return convergence;
}

std::string convergenceTable(const Convergence& convergence) {
  std::string text = "integrator,substeps,processor time [s/s],trajectory error [m],worst metric error";
  for (const std::string& metric : convergence.metrics) text += ',' + metric + " error";
  text += '\n';
  for (const MethodError& m : convergence.methods) {
    text += fmt::format("{},{},{:.4g},{:.4g},{:.4g}", nameOf(m.method.integrator), m.method.substeps,
                        m.secondsPerSecond, m.trajectory, m.worst);
    for (const double error : m.metrics) text += fmt::format(",{:.4g}", error);
    text += '\n';
  }
  return text;
}

}  // namespace enamel::app
