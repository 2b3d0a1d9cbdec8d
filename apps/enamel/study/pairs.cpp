#include "study/pairs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"

namespace enamel::app {
namespace {

const Metric& metricOf(const PairedComparison& c) { return allMetrics()[indexOf(c.question.metric)]; }

std::string titleOf(const Study& study, std::size_t column) { return escape(study.labels[column].title); }

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string amountText(const PairedComparison& c) {
  if (c.question.isRatio) return timesText(c.wall);
  const double scale = metricOf(c).displayScale;
  const std::string text = meanText(scale * c.wall.mean, scale * c.wall.half);
  return text + (text == "–" ? "" : std::string(" ") + metricOf(c).displayUnit);
}

// Return the first points with a verdict: "(-25, 0), (25, 5) mm and 3 more".
std::string placesOf(const Study& study, const PairedComparison& c, PairedVerdict verdict) {
  constexpr int kNamed = 3;
  std::string text;
  int named = 0;
  for (std::size_t p = 0; p < c.verdicts.size() && named < kNamed; ++p)
    if (c.verdicts[p] == verdict) text += (named++ > 0 ? ", " : "") + pointText(study, p);
  const int more = c.count(verdict) - named;
  return text + " mm" + (more > 0 ? fmt::format(" and {} more", more) : "");
}

}  // namespace

const std::vector<PairedQuestion>& reportQuestions() {
  using M = PushMetrics;
  static const std::vector<PairedQuestion> questions = {
      {1, &M::depthStiffness, true, true}, {2, &M::rmsDepth, true, false},        {1, &M::firstStiffness, true, true},
      {1, &M::largestDepth, true, false},  {1, &M::chatter, false, false},        {2, &M::chatter, false, false},
      {1, &M::bounce, false, false},       {1, &M::tangentialForce, false, false}};
  return questions;
}

std::size_t referenceOf(const Study& study) {
  const std::size_t ours = study.column(ColumnKind::positionControl);
  return ours < study.labels.size() ? ours : 0;
}

std::string timesText(const MeanDifference& ratio, bool inverse) {
  const double sign = inverse ? -1.0 : 1.0;
  const auto text = [&](double shift) { return numberText(std::exp(sign * ratio.mean + shift)); };
  if (!std::isfinite(ratio.mean)) return "–";
  return std::isfinite(ratio.half) ? fmt::format("{} ({} to {})", text(0.0), text(-ratio.half), text(ratio.half))
                                   : text(0.0);
}

std::string verdictText(PairedVerdict verdict) {
  return verdict == PairedVerdict::better ? "better" : verdict == PairedVerdict::worse ? "worse" : "not decided";
}

std::string pText(double p) { return std::isnan(p) ? "–" : p < 1e-4 ? "&lt;\u00a00.0001" : fmt::format("{:.4f}", p); }

std::string stiffnessSentence(const Study& study, const PairedComparison& c) {
  const std::string a = titleOf(study, c.a), b = titleOf(study, c.b),
                    when = c.question.scenario == 1 ? "a sudden push" : "a hand that presses";
  std::string lost;
  for (const auto& [count, name] : {std::pair(c.lostA, &a), std::pair(c.lostB, &b)})
    if (count > 0) lost += fmt::format(" {} loses {} runs.", capitalised(*name), count);
  if (!std::isfinite(c.wall.half))
    return fmt::format("Under {}, too few pairs of runs of {} and {} can be compared.{}", when, a, b, lost);
  // A larger rms depth is less stiffness.
  const bool less = !c.question.moreIsBetter, isAStiffer = (c.wall.mean > 0.0) != less;
  const std::string ratio = timesText(c.wall, isAStiffer == less);
  if (c.verdict == PairedVerdict::undecided)
    return fmt::format("Under {}, it is <b>not decided</b> whether {} or {} is stiffer: {} is {} times as stiff.{}",
                       when, a, b, isAStiffer ? a : b, ratio, lost);
  const PairedVerdict same = c.verdict,
                      opposite = same == PairedVerdict::better ? PairedVerdict::worse : PairedVerdict::better;
  std::string text = fmt::format("Under {}, {} is <b>{} times as stiff</b> as {}, ", when, isAStiffer ? a : b, ratio,
                                 isAStiffer ? b : a);
  const int points = static_cast<int>(c.points.size()), found = c.count(same), against = c.count(opposite),
            open = c.count(PairedVerdict::undecided);
  text += points == 1       ? "at one query point"
          : found == points ? fmt::format("and stiffer at all {} query points", points)
                            : fmt::format("and stiffer at {} of {} query points", found, points);
  if (against > 0) text += "; less stiff at " + placesOf(study, c, opposite);
  if (open > 0 && points > 1) text += "; not decided at " + placesOf(study, c, PairedVerdict::undecided);
  return text + "." + lost;
}

void addPairs(Page& page, const Study& study, const std::vector<PairedComparison>& pairs, const std::string& caption) {
  std::vector<std::vector<std::string>> rows;
  for (const PairedComparison& c : pairs) {
    const Metric& metric = metricOf(c);
    const std::string amount = amountText(c);
    std::vector<std::string> row{fmt::format("{}, scenario {} <small>{}</small>", metric.symbol, c.question.scenario,
                                             c.question.moreIsBetter ? "more is better" : "less is better"),
                                 titleOf(study, c.b), amount + (c.question.isRatio && amount != "–" ? " times" : "")};
    if (amount.rfind("0 ", 0) == 0 || amount == "–")  // rounding errors, or nothing to compare
      row.insert(row.end(), {"–", "–", "–", "–", amount == "–" ? "not decided" : "no difference"});
    else
      row.insert(row.end(),
                 {pText(c.wallAdjusted), numberText(c.wall.effect, 2), numberText(100.0 * c.largerShare) + " %",
                  fmt::format("{} / {} / {}", c.count(PairedVerdict::better), c.count(PairedVerdict::worse),
                              c.count(PairedVerdict::undecided)),
                  verdictText(c.verdict)});
    rows.push_back(row);
  }
  page.table({titleOf(study, pairs.front().a), "against", "ratio or difference, 95 %", "p, Holm", "d_z", "larger in",
              "points: better / worse / not decided", "verdict"},
             rows, caption);
}

std::string assumptionsOf(const Study& study) {
  const StudyOptions& options = study.options;
  const PushSetup& setup = study.plan.setup;
  std::string damping;
  for (const ColumnLabel& label : study.labels)
    if (label.damping > 0.0)
      damping += fmt::format("{}{} N s/m of damping for {}", damping.empty() ? "; the device has " : ", ",
                             givenText(label.damping), escape(label.title));
  return fmt::format(
      "All results are from simulation of {}; no hardware was involved. There is {} of the commands. Joint angles are "
      "{}. The "
      "person pushes with {} to {} N and noise of {} N{}.",
      plantTitle(options.plant),
      parseDelay(options.delay).high > 0 ? "a delay of " + delayText(options.delay) : "no delay",
      setup.encoders.quantised ? "rounded to the steps of the encoders" : "known exactly",
      givenText(study.plan.lowestForce), givenText(study.plan.highestForce), givenText(setup.hand.noise), damping);
}

}  // namespace enamel::app
