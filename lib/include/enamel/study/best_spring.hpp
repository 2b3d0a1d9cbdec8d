// Search of the spring that competes with position control.
#pragma once

#include <cstddef>

#include "enamel/render/impedance.hpp"
#include "enamel/study/monte_carlo.hpp"

namespace enamel {

struct BestSpring {
  ImpedanceOptions spring;
  double stiffness = 0.0;  ///< mean K_d of the pushes of the search, N/m; 0: no spring loses no run
};

/// Find the spring with the largest mean K_d among those that lose no run. Each spring performs the runs of a plan on
/// the plant of a column, with other random numbers than those of the plan. The search begins with the stiffest spring
/// at each of seven dampings, from m / (32 T) to 2 m / T. Here m is the effective mass and T the period. It then moves
/// to better neighbours, down to steps of 2^(1/8). The result does not depend on `threads`. Throws Error as
/// performRun(). Realtime: no.
BestSpring findBestSpring(const StudyPlan& plan, std::size_t column, int threads);

}  // namespace enamel
