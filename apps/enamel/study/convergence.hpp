// Speed and error of the integration between ticks.
#pragma once

#include "study/study.hpp"

namespace enamel::app {

struct IntegrationMethod {
  Integrator integrator;
  int substeps;
};
std::string nameOf(Integrator integrator);

/// A method compared with the reference over a set of runs with noise. The runs cover every renderer and scenario of
/// the study, at the middle and at two opposite corners of the wall.
struct MethodError {
  IntegrationMethod method;
  double trajectory = 0.0;        ///< largest distance between the TCP and the reference TCP at a tick, m
  std::vector<double> metrics;    ///< largest error of each metric, relative to the largest value of that metric
                                  ///< in the reference runs of the same renderer and scenario
  double worst = 0.0;             ///< largest of `metrics`; infinite if only one of run and reference has a metric
  double secondsPerSecond = 0.0;  ///< processor time for a simulated second of the whole loop
};

struct Convergence {
  IntegrationMethod reference{Integrator::rungeKutta4, 16};
  double referenceError = 0.0;  ///< worst metric error of half as many substeps, compared with the reference
  double allowed = 1e-3;        ///< largest allowed error of every metric
  std::vector<std::string> metrics;
  std::vector<MethodError> methods;
  std::size_t cheapest = 0;  ///< cheapest method with allowed errors; methods.size() if all errors are too large
};

Convergence measureConvergence(const Study& study);
std::string convergenceTable(const Convergence& convergence);

}  // namespace enamel::app
