#include "setup.hpp"

#include "enamel/core/error.hpp"
#include "enamel/core/old_names.hpp"
#include "enamel/study/parallel.hpp"
#ifdef ENAMEL_SIMBODY
#include "enamel/multibody/multibody_plant.hpp"
#endif

namespace enamel::python {
namespace {

RateSource ratesOf(const std::string& rates, bool encoders) {
  if (rates.empty()) return encoders ? RateSource::difference : RateSource::exact;
  if (rates == "exact") return RateSource::exact;
  if (rates == "difference") return RateSource::difference;
  if (rates == "low-pass") return RateSource::lowPass;
  throw Error("rates is \"" + rates + "\", must be exact, difference or low-pass");
}

}  // namespace

EncoderOptions encodersOf(bool encoders, const std::string& rates, double lowPass) {
  return {encoders, ratesOf(rates, encoders), lowPass};
}

std::string plantName(const std::string& plant) {
  if (const std::string warning = oldNameWarning("plant", plant, "plant"); !warning.empty()) warnDeprecated(warning);
  return std::string(presentName("plant", plant));
}

MakePlant plantOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup) {
  OtherPlants others;
#ifdef ENAMEL_SIMBODY
  others.multibody = multibodyPlants;
#endif
  return plantMaker(plantName(plant), parameters, others, setup);
}

int threadsOf(int threads) { return threads > 0 ? threads : availableThreads(); }

}  // namespace enamel::python
