#include "enamel/study/paired.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace enamel {
namespace {

constexpr double kLevel = 0.05;

// The continued fraction of I_x(a, b), for x < (a + 1) / (a + b + 2).
double betaFraction(double x, double a, double b) noexcept {
  constexpr double kTiny = 1e-300;
  constexpr int kMost = 20000;
  const auto safe = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1.0, d = 1.0 / safe(1.0 - (a + b) * x / (a + 1.0)), h = d;
  for (int m = 1; m <= kMost; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                 odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double change = 1.0;
    for (const double term : {even, odd}) {
      d = 1.0 / safe(1.0 + term * d);
      c = safe(1.0 + term / c);
      change *= c * d;
    }
    h *= change;
    if (std::abs(change - 1.0) < 1e-14) break;
  }
  return h;
}

// I_x(a, b). `rest` is 1 - x without cancellation.
double incompleteBeta(double x, double rest, double a, double b) noexcept {
  if (x <= 0.0) return 0.0;
  if (rest <= 0.0) return 1.0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(rest));
  return x < (a + 1.0) / (a + b + 2.0) ? front * betaFraction(x, a, b) / a : 1.0 - front * betaFraction(rest, b, a) / b;
}

}  // namespace

double studentBeyond(double t, double freedom) noexcept {
  const double whole = freedom + t * t;
  return incompleteBeta(freedom / whole, t * t / whole, 0.5 * freedom, 0.5);
}

double studentQuantile(double p, double freedom) noexcept {
  double low = 0.0, high = 1.0;
  while (high < 1e15 && studentBeyond(high, freedom) > p) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (studentBeyond(middle, freedom) > p ? low : high) = middle;
  }
  return high;
}

std::vector<double> holm(const std::vector<double>& p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!std::isnan(p[i])) order.push_back(i);
  std::sort(order.begin(), order.end(), [&p](std::size_t i, std::size_t j) { return p[i] < p[j]; });
  std::vector<double> adjusted(p);
  double largest = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    largest = std::max(largest, static_cast<double>(order.size() - rank) * p[order[rank]]);
    adjusted[order[rank]] = std::min(1.0, largest);
  }
  return adjusted;
}

namespace {

// Fill interval and test of a mean with this standard error.
void judge(double error, double freedom, MeanDifference& d) {
  d.half = studentQuantile(kLevel, freedom) * error;
  d.p = error > 0.0 ? studentBeyond(std::abs(d.mean) / error, freedom) : d.mean == 0.0 ? 1.0 : 0.0;
}

}  // namespace

MeanDifference meanDifference(const Spread& differences) {
  MeanDifference d;
  d.count = differences.count;
  d.mean = differences.mean;
  if (d.count < 2) return d;
  judge(differences.deviation / std::sqrt(d.count), d.count - 1.0, d);
  if (differences.deviation > 0.0) d.effect = d.mean / differences.deviation;
  return d;
}

MeanDifference meanOfStrata(const std::vector<Spread>& strata) {
  MeanDifference d;
  double sum = 0.0, variance = 0.0, squares = 0.0, within = 0.0;  // squares: of the variances, over their freedom
  int used = 0;
  for (const Spread& s : strata) {
    if (s.count < 2) continue;
    const double v = s.deviation * s.deviation, error = v / s.count;
    sum += s.mean;
    variance += error;
    squares += error * error / (s.count - 1);
    within += v;
    d.count += s.count;
    ++used;
  }
  if (used == 0) return d;
  d.mean = sum / used;
  judge(std::sqrt(variance) / used, squares > 0.0 ? variance * variance / squares : d.count - used, d);
  if (within > 0.0) d.effect = d.mean / std::sqrt(within / used);
  return d;
}

