// What a unit is: its variables, in one table, from which modelDescription.xml is written and by which the unit itself
// reads and writes them.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

enum class Causality { independent, parameter, input, output };
enum class Type { real, integer, boolean };  // Float64, Int32, Boolean

/// A variable; its value reference is its place in the table.
struct Variable {
  const char* name;
  Causality causality;
  const char* unit;  ///< SI; "": none
  const char* description;
  std::vector<double> start;  ///< as many as the variable has numbers
  bool isArray = true;        ///< false: a scalar
  Type type = Type::real;
};

/// What the file unit.json in a unit's resources says; beside it stand device.toml and, where one was given, scene.toml
/// with its meshes.
struct UnitConfiguration {
  std::string renderer;                           ///< empty: a plant
  std::map<std::string, std::string> parameters;  ///< of the renderer
  std::string plant = kClosedForm;                ///< as --plant; of a renderer: the one that it is for
  int substeps = 1;
  double period = 1e-3;  ///< s
  bool guarded = true;
  double force = 0.0;  ///< the guard's limit, N; 0: none
  std::uint64_t seed = 1;
};

std::string textOf(const UnitConfiguration& configuration);
/// Throws ConfigurationError: no such file, or not as textOf() writes it.
UnitConfiguration readUnit(const std::string& path);

/// The variables of a unit. Of a plant: torque, and force and moment of the person on the TCP, held over a step; pose,
/// motion, encoders; where it starts, and whether a hand guides it (guidingWrench()). Of a renderer: what a device
/// measures; torque, and what came of it.
std::vector<Variable> variablesOf(const UnitConfiguration& configuration, const Mechanism& device);

/// A short name for a set of resources, which a unit checks against what it finds.
std::string tokenOf(const std::string& unit, const std::string& device, const std::string& scene);

inline constexpr const char* kIdentifier = "enamel_unit";  ///< of the binary

/// Whether its state can be written as bytes.
bool canSerialise(const UnitConfiguration& configuration) noexcept;

}  // namespace enamel::fmi
