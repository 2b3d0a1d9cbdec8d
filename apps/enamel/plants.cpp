#include "plants.hpp"

#include "enamel/sim/real_plant.hpp"

namespace enamel::app {

std::vector<std::string> plantNames() { return {kClosedForm, kReal}; }

MakePlant makerOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup) {
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