namespace {

// Return the results of a scenario and column, point by point.
const StudyResult* runsOf(const StudyPlan& plan, const std::vector<StudyResult>& results, int scenario,
                          std::size_t column) {
  const auto place = static_cast<std::size_t>(std::find(plan.scenarios.begin(), plan.scenarios.end(), scenario) -
                                              plan.scenarios.begin());
  return &results[(place * plan.columns.size() + column) * plan.points() * static_cast<std::size_t>(plan.runs)];
}

// Return the difference of a pair; NaN if the pair does not count.
double differenceOf(const PairedQuestion& question, const StudyResult& a, const StudyResult& b) {
  const Metric& metric = allMetrics()[indexOf(question.metric)];
  const double none = std::numeric_limits<double>::quiet_NaN();
  if (isLost(a) || isLost(b)) return none;
  const auto x = valueOf(a.metrics, metric), y = valueOf(b.metrics, metric);
  if (!x || !y) return none;
  if (!question.isRatio) return *x - *y;
  return *x > 0.0 && *y > 0.0 ? std::log(*x / *y) : none;
}

PairedVerdict verdictOf(const PairedQuestion& question, const MeanDifference& d, double adjusted, int lostA,
                        int lostB) {
  if (!(adjusted < kLevel)) return PairedVerdict::undecided;
  const bool better = (d.mean > 0.0) == question.moreIsBetter;
  if (better ? lostA > lostB : lostB > lostA) return PairedVerdict::undecided;
  return better ? PairedVerdict::better : PairedVerdict::worse;
}

struct LostRuns {
  std::vector<int> a, b;  // at each point
};

PairedComparison compareOnce(const StudyPlan& plan, const std::vector<StudyResult>& results, std::size_t a,
                             std::size_t b, const PairedQuestion& question, LostRuns& lost) {
  PairedComparison c;
  c.question = question;
  c.a = a;
  c.b = b;
  const StudyResult *ofA = runsOf(plan, results, question.scenario, a),
                    *ofB = runsOf(plan, results, question.scenario, b);
  std::vector<Spread> spreads;
  int pairs = 0, larger = 0;
  for (std::size_t point = 0; point < plan.points(); ++point) {
    std::vector<double> differences;
    int lostA = 0, lostB = 0;
    for (int run = 0; run < plan.runs; ++run, ++ofA, ++ofB) {
      lostA += isLost(*ofA);
      lostB += isLost(*ofB);
      if (const double d = differenceOf(question, *ofA, *ofB); !std::isnan(d)) differences.push_back(d);
    }
    pairs += static_cast<int>(differences.size());
    larger += static_cast<int>(std::count_if(differences.begin(), differences.end(), [](double d) { return d > 0.0; }));
    spreads.push_back(spreadOf(differences));
    c.points.push_back(meanDifference(spreads.back()));
    lost.a.push_back(lostA);
    lost.b.push_back(lostB);
  }
  c.wall = meanOfStrata(spreads);
  if (pairs > 0) c.largerShare = static_cast<double>(larger) / pairs;
  c.lostA = std::accumulate(lost.a.begin(), lost.a.end(), 0);
  c.lostB = std::accumulate(lost.b.begin(), lost.b.end(), 0);
  return c;
}

}  // namespace

int PairedComparison::count(PairedVerdict v) const noexcept {
  return static_cast<int>(std::count(verdicts.begin(), verdicts.end(), v));
}

std::vector<PairedComparison> comparePairs(const StudyPlan& plan, const std::vector<StudyResult>& results,
                                           std::size_t a, const std::vector<PairedQuestion>& questions) {
  std::vector<PairedComparison> all;
  for (const PairedQuestion& question : questions) {
    if (std::count(plan.scenarios.begin(), plan.scenarios.end(), question.scenario) == 0) continue;
    const std::size_t first = all.size();
    std::vector<LostRuns> lost;
    std::vector<double> points;
    for (std::size_t b = 0; b < plan.columns.size(); ++b) {
      if (b == a) continue;
      all.push_back(compareOnce(plan, results, a, b, question, lost.emplace_back()));
      for (const MeanDifference& d : all.back().points) points.push_back(d.p);
    }
    const std::vector<double> adjusted = holm(points);
    for (std::size_t i = first; i < all.size(); ++i)
      for (std::size_t p = 0; p < plan.points(); ++p) {
        PairedComparison& c = all[i];
        c.adjusted.push_back(adjusted[(i - first) * plan.points() + p]);
        c.verdicts.push_back(
            verdictOf(question, c.points[p], c.adjusted.back(), lost[i - first].a[p], lost[i - first].b[p]));
      }
  }
  std::vector<PairedComparison*> walls;
  for (PairedComparison& c : all) walls.push_back(&c);
  judgeWalls(walls);
  return all;
}

void judgeWalls(const std::vector<PairedComparison*>& comparisons) {
  std::vector<double> ps;
  for (const PairedComparison* c : comparisons) ps.push_back(c->wall.p);
  const std::vector<double> adjusted = holm(ps);
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    PairedComparison& c = *comparisons[i];
    c.wallAdjusted = adjusted[i];
    c.verdict = verdictOf(c.question, c.wall, adjusted[i], c.lostA, c.lostB);
  }
}

}  // namespace enamel
