// Speed against error of the integration between ticks.
#pragma once

#include "study/study.hpp"

namespace enamel::app {

struct IntegrationMethod {
  Integrator integrator;
  int substeps;
};
std::string nameOf(Integrator integrator);

/// How a method compares with the reference over a set of runs: every renderer and scenario of the study, at the middle
/// and at two opposite corners of the wall, with noise.
struct MethodError {
  IntegrationMethod method;
  double trajectory = 0.0;        ///< largest distance of the TCP from the reference's at a tick, m
  std::vector<double> metrics;    ///< largest error of each metric, relative to the largest value of that metric
                                  ///< in the reference runs of the same renderer and scenario
  double worst = 0.0;             ///< largest of `metrics`; infinite where a run lacks what the reference has
  double secondsPerSecond = 0.0;  ///< processor time a simulated second, whole loop
};

struct Convergence {
  IntegrationMethod reference{Integrator::rungeKutta4, 16};
  double referenceError = 0.0;  ///< worst metric of half as many substeps against the reference
  double allowed = 1e-3;        ///< error of every metric
  std::vector<std::string> metrics;
  std::vector<MethodError> methods;
  std::size_t cheapest = 0;  ///< of those whose errors are allowed; methods.size() where there is none
};

Convergence measureConvergence(const Study& study);
std::string convergenceTable(const Convergence& convergence);

}  // namespace enamel::app
