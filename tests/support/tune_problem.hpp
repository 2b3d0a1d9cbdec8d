// The nominal device as a problem for the tuning tests.
#pragma once

#include "enamel/control/device_plant.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "support/devices.hpp"

namespace enamel::test {

inline TuneProblem nominalProblem() {
  const auto mechanism = std::make_shared<TauMechanism>(nominal());
  const DevicePlant plant = devicePlant(mechanism, Pose{});
  return {outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0)), plant.jacobian, 1e-3,
          mechanism->limits().count, mechanism->limits().torque};
}

}  // namespace enamel::test
