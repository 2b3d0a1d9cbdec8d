#include <fmt/core.h>

#include <cmath>

#include "study/numbers.hpp"
#include "study/study.hpp"

namespace enamel::app {

std::vector<Claim> claimsOf(const Study& study, const std::vector<PointStatistics>& points,
                            const std::vector<WallSummary>& walls) {
  const std::size_t spring = study.column(ColumnKind::impedance), columns = study.plan.columns.size(),
                    count = study.plan.points();
  std::vector<Claim> claims;
  const auto pointAt = [&](std::size_t scenario, std::size_t column, std::size_t point) -> const PointStatistics& {
    return points[(scenario * columns + column) * count + point];
  };
  const auto firstText = [&](std::size_t scenario, std::size_t column, std::size_t point) {
    return meanText(pointAt(scenario, column, point).of(&PushMetrics::firstStiffness));
  };
  for (std::size_t s = 0; s < study.plan.scenarios.size(); ++s) {
    const int scenario = study.plan.scenarios[s];
    for (const ColumnKind kind : {ColumnKind::hold, ColumnKind::positionControl}) {
      const std::size_t column = study.column(kind);
      if (column == columns) continue;
      const std::string& title = study.labels[column].title;
      const WallSummary& servo = walls[s * columns + column];
      if (spring < columns) {
        const WallSummary& wall = walls[s * columns + spring];
        if (scenario == 1 && servo.lowestFirst && wall.highestFirst)
          claims.push_back(
              {fmt::format("scenario 1: the lowest K_z1 of {} is above the highest of impedance", title),
               fmt::format("{} N/m at {} mm, {} N/m at {} mm", firstText(s, column, servo.lowestFirst->point),
                           pointText(study, servo.lowestFirst->point), firstText(s, spring, wall.highestFirst->point),
                           pointText(study, wall.highestFirst->point)),
               servo.lowestFirst->value > wall.highestFirst->value && servo.withoutFirst() == 0 && servo.stable()});
        std::size_t below = 0, worst = 0, lost = 0;
        double worstRatio = -1.0, half = 0.0;  // half: half of the ratio's 95 % interval, to first order
        for (std::size_t p = 0; p < count; ++p) {
          const Spread &ours = pointAt(s, column, p).of(&PushMetrics::steadyCompliance),
                       &theirs = pointAt(s, spring, p).of(&PushMetrics::steadyCompliance);
          const double ratio = std::abs(ours.mean / theirs.mean);
          below += ratio < 1.0;
          lost += !std::isfinite(ratio);
          if (!(ratio > worstRatio)) continue;
          worst = p;
          worstRatio = ratio;
          half = std::hypot(halfInterval(ours), ratio * halfInterval(theirs)) / std::abs(theirs.mean);
        }
        claims.push_back(
            {fmt::format("scenario {}: |mean C_zs| of {} is below that of impedance", scenario, title),
             fmt::format("at {} of {} query points{}{}", below, count,
                         worstRatio < 0.0 ? ""
                                          : fmt::format("; nearest at {} mm: {} of it", pointText(study, worst),
                                                        meanText(worstRatio, half)),
                         lost > 0 ? fmt::format("; at {} no run could be finished", lost) : ""),
             below == count && servo.stable()});
      }
      claims.push_back({fmt::format("scenario {}: the largest penetration of {} is below 1 mm", scenario, title),
                        !anyFinished(study, servo)
                            ? lostText(servo)
                            : fmt::format("{:.3f} mm{}", 1e3 * servo.largestDepth,
                                          servo.failed > 0 ? ", and " + lostText(servo) : std::string()),
                        servo.largestDepth < 1e-3 && servo.stable()});
    }
  }
  return claims;
}

}  // namespace enamel::app
