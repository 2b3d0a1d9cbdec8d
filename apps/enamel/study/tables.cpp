#include <fmt/core.h>

#include <cmath>

#include "json_matrices.hpp"
#include "study/numbers.hpp"
#include "study/study.hpp"

namespace enamel::app {
namespace {

// Return null for a value that does not exist, rather than 0 or infinity.
Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// Return the label of a stiffness: the force divided by this depth, as "rms depth [N/m]".
std::string perForce(const MetricMember& depth) { return fmt::format("{} [N/m]", allMetrics()[indexOf(depth)].symbol); }

const char* firstSymbol() { return allMetrics()[indexOf(&PushMetrics::firstStiffness)].symbol; }

}  // namespace

std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points) {
  std::string text = "scenario,renderer,x [m],y [m],runs,failed";
  for (const FirstImpactVerdict verdict : kWithoutFirst) text += fmt::format(",{}", toString(verdict));
  for (const Metric& metric : allMetrics())
    text += fmt::format(",mean {},deviation {}", enamel::keyOf(metric), enamel::keyOf(metric));
  text += fmt::format(",runs with {},K_zs [N/m],mean F_c/{},mean F_c/{},largest {},largest {},faults\n", firstSymbol(),
                      perForce(&PushMetrics::rmsDepth), perForce(&PushMetrics::depth95),
                      keyOf(&PushMetrics::largestDepth), keyOf(&PushMetrics::drift));
  for (const PointStatistics& p : points) {
    const Vec3 at = queryPoint(study.plan, p.point);
    const bool any = p.failed < p.runs;
    text += fmt::format("{},{},{},{},{},{}", p.scenario, study.plan.columns[p.column].name, at.x(), at.y(), p.runs,
                        p.failed);
    for (const FirstImpactVerdict verdict : kWithoutFirst)
      text += fmt::format(",{}", p.verdicts[static_cast<std::size_t>(verdict)]);
    for (const Spread& s : p.metrics) text += ',' + cellText(s.mean) + ',' + cellText(s.deviation);
    text += fmt::format(",{},{},{},{},{},{},{}\n", p.of(&PushMetrics::firstStiffness).count,
                        p.steadyStiffness ? fmt::format("{}", *p.steadyStiffness)
                        : any             ? "unresolved"
                                          : "",
                        cellText(p.forceOverRms.mean), cellText(p.forceOver95.mean),
                        any ? fmt::format("{}", p.largestDepth) : "", any ? fmt::format("{}", p.drift) : "", p.faults);
  }
  return text;
}

std::string summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims) {
  Json summary;
  summary["study"] = Json::parse(study.manifest);
  Json& list = summary["walls"] = Json::array();
  const auto extreme = [&study](const std::optional<Extreme>& e) -> Json {
    if (!e || !std::isfinite(e->value)) return nullptr;
    const Vec3 at = queryPoint(study.plan, e->point);
    return {{"value", e->value}, {"x [m]", at.x()}, {"y [m]", at.y()}};
  };
  for (const WallSummary& w : walls) {
    const auto largest = [any = anyFinished(study, w)](double value) { return any ? Json(value) : Json(nullptr); };
    Json json;
    json["scenario"] = w.scenario;
    json["renderer"] = study.plan.columns[w.column].name;
    json["plant's damping along z [N s/m]"] = study.labels[w.column].damping;
    json["lowest " + keyOf(&PushMetrics::firstStiffness)] = extreme(w.lowestFirst);
    json["highest " + keyOf(&PushMetrics::firstStiffness)] = extreme(w.highestFirst);
    json["lowest " + keyOf(&PushMetrics::depthStiffness)] = extreme(w.lowestDepthStiffness);
    json["mean " + keyOf(&PushMetrics::depthStiffness)] = numberOrNull(w.depthStiffness.mean);
    json["lowest mean " + keyOf(&PushMetrics::limitShare)] = extreme(w.lowestShare);
    json["lowest K_zs [N/m]"] = extreme(w.lowestSteady);
    json["highest K_zs [N/m]"] = extreme(w.highestSteady);
    json["mean K_zs [N/m]"] = numberOrNull(w.steady.mean);
    json["deviation K_zs over the wall [N/m]"] = numberOrNull(w.steady.deviation);
    json["points with K_zs unresolved"] = w.unresolved;
    json["lowest |mean C_zs| [m/N]"] = extreme(w.lowestCompliance);
    json["highest |mean C_zs| [m/N]"] = extreme(w.highestCompliance);
    json["lowest mean F_c/" + perForce(&PushMetrics::rmsDepth)] = numberOrNull(w.lowestOverRms);
    json["lowest mean F_c/" + perForce(&PushMetrics::depth95)] = numberOrNull(w.lowestOver95);
    json[keyOf(&PushMetrics::largestDepth)] = largest(w.largestDepth);
    json["largest " + keyOf(&PushMetrics::drift)] = largest(w.drift);
    json["largest mean " + keyOf(&PushMetrics::chatter)] = largest(w.chatter);
    json["largest mean " + keyOf(&PushMetrics::saturatedShare)] = largest(w.saturatedShare);
    json["largest mean " + keyOf(&PushMetrics::tangentialForce)] = largest(w.tangentialForce);
    json["largest mean " + keyOf(&PushMetrics::bounce)] = largest(w.bounce);
    json["runs that left the workspace"] = w.failed - w.stopped;
    json["runs stopped by the guard"] = w.stopped;
    Json& without = json[std::string("runs without ") + firstSymbol()];
    for (const FirstImpactVerdict verdict : kWithoutFirst)
      without[toString(verdict)] = w.verdicts[static_cast<std::size_t>(verdict)];
    json["faults"] = w.faults;
    list.push_back(json);
  }
  summary["claims"] = Json::array();
  for (const Claim& c : claims)
    summary["claims"].push_back({{"claim", c.text}, {"verdict", c.verdict}, {"measured", c.measured}});
  return textOf(summary);
}

}  // namespace enamel::app
