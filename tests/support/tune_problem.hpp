// The nominal device as a problem for the tuning tests.
#pragma once

#include <cmath>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/tuning.hpp"
#include "support/devices.hpp"

namespace enamel::test {

inline TuneProblem nominalProblem() {
  const TauModel model = makeModel(nominal());
  const DevicePlant plant = devicePlant(model, Pose{});
  return {outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0)), plant.jacobian, 1e-3,
          2.0 * M_PI / model.encoderCounts, model.maxTorque};
}

}  // namespace enamel::test
