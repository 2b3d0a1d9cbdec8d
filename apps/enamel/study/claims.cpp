#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"
#include "study/pairs.hpp"
#include "study/study.hpp"

namespace enamel::app {
namespace {

bool isHold(const Study& study, const WallSummary& servo) { return servo.column == study.column(ColumnKind::hold); }

// Return the verdict of a claim about every query point, which is found at `found` points, and its opposite at
// `against`.
std::string verdictOf(std::size_t found, std::size_t against, std::size_t count, bool isStable) {
  return !isStable || against > 0 ? "does not hold" : found == count ? "holds" : "not decided";
}

Claim firstImpactClaim(const Study& study, const std::vector<StudyResult>& runs, const WallSummary& servo,
                       std::size_t spring) {
  const PairedQuestion question{1, &PushMetrics::firstStiffness};
  for (const PairedComparison& c : comparePairs(study.plan, runs, servo.column, {question})) {
    if (c.b != spring) continue;
    std::size_t least = 0;
    for (std::size_t p = 0; p < c.points.size(); ++p)
      if (c.points[p].mean < c.points[least].mean || std::isnan(c.points[least].mean)) least = p;
    const int found = c.count(PairedVerdict::better), against = c.count(PairedVerdict::worse);
    std::string measured = fmt::format("at {} of {} query points, not decided at {}", found, c.points.size(),
                                       c.count(PairedVerdict::undecided));
    if (std::isfinite(c.points[least].mean))
      measured += fmt::format("; nearest at {} mm: {} times", pointText(study, least), timesText(c.points[least]));
    if (servo.withoutFirst() > 0) measured += "; without K_z1: " + withoutFirstText(servo);
    return {fmt::format("scenario 1: K_z1 of {} is above that of impedance{}", study.labels[servo.column].title,
                        isHold(study, servo) ? " (paper: lowest 17 174, highest 3112.6 N/m)" : ""),
            measured,
            verdictOf(static_cast<std::size_t>(found), static_cast<std::size_t>(against), c.points.size(),
                      servo.stable() && servo.withoutFirst() == 0)};
  }
  return {};
}

// |mean C_zs| of the servo is below the spring's where both the spring's minus and plus the servo's are positive.
Claim steadyClaim(const Study& study, const std::vector<StudyResult>& runs, const WallSummary& servo,
                  std::size_t spring, std::size_t scenario) {
  const StudyPlan& plan = study.plan;
  const std::size_t count = plan.points(), each = static_cast<std::size_t>(plan.runs);
  std::vector<MeanDifference> differences;  // of each point: minus, plus
  std::vector<Spread> ours, theirs;
  std::vector<double> ps;
  std::size_t lost = 0;
  for (std::size_t point = 0; point < count; ++point) {
    std::vector<double> servos, springs, minus, plus;
    for (std::size_t run = 0; run < each; ++run) {
      const auto at = [&](std::size_t column) -> const StudyResult& {
        return runs[((scenario * plan.columns.size() + column) * count + point) * each + run];
      };
      if (isLost(at(servo.column)) || isLost(at(spring))) continue;
      servos.push_back(at(servo.column).metrics.steadyCompliance);
      springs.push_back(at(spring).metrics.steadyCompliance);
      minus.push_back(springs.back() - servos.back());
      plus.push_back(springs.back() + servos.back());
    }
    lost += servos.empty();
    ours.push_back(spreadOf(servos));
    theirs.push_back(spreadOf(springs));
    for (const auto* values : {&minus, &plus}) {
      differences.push_back(meanDifference(spreadOf(*values)));
      ps.push_back(differences.back().p);
    }
  }
  ps = holm(ps);
  std::size_t found = 0, against = 0, worst = 0;
  double most = -1.0;
  for (std::size_t p = 0; p < count; ++p) {
    const auto sign = [&](std::size_t i) { return !(ps[i] < 0.05) ? 0 : differences[i].mean > 0.0 ? 1 : -1; };
    found += sign(2 * p) > 0 && sign(2 * p + 1) > 0;
    against += sign(2 * p) < 0 || sign(2 * p + 1) < 0;
    if (const double ratio = std::abs(ours[p].mean / theirs[p].mean); ratio > most) worst = p, most = ratio;
  }
  std::string measured = fmt::format("at {} of {} query points", found, count);
  if (most >= 0.0)  // the ratio's interval to first order
    measured += fmt::format("; nearest at {} mm: {} of it", pointText(study, worst),
                            meanText(most, std::hypot(halfInterval(ours[worst]), most * halfInterval(theirs[worst])) /
                                               std::abs(theirs[worst].mean)));
  if (lost > 0) measured += fmt::format("; at {} no pair of runs could be finished", lost);
  const char* paper = servo.scenario == 1 ? " (paper: lowest K_zs 92 387, highest 6180.5 N/m)"
                                          : " (paper: lowest K_zs 65 002, highest 6202.1 N/m)";
  return {fmt::format("scenario {}: |mean C_zs| of {} is below that of impedance{}", servo.scenario,
                      study.labels[servo.column].title, isHold(study, servo) ? paper : ""),
          measured, verdictOf(found, against, count, servo.stable())};
}

Claim depthClaim(const Study& study, const WallSummary& servo) {
  const std::size_t runs = study.plan.points() * static_cast<std::size_t>(study.plan.runs);
  return {fmt::format("scenario {}: in every run, the largest penetration of {} is below 1 mm", servo.scenario,
                      study.labels[servo.column].title),
          !anyFinished(study, servo) ? lostText(servo)
                                     : fmt::format("{:.3f} mm in {} runs{}", 1e3 * servo.largestDepth, runs,
                                                   servo.failed > 0 ? ", and " + lostText(servo) : std::string()),
          servo.largestDepth < 1e-3 && servo.stable() ? "holds" : "does not hold"};
}

}  // namespace

std::vector<Claim> claimsOf(const Study& study, const std::vector<StudyResult>& runs,
                            const std::vector<WallSummary>& walls) {
  const std::size_t spring = study.column(ColumnKind::impedance), columns = study.plan.columns.size();
  std::vector<Claim> claims;
  for (std::size_t s = 0; s < study.plan.scenarios.size(); ++s)
    for (const ColumnKind kind : {ColumnKind::hold, ColumnKind::positionControl}) {
      const std::size_t column = study.column(kind);
      if (column == columns) continue;
      const WallSummary& servo = walls[s * columns + column];
      if (spring < columns) {
        if (servo.scenario == 1) claims.push_back(firstImpactClaim(study, runs, servo, spring));
        claims.push_back(steadyClaim(study, runs, servo, spring, s));
      }
      claims.push_back(depthClaim(study, servo));
    }
  return claims;
}

}  // namespace enamel::app
