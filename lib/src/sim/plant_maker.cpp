#include "enamel/sim/plant_maker.hpp"

#include <string_view>
#include <utility>

#include "enamel/core/error.hpp"
#include "enamel/sim/imperfect_plant.hpp"

namespace enamel {
namespace {

// No value is negative, so the sum is zero only if all are zero.
bool isPerfect(const Imperfections& i) noexcept {
  return i.currentBandwidth + i.torqueStep + i.torqueRipple + i.cogging + i.coulombFriction + i.cableStiffness +
             i.encoderOffset + i.lengthError + i.massError + i.jitter + i.lostSamples ==
         0.0;
}

void requireName(const std::string& plant) {
  if (const std::string problem = checkPlant(plant); !problem.empty()) throw Error(problem);
}

}  // namespace

bool isUnit(const std::string& plant) noexcept {
  return plant.size() > 4 && std::string_view(plant).substr(plant.size() - 4) == ".fmu";
}

std::vector<std::string> plantNames() { return {kClosedForm, kMultibody, kImperfect, kImperfectStiff}; }

std::string checkPlant(const std::string& plant) {
  if (isUnit(plant)) return "";
  std::string names;
  for (const std::string& name : plantNames()) {
    if (plant == name) return "";
    names += name + ", ";
  }
  return "unknown plant \"" + plant + "\": must be " + names + "or FILE.fmu";
}

const char* plantOf(const DeviceParameters& device) noexcept {
  return isPerfect(imperfectionsOf(device)) ? kClosedForm : kImperfect;
}

const char* drivesOf(const std::string& plant) {
  requireName(plant);
  return plant == kImperfect ? "device" : plant == kImperfectStiff ? "rigid" : "ideal";
}

DeviceParameters modelFor(const std::string& plant, DeviceParameters device) {
  requireName(plant);
  if (plant == kImperfectStiff) stiffenCables(device);
  return plant == kImperfect || plant == kImperfectStiff ? device : idealOf(std::move(device));
}

MakePlant plantMaker(const std::string& plant, const DeviceParameters& parameters, const OtherPlants& others,
                     VirtualDeviceSetup& setup) {
  requireName(plant);
  if (plant == kMultibody) {
    if (others.multibody) return others.multibody(parameters);
    throw Error("--plant multibody: this enamel was built without Simbody (Debian: libsimbody-dev)");
  }
  if (isUnit(plant)) {
    if (others.unit) return others.unit(plant, parameters);
    throw Error("--plant " + plant + ": this enamel was built without FMI (Debian: libzip-dev, libpugixml-dev)");
  }
  if (plant == kClosedForm) return {};
  DeviceParameters imperfect = parameters;
  if (plant == kImperfectStiff) stiffenCables(imperfect);
  const Imperfections& imperfections = imperfectionsOf(imperfect);
  (void)makeImperfectDevice(imperfect, setup.seed);  // throws if the device cannot be made
  if (isPerfect(imperfectionsOf(parameters)))
    throw Error(nameOf(parameters) + " has no [imperfections], which the plant " + plant +
                " requires; use the plant closed-form");
  setup.jitter = imperfections.jitter;
  setup.lostSamples = imperfections.lostSamples;
  return [imperfect, seed = setup.seed](std::uint32_t stream) {
    return std::make_unique<ImperfectPlant>(makeImperfectDevice(imperfect, seed, stream));
  };
}

}  // namespace enamel
