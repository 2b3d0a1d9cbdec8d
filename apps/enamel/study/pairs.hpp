// Paired comparisons in words and tables, for the reports of studies and comparisons.
#pragma once

#include "enamel/study/paired.hpp"
#include "study/page.hpp"
#include "study/study.hpp"

namespace enamel::app {

/// Return the questions of reports. The first of each scenario is the stiffness: K_d, and the rms depth under a hand.
const std::vector<PairedQuestion>& reportQuestions();
inline bool isStiffness(const PairedQuestion& question) {
  return question.metric == MetricMember(&PushMetrics::depthStiffness) ||
         question.metric == MetricMember(&PushMetrics::rmsDepth);
}

/// Return the column that is compared with all others: position control, or the first one.
std::size_t referenceOf(const Study& study);

/// Format how many times a is as much as b, with its 95 % interval: "3.20 (3.11 to 3.29)". `inverse`: b over a.
std::string timesText(const MeanDifference& ratio, bool inverse = false);

/// Return "better", "worse" or "not decided"; the next function formats a p value, as HTML.
std::string verdictText(PairedVerdict verdict);
std::string pText(double p);

/// Return which of two renderers is stiffer, by how much and where not, as a sentence; HTML.
std::string stiffnessSentence(const Study& study, const PairedComparison& c);

/// Add a table of all comparisons of a study, each with its interval, test, effect sizes and verdict.
void addPairs(Page& page, const Study& study, const std::vector<PairedComparison>& pairs, const std::string& caption);

/// Return the assumptions of a study, for people who know none of its terms; HTML.
std::string assumptionsOf(const Study& study);

}  // namespace enamel::app
