#include "enamel/study/comparison.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

double meanOf(const std::vector<double>& values) { return spreadOf(values).mean; }

std::vector<double> ranksBy(const ComparisonCriterion& criterion, const std::vector<RendererScore>& scores) {
  const auto key = [&](const RendererScore& s) {
    const double value = criterion.value(s);
    if (std::isnan(value)) return std::make_pair(s.lost, std::numeric_limits<double>::infinity());
    return std::make_pair(s.lost, criterion.moreIsBetter ? -value : std::max(value, criterion.felt));
  };
  std::vector<double> ranks;
  for (const RendererScore& mine : scores) {
    double before = 0.0, equal = 0.0;
    for (const RendererScore& other : scores) {
      before += key(other) < key(mine);
      equal += key(other) == key(mine);
    }
    ranks.push_back(before + 0.5 * (equal + 1.0));
  }
  return ranks;
}

}  // namespace

double RendererScore::figure(const std::string& trial, const std::string& name) const {
  for (const WallFigure& f : trials)
    if (f.trial == trial && f.figure == name) return f.lost > 0 ? std::numeric_limits<double>::infinity() : f.value;
  return std::numeric_limits<double>::quiet_NaN();
}

const std::vector<ComparisonCriterion>& comparisonCriteria() {
  using Score = RendererScore;
  static const std::vector<ComparisonCriterion> all = {
      {"depth", "µm", [](const Score& s) { return meanOf(s.depth); }, 1e6, 0.0, false},
      {"chatter", "N m", [](const Score& s) { return s.chatter; }, 1.0, 0.05, false},
      {"drag", "%", [](const Score& s) { return s.figure("slide", "tangential force"); }, 1.0, 3.5, false},
      {"pull", "N", [](const Score& s) { return s.figure("release", "pull"); }, 1.0, 0.1, false},
      {"energy given", "mJ", [](const Score& s) { return s.energy; }, 1e3, 1e-3, false},
      {"share of the limit", "%", [](const Score& s) { return s.share; }, 100.0, 0.0, true},
  };
  return all;
}

std::vector<RendererScore> scoresOf(const StudyPlan& plan, const std::vector<StudyResult>& runs) {
  std::vector<RendererScore> scores(plan.columns.size());
  std::vector<std::vector<double>> chatter(scores.size()), energy(scores.size());
  std::vector<int> steps(scores.size());
  for (const StudyResult& run : runs) {
    RendererScore& score = scores[run.run.column];
    ++score.runs;
    const bool first = run.run.scenario == 1;
    steps[run.run.column] += first;
    if (isLost(run)) {
      ++score.lost;
      continue;
    }
    chatter[run.run.column].push_back(run.metrics.chatter);
    if (!first) {
      score.depthOfHand.push_back(run.metrics.largestDepth);
      continue;
    }
    energy[run.run.column].push_back(std::max(0.0, run.metrics.work));
    score.depth.push_back(run.metrics.largestDepth);
    score.share += run.metrics.limitShare.value_or(0.0);
    if (run.metrics.depthStiffness) score.depthStiffness.push_back(*run.metrics.depthStiffness);
    if (run.metrics.firstStiffness) score.stiffness.push_back(*run.metrics.firstStiffness);
  }
  for (std::size_t c = 0; c < scores.size(); ++c) {
    scores[c].share /= std::max(1, steps[c]);
    scores[c].chatter = meanOf(chatter[c]);
    scores[c].energy = meanOf(energy[c]);
  }
  return scores;
}

void addWallTrials(const StudyPlan& plan, const std::vector<std::string>& trials, int threads,
                   std::vector<RendererScore>& scores) {
  const PushSetup& push = plan.setup;
  for (std::size_t c = 0; c < scores.size(); ++c) {
    const StudyColumn& column = plan.columns[c];
    WallTrialSetup setup;
    setup.plant = column.plant;
    setup.model = column.model ? column.model : column.plant;
    setup.renderer = [&column] { return column.make(0); };
    setup.makePlant = column.makePlant;
    setup.wrapper = push.wrapper;
    setup.period = column.period > 0.0 ? column.period : push.period;
    const int ticks = static_cast<int>(std::lround(push.period / setup.period));
    setup.delay = {push.delay.low * ticks, push.delay.high * ticks};
    setup.noise = push.hand.noise;
    setup.runs = plan.runs;
    setup.seed = push.seed;
    for (const std::string& trial : trials)
      for (const WallFigure& figure : runWallTrials(setup, trial, threads)) scores[c].trials.push_back(figure);
  }
}

void rankRenderers(std::vector<RendererScore>& scores) {
  for (RendererScore& score : scores) score.rank = 0.0;
  const std::vector<ComparisonCriterion>& criteria = comparisonCriteria();
  for (const ComparisonCriterion& criterion : criteria) {
    const std::vector<double> ranks = ranksBy(criterion, scores);
    for (std::size_t c = 0; c < scores.size(); ++c) scores[c].rank += ranks[c] / static_cast<double>(criteria.size());
  }
}

std::size_t bestOf(const std::vector<RendererScore>& scores) {
  const auto best = std::min_element(scores.begin(), scores.end(),
                                     [](const RendererScore& a, const RendererScore& b) { return a.rank < b.rank; });
  return static_cast<std::size_t>(best - scores.begin());
}

}  // namespace enamel
