// Linearisation of plants that are given as functions.
#pragma once

#include <functional>

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Right-hand side f of x' = f(x, u). It may return values that are not finite where the plant is undefined.
using PlantFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd& x, const Eigen::VectorXd& u)>;
/// Output h of y = h(x).
using OutputFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

/// Linear model about an operating point (x0, u0): dx' = A dx + B du, dy = C dx.
struct Linearisation {
  StateSpace model;        ///< A = df/dx, B = df/du
  Eigen::MatrixXd C;       ///< dh/dx
  Eigen::VectorXd offset;  ///< f(x0, u0), zero at an equilibrium
  double error = 0.0;      ///< largest estimated error of A, B and C, each relative to its largest entry
};

/// Linearise x' = f(x, u), y = h(x) at (x0, u0) with central differences, extrapolated to a step of zero.
///
/// For each variable the step starts at 1/16 of max(|x_i|, 1) and is halved. The differences are extrapolated in even
/// powers of the step (Richardson 1911; Ridders 1982). Each entry of the Jacobian keeps the extrapolation with its own
/// smallest error estimate. The estimate is never below rounding, and is good to a factor of 10. Steps at which f is
/// not finite are skipped.
///
/// The error is about 1e-15 max(|x_i|, 1) / s for a plant with curvature over a length s of variable i. f must be
/// accurate to rounding, because its noise would appear as slope.
///
/// Throws DesignError: wrong sizes; f or h is not finite at the operating point or at every step near it. Realtime: no.
Linearisation linearise(const PlantFunction& f, const OutputFunction& h, const Eigen::VectorXd& x0,
                        const Eigen::VectorXd& u0);

/// Transform a model so that its outputs are its states ("A Position-Control Based Approach ...", eq. 5):
/// y' = C A C^-1 y + C B u. Throws DesignError: C is not square, or singular (condition after equilibration above
/// 1e12). Realtime: no.
StateSpace outputsAsStates(const Linearisation& linearisation);

}  // namespace enamel
