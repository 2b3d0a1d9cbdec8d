// Linear models of plants that are given as functions.
#pragma once

#include <functional>

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Right-hand side f of x' = f(x, u). May return values that are not finite where the plant is not defined.
using PlantFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd& x, const Eigen::VectorXd& u)>;
/// Output h of y = h(x).
using OutputFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

/// Linear model about an operating point (x0, u0): dx' = A dx + B du, dy = C dx.
struct Linearisation {
  StateSpace model;        ///< A = df/dx, B = df/du
  Eigen::MatrixXd C;       ///< dh/dx
  Eigen::VectorXd offset;  ///< f(x0, u0): zero at an equilibrium
  double error = 0.0;      ///< estimated error of A, B and C, each relative to its largest entry
};

/// Linearises x' = f(x, u), y = h(x) at (x0, u0) by central differences extrapolated to a vanishing step.
///
/// For each variable the step is halved from 1/16 of max(|x_i|, 1) and the differences are extrapolated in even
/// powers of it (Richardson 1911; Ridders 1982); every entry of the Jacobian keeps the extrapolation with its own
/// smallest error estimate, which is never below rounding. Steps at which f is not finite are skipped. A plant that
/// bends over a length s of a variable is linearised to about 1e-15 max(|x_i|, 1) / s; f must be accurate to rounding,
/// noise of its own may pass for slope. The error estimate is good to a factor of 10.
/// Throws DesignError: wrong sizes; f or h not finite at the operating point or at every step near it. Realtime: no.
Linearisation linearise(const PlantFunction& f, const OutputFunction& h, const Eigen::VectorXd& x0,
                        const Eigen::VectorXd& u0);

/// Takes the outputs as the states ("A Position-Control Based Approach ...", eq. 5): y' = C A C^-1 y + C B u.
/// Throws DesignError: C not square, or singular (condition after equilibration above 1e12). Realtime: no.
StateSpace outputsAsStates(const Linearisation& linearisation);

}  // namespace enamel
