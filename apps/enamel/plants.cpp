#include "plants.hpp"

#include "enamel/core/error.hpp"
#ifdef ENAMEL_SIMBODY
#include "enamel/multibody/multibody_plant.hpp"
#endif
#include "enamel/sim/real_plant.hpp"

namespace enamel::app {

std::vector<std::string> plantNames() { return {kClosedForm, kMultibody, kReal}; }

MakePlant makerOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup) {
  if (plant == kMultibody) {
#ifdef ENAMEL_SIMBODY
    return [parameters](std::uint32_t) { return std::make_unique<MultibodyPlant>(parameters); };
#else
    throw Error("--plant multibody: this enamel was built without Simbody (Debian: libsimbody-dev)");
#endif
  }
  if (plant != kReal) return {};
  (void)makeRealDevice(parameters, setup.seed);  // refuses what it cannot be made of
  const Imperfections& imperfections = imperfectionsOf(parameters);
  setup.jitter = imperfections.jitter;
  setup.lostSamples = imperfections.lostSamples;
  return [parameters, seed = setup.seed](std::uint32_t stream) {
    return std::make_unique<RealPlant>(makeRealDevice(parameters, seed, stream));
  };
}

}  // namespace enamel::app
