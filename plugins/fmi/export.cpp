#include "export.hpp"

#include <fmt/core.h>
#include <sys/utsname.h>

#include <pugixml.hpp>
#include <sstream>

#include "archive.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel::fmi {
namespace {

constexpr std::size_t kLargestMesh = std::size_t{2} << 30;  // bytes

struct Unit {
  const char* name;
  int kg, m, s, rad;  // exponents
};
constexpr Unit kUnits[] = {{"s", 0, 0, 1, 0},      {"m", 0, 1, 0, 0},  {"m/s", 0, 1, -1, 0}, {"rad", 0, 0, 0, 1},
                           {"rad/s", 0, 0, -1, 1}, {"N", 1, 1, -2, 0}, {"N.m", 1, 2, -2, 0}};

const char* nameOf(Causality causality) {
  switch (causality) {
    case Causality::independent: return "independent";
    case Causality::parameter: return "parameter";
    case Causality::input: return "input";
    case Causality::output: break;
  }
  return "output";
}

std::string numbers(const Variable& variable) {
  std::string text;
  for (const double number : variable.start) {
    if (!text.empty()) text += ' ';
    text += variable.type == Type::boolean ? (number != 0.0 ? "true" : "false") : fmt::format("{}", number);
  }
  return text;
}

void addUnits(pugi::xml_node& root) {
  pugi::xml_node units = root.append_child("UnitDefinitions");
  for (const Unit& unit : kUnits) {
    pugi::xml_node node = units.append_child("Unit");
    node.append_attribute("name") = unit.name;
    pugi::xml_node base = node.append_child("BaseUnit");
    for (const auto& [name, exponent] : {std::pair{"kg", unit.kg}, {"m", unit.m}, {"s", unit.s}, {"rad", unit.rad}})
      if (exponent != 0) base.append_attribute(name) = exponent;
  }
}

void addVariable(pugi::xml_node& variables, const Variable& v, std::size_t reference) {
  constexpr const char* kTypes[] = {"Float64", "Int32", "Boolean"};
  pugi::xml_node node = variables.append_child(kTypes[static_cast<int>(v.type)]);
  node.append_attribute("name") = v.name;
  node.append_attribute("valueReference") = static_cast<unsigned>(reference);
  node.append_attribute("description") = v.description;
  node.append_attribute("causality") = nameOf(v.causality);
  node.append_attribute("variability") = v.causality == Causality::parameter ? "fixed"
                                         : v.type == Type::real              ? "continuous"
                                                                             : "discrete";
  if (v.causality == Causality::parameter) node.append_attribute("initial") = "exact";
  if (v.causality == Causality::output) node.append_attribute("initial") = "calculated";
  if (v.type == Type::real && *v.unit != 0) node.append_attribute("unit") = v.unit;
  if (v.causality == Causality::parameter || v.causality == Causality::input)
    node.append_attribute("start") = numbers(v).c_str();
  if (v.isArray) node.append_child("Dimension").append_attribute("start") = static_cast<unsigned>(v.start.size());
}

}  // namespace

std::string platformTuple() {
  struct utsname machine = {};
  if (uname(&machine) != 0) return "x86_64-linux";
  return std::string(machine.machine) + "-linux";
}

std::string modelDescription(const UnitConfiguration& unit, const Mechanism& device, const std::string& token) {
  const std::vector<Variable> table = variablesOf(unit, device);
  const bool isPlant = unit.renderer.empty();
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("fmiModelDescription");
  root.append_attribute("fmiVersion") = "3.0";
  root.append_attribute("modelName") =
      (device.name() + (isPlant ? ", " + unit.plant : " under " + unit.renderer)).c_str();
  root.append_attribute("instantiationToken") = token.c_str();
  root.append_attribute("description") =
      isPlant ? "A haptic device in motion" : "One haptic tick: contacts, renderer, guard";
  root.append_attribute("generationTool") = "enamel fmu";
  root.append_attribute("license") = "BSD-3-Clause";

  pugi::xml_node simulation = root.append_child("CoSimulation");
  simulation.append_attribute("modelIdentifier") = kIdentifier;
  simulation.append_attribute("canGetAndSetFMUState") = true;
  simulation.append_attribute("canSerializeFMUState") = canSerialise(unit);
  simulation.append_attribute("canHandleVariableCommunicationStepSize") = isPlant;
  if (!isPlant) simulation.append_attribute("fixedInternalStepSize") = unit.period;

  addUnits(root);
  pugi::xml_node experiment = root.append_child("DefaultExperiment");
  experiment.append_attribute("startTime") = 0.0;
  experiment.append_attribute("stepSize") = unit.period;

  pugi::xml_node variables = root.append_child("ModelVariables");
  std::string inputs, parameters;
  for (std::size_t i = 0; i < table.size(); ++i) {
    addVariable(variables, table[i], i);
    std::string* list = table[i].causality == Causality::input       ? &inputs
                        : table[i].causality == Causality::parameter ? &parameters
                                                                     : nullptr;
    if (list != nullptr) *list += (list->empty() ? "" : " ") + std::to_string(i);
  }
  pugi::xml_node structure = root.append_child("ModelStructure");
  for (const bool initial : {false, true})
    for (std::size_t i = 0; i < table.size(); ++i) {
      if (table[i].causality != Causality::output) continue;
      pugi::xml_node node = structure.append_child(initial ? "InitialUnknown" : "Output");
      node.append_attribute("valueReference") = static_cast<unsigned>(i);
      // A tick's outputs depend directly on its inputs; a plant moves later.
      node.append_attribute("dependencies") =
          (initial ? (isPlant ? parameters : inputs + " " + parameters) : (isPlant ? "" : inputs)).c_str();
    }
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

void writeUnit(const std::string& path, const ExportSetup& setup) {
  UnitConfiguration unit = setup.unit;
  const std::string device = readFile(setup.deviceFile);
  const auto mechanism = makeMechanism(parseDevice(device, setup.deviceFile));
  std::vector<ArchiveFile> files;
  std::string scene;
  if (!setup.sceneFile.empty()) {
    PackedScene packed = packScene(setup.sceneFile);
    scene = std::move(packed.text);
    for (const auto& [name, from] : packed.files) files.push_back({"resources/" + name, readFile(from, kLargestMesh)});
  }
  const std::string text = textOf(unit);
  files.push_back({"modelDescription.xml", modelDescription(unit, *mechanism, tokenOf(text, device, scene))});
  files.push_back({"resources/unit.json", text});
  files.push_back({"resources/device.toml", device});
  if (!scene.empty()) files.push_back({"resources/scene.toml", scene});
  files.push_back({"binaries/" + platformTuple() + "/" + kIdentifier + ".so", readFile(setup.binary, kLargestUnit)});
  writeArchive(path, files);
}

}  // namespace enamel::fmi
