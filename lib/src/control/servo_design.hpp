// The parts of designServo(): a search over weights samples its plant once.
#pragma once

#include "enamel/control/servo_design.hpp"

namespace enamel {

/// Return the models of a design, without weights and gain. Throws DesignError: as augmentWithIntegrals, zeroOrderHold.
ServoDesign servoModels(const StateSpace& plant, double period);

/// Return the design of these models with the weights. Throws DesignError: as designServo for weights, solveRiccati.
ServoDesign designServo(const ServoDesign& models, const ServoWeights& weights);

}  // namespace enamel
