#include "design_results.hpp"

namespace enamel::app {

std::vector<Requirement> requirementsOf(const ServoDesign& design, const DevicePlant& plant) {
  return measureRequirements(design, linearPlant(design, plant.jacobian), plant.jacobian);
}

WallDevice wallDeviceOf(const DevicePlant& plant, double damping, double period) {
  return {plant.effectiveMass, damping, period};
}

}  // namespace enamel::app
