// Compiled once for each binary: only one of them is linked with Simbody.
#include "unit_plants.hpp"

#ifdef ENAMEL_SIMBODY
#include "enamel/multibody/multibody_plant.hpp"
#endif

namespace enamel::fmi {

OtherPlants otherPlants() {
  OtherPlants others;
#ifdef ENAMEL_SIMBODY
  others.multibody = multibodyPlants;
#endif
  return others;
}

}  // namespace enamel::fmi
