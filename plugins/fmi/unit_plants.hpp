// The plants that a unit's binary has beside those of sim.
#pragma once

#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

OtherPlants otherPlants();

}  // namespace enamel::fmi
