#include "imported_unit.hpp"

#include <dlfcn.h>

#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "export.hpp"

namespace enamel::fmi {

/// Dimensions of a unit in kg, m and s; angles are dimensionless.
struct Dimension {
  int kg, m, s;
};

namespace {

constexpr Dimension kNone{0, 0, 0}, kLength{0, 1, 0}, kSpeed{0, 1, -1}, kRate{0, 0, -1}, kForce{1, 1, -2},
    kTorque{1, 2, -2};

}  // namespace

struct ImportedUnit::Wanted {
  std::size_t size;
  const char* causality;
  Dimension dimension;
};

ImportedUnit::ImportedUnit(const std::string& path, const Mechanism& device) : path_(path), archive_(path) {
  readDescription();
  findVariables(static_cast<std::size_t>(device.joints()), !device.home().jacobian.isIdentity(0.0));
  loadBinary();
}

ImportedUnit::~ImportedUnit() {
  if (handle_ != nullptr) dlclose(handle_);
}

void ImportedUnit::refuse(const std::string& reason) const { throw Error(path_ + ": " + reason); }

void ImportedUnit::readDescription() {
  const pugi::xml_parse_result parsed = document_.load_file((archive_.folder() + "/modelDescription.xml").c_str());
  if (!parsed) refuse(std::string("modelDescription.xml: ") + parsed.description());
  const pugi::xml_node root = document_.child("fmiModelDescription");
  const std::string version = root.attribute("fmiVersion").value();
  if (version.rfind("3.", 0) != 0) refuse("has the FMI version \"" + version + "\", must be 3.0");
  const pugi::xml_node simulation = root.child("CoSimulation");
  if (!simulation) refuse("does not support co-simulation");
  identifier_ = simulation.attribute("modelIdentifier").value();
  if (identifier_.empty() || identifier_.find('/') != std::string::npos)
    refuse("its modelIdentifier is \"" + identifier_ + "\", must be a file name without /");
  anyStep = simulation.attribute("canHandleVariableCommunicationStepSize").as_bool();
  onlyOne = simulation.attribute("canBeInstantiatedOnlyOncePerProcess").as_bool();
  if (simulation.attribute("needsExecutionTool").as_bool()) refuse("needs the tool that created it");
  token = root.attribute("instantiationToken").value();
}

void ImportedUnit::findVariables(std::size_t n, bool turns) {
  const Dimension torqueIs = turns ? kTorque : kForce, jointIs = turns ? kNone : kLength,
                  rateIs = turns ? kRate : kSpeed;
  torque = require("torque", {n, "input", torqueIs});
  force = require("force", {3, "input", kForce});
  moment = find("moment", {3, "input", kTorque});
  position = require("position", {3, "output", kLength});
  velocity = require("velocity", {3, "output", kSpeed});
  orientation = find("orientation", {4, "output", kNone});
  angularVelocity = find("angular_velocity", {3, "output", kRate});
  if (n > 3 && orientation.size == 0) refuse("needs an output orientation, because the device turns");
  if (orientation.size > 0 && angularVelocity.size == 0) refuse("has no output angular_velocity");
  q = find("q", {n, "output", jointIs});
  rates = find("rates", {n, "output", rateIs});
  if ((q.size == 0) != (rates.size == 0)) refuse("has one of the outputs q and rates, must have both or neither");
  startPosition = find("start_position", {3, "parameter", kLength});
  startOrientation = find("start_orientation", {4, "parameter", kNone});
}

pugi::xml_node ImportedUnit::variable(const std::string& name) const {
  for (const pugi::xml_node node : document_.child("fmiModelDescription").child("ModelVariables").children())
    if (name == node.attribute("name").value()) return node;
  return {};
}

Reference ImportedUnit::check(const pugi::xml_node& node, const std::string& name, const Wanted& wanted) const {
  if (std::strcmp(node.name(), "Float64") != 0)
    refuse("variable " + name + " is of type " + node.name() + ", must be Float64");
  const std::string is = node.attribute("causality").value();
  if (is != wanted.causality)
    refuse("variable " + name + " has the causality \"" + (is.empty() ? "local" : is) + "\", must be " +
           wanted.causality);
  checkDimension(name, node.attribute("unit").value(), wanted);
  return node.attribute("valueReference").as_uint();
}

void ImportedUnit::checkDimension(const std::string& name, const std::string& unit, const Wanted& wanted) const {
  const Dimension& dimension = wanted.dimension;
  for (const pugi::xml_node u : document_.child("fmiModelDescription").child("UnitDefinitions").children("Unit")) {
    const pugi::xml_node base = u.child("BaseUnit");
    if (unit != u.attribute("name").value() || !base) continue;
    if (base.attribute("factor").as_double(1.0) != 1.0 || base.attribute("offset").as_double(0.0) != 0.0 ||
        base.attribute("kg").as_int() != dimension.kg || base.attribute("m").as_int() != dimension.m ||
        base.attribute("s").as_int() != dimension.s)
      refuse("variable " + name + " is in " + unit + ", must be in SI: kg^" + std::to_string(dimension.kg) + " m^" +
             std::to_string(dimension.m) + " s^" + std::to_string(dimension.s));
  }
}

FoundVariable ImportedUnit::find(const std::string& name, const Wanted& wanted) const {
  FoundVariable found;
  if (const pugi::xml_node node = variable(name)) {
    std::size_t has = 1;
    for (const pugi::xml_node d : node.children("Dimension")) has *= d.attribute("start").as_uint();
    if (has != wanted.size)
      refuse("variable " + name + " has " + std::to_string(has) + " numbers, must have " + std::to_string(wanted.size));
    found.references = {check(node, name, wanted)};
    found.size = wanted.size;
    return found;
  }
  for (std::size_t i = 1; i <= wanted.size; ++i) {
    const std::string element = name + "[" + std::to_string(i) + "]";
    const pugi::xml_node node = variable(element);
    if (!node && i == 1) return found;
    if (!node) refuse("has " + name + "[1], but no " + wanted.causality + " " + element);
    found.references.push_back(check(node, element, wanted));
  }
  found.size = wanted.size;
  return found;
}

FoundVariable ImportedUnit::require(const std::string& name, const Wanted& wanted) const {
  FoundVariable found = find(name, wanted);
  if (found.size == 0)
    refuse(std::string("has no ") + wanted.causality + " " + name + " of " + std::to_string(wanted.size) + " numbers");
  return found;
}

template <typename Function>
void ImportedUnit::symbol(const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(handle_, name));
  if (function == nullptr) refuse(std::string("its binary has no ") + name + "()");
}

void ImportedUnit::loadBinary() {
  const std::string file = "binaries/" + platformTuple() + "/" + identifier_ + ".so",
                    place = archive_.folder() + "/" + file;
  if (!std::filesystem::exists(place)) refuse("has no " + file + ", a binary for this machine");
  handle_ = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) {
    std::string reason = dlerror();
    if (const std::size_t at = reason.find(place + ": "); at != std::string::npos) reason.erase(at, place.size() + 2);
    refuse(file + " cannot be loaded: " + reason);
  }
  GetVersion* version = nullptr;
  symbol("fmi3GetVersion", version);
  if (const std::string is = version(); is.rfind("3.", 0) != 0)
    refuse("its binary has the FMI version \"" + is + "\", must be 3.0");
  symbol("fmi3InstantiateCoSimulation", instantiate);
  symbol("fmi3FreeInstance", free);
  symbol("fmi3EnterInitializationMode", enterInitialization);
  symbol("fmi3ExitInitializationMode", exitInitialization);
  symbol("fmi3Terminate", terminate);
  symbol("fmi3GetFloat64", get);
  symbol("fmi3SetFloat64", set);
  symbol("fmi3DoStep", doStep);
}

}  // namespace enamel::fmi
