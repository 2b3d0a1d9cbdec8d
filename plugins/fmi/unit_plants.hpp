// Plants of a unit's binary in addition to those of sim.
#pragma once

#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

OtherPlants otherPlants();

}  // namespace enamel::fmi
