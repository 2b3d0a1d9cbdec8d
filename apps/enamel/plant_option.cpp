#include "plant_option.hpp"

#ifdef ENAMEL_SIMBODY
#include "enamel/multibody/multibody_plant.hpp"
#endif
#ifdef ENAMEL_FMI
#include "plugins/fmi/import.hpp"
#endif

namespace enamel::app {

MakePlant makerOf(const std::string& plant, const DeviceParameters& device, VirtualDeviceSetup& setup) {
  OtherPlants others;
#ifdef ENAMEL_SIMBODY
  others.multibody = multibodyPlants;
#endif
#ifdef ENAMEL_FMI
  others.unit = fmi::plantsOf;
#endif
  return plantMaker(plant, device, others, setup);
}

}  // namespace enamel::app
