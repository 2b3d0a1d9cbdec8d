// Comparison of renderers: their results in a study and in wall trials, and their ranks.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/wall_trials.hpp"

namespace enamel {

/// Results of one renderer. Figures of a study belong to scenario 1, unless stated otherwise, and exclude lost runs.
struct RendererScore {
  /// Runs of all scenarios. Lost: left the workspace, stopped by the guard, or unstable.
  int runs = 0, lost = 0;
  /// K_z1 of each run that has one, N/m; largest penetration of each run, m.
  std::vector<double> stiffness, depth;
  std::vector<double> depthOfHand;     ///< the same as `depth` for scenario 2
  std::vector<double> depthStiffness;  ///< K_d of the runs of scenario 1, N/m
  double share = 0.0;                  ///< mean share of the limit; a run without K_z1 counts as 0
  double chatter = std::numeric_limits<double>::quiet_NaN();  ///< mean over all scenarios, N m or N
  double energy = std::numeric_limits<double>::quiet_NaN();   ///< energy given to the tool, mean, J
  std::vector<WallFigure> trials;
  double rank = std::numeric_limits<double>::quiet_NaN();  ///< mean over comparisonCriteria()

  /// Return a figure of a wall trial, in its unit. It is infinite if a run was lost, and NaN if the trial was not
  /// performed. Realtime: no.
  double figure(const std::string& trial, const std::string& name) const;
};

/// A criterion for ranking renderers.
struct ComparisonCriterion {
  const char *name, *unit;
  double (*value)(const RendererScore&);
  double scale;  ///< factor from `value` to the unit
  /// Threshold that a hand feels (in SI or %); smaller values count as this value. Chatter: the value that designs
  /// allow. Drag: half of the smallest noticeable difference of force (7 %: Pang, Tan and Durlach 1991). Pull and
  /// energy: our assumption.
  double felt;
  bool moreIsBetter;
};

/// List the criteria: depth, chatter, drag (tangential over normal force of the trial slide), pull (of release), energy
/// and share of the limit.
const std::vector<ComparisonCriterion>& comparisonCriteria();

/// Score the runs of a study, column by column. `runs` may be empty. Realtime: no.
std::vector<RendererScore> scoresOf(const StudyPlan& plan, const std::vector<StudyResult>& runs);

/// Perform wall trials, by their names, with each renderer of a plan. They use its plants, delay, runs, noise and seed.
/// Results do not depend on `threads`. Throws Error as runWallTrials(). Realtime: no.
void addWallTrials(const StudyPlan& plan, const std::vector<std::string>& trials, int threads,
                   std::vector<RendererScore>& scores);

/// Rank renderers from 1 for each criterion. Equal ones share a rank. A renderer that lost runs ranks after all that
/// lost fewer. Realtime: no.
void rankRenderers(std::vector<RendererScore>& scores);

/// Return the index of the best mean rank; the first of equal ones. Realtime: no.
std::size_t bestOf(const std::vector<RendererScore>& scores);

}  // namespace enamel
