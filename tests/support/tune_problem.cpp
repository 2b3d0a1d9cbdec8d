#include "support/tune_problem.hpp"

namespace enamel::test {

TuneProblem nominalProblem() {
  const auto mechanism = std::make_shared<TauMechanism>(nominal());
  const DevicePlant plant = devicePlant(mechanism, Pose{});
  return {outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0)), plant.jacobian, 1e-3,
          mechanism->limits().encoderStep, mechanism->limits().effort};
}

}  // namespace enamel::test
