// Renderers compared: how each does in a study and in wall trials, and their ranks.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/wall_trials.hpp"

namespace enamel {

/// How one renderer did. Figures of a study are of scenario 1 unless they say otherwise, and of the runs that were not
/// lost.
struct RendererScore {
  int runs = 0, lost = 0;                ///< of all scenarios; lost: left the workspace, stopped by the guard, unstable
  std::vector<double> stiffness, depth;  ///< K_z1 of the runs that have one, N/m; largest penetration of each run, m
  std::vector<double> depthOfHand;       ///< the same of scenario 2
  std::vector<double> depthStiffness;    ///< K_d of the runs of scenario 1, N/m
  double share = 0.0;                    ///< of the limit, mean; a run without K_z1 counts as 0
  double chatter = std::numeric_limits<double>::quiet_NaN();  ///< mean over all scenarios, N m or N
  double energy = std::numeric_limits<double>::quiet_NaN();   ///< given to the tool, mean, J
  std::vector<WallFigure> trials;
  double rank = std::numeric_limits<double>::quiet_NaN();  ///< mean over comparisonCriteria()

  /// A figure of a wall trial, in its unit; infinite where a run was lost, NaN where the trial was not performed.
  double figure(const std::string& trial, const std::string& name) const;
};

/// What renderers are ranked by.
struct ComparisonCriterion {
  const char *name, *unit;
  double (*value)(const RendererScore&);
  double scale;  ///< of `value` to the unit
  /// What a hand does not feel (in SI or %) counts as this: the chatter that designs allow, half of the smallest
  /// difference of force that is noticed (7 %: Pang, Tan and Durlach 1991), and what we take for pull and energy.
  double felt;
  bool moreIsBetter;
};

/// Depth, chatter, drag (tangential over normal force of the trial slide), pull (of release), energy and share of the
/// limit.
const std::vector<ComparisonCriterion>& comparisonCriteria();

/// Score the runs of a study, column by column. `runs` may be empty. Realtime: no.
std::vector<RendererScore> scoresOf(const StudyPlan& plan, const std::vector<StudyResult>& runs);

/// Perform wall trials, by their names, with every renderer of a plan, on its plants, with its delay, runs, noise and
/// seed. Results do not depend on `threads`. Throws Error: as runWallTrials(). Realtime: no.
void addWallTrials(const StudyPlan& plan, const std::vector<std::string>& trials, int threads,
                   std::vector<RendererScore>& scores);

/// Rank from 1 for each criterion; equal ones share theirs. A renderer that lost runs ranks behind all that lost fewer.
/// Realtime: no.
void rankRenderers(std::vector<RendererScore>& scores);

/// Index of the best mean rank, the first of equal ones. Realtime: no.
std::size_t bestOf(const std::vector<RendererScore>& scores);

}  // namespace enamel
