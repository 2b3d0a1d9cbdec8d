// The table of a unit's variables. modelDescription.xml is written from it, and the unit reads and writes its variables
// by it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

enum class Causality { independent, parameter, input, output };
enum class Type { real, integer, boolean };  // Float64, Int32, Boolean

/// A variable; its value reference is its index in the table.
struct Variable {
  const char* name;
  Causality causality;
  const char* unit;  ///< SI; "": no unit
  const char* description;
  std::vector<double> start;  ///< one value for each number of the variable
  bool isArray = true;        ///< false: a scalar
  Type type = Type::real;
};

/// Contents of unit.json in a unit's resources. The resources also hold device.toml and, if given, scene.toml with its
/// meshes.
struct UnitConfiguration {
  std::string renderer;                           ///< empty: the unit is a plant
  std::map<std::string, std::string> parameters;  ///< of the renderer
  std::string plant = kClosedForm;                ///< as --plant; for a renderer: the plant that it is designed for
  int substeps = 1;
  double period = 1e-3;  ///< s
  bool guarded = true;
  double force = 0.0;  ///< limit of the guard, N; 0: no limit
  std::uint64_t seed = 1;
};

std::string textOf(const UnitConfiguration& configuration);
/// Throws ConfigurationError: the file is missing or has another format than textOf() writes.
UnitConfiguration readUnit(const std::string& path);

/// Return the variables of a unit. A plant has the torque, and force and moment of the person on the TCP, all constant
/// over a step. It also has pose, motion, encoders, the start pose, and a switch for a guiding hand (guidingWrench()).
/// A renderer has the measurements of a device, the torque, and the results of the tick.
std::vector<Variable> variablesOf(const UnitConfiguration& configuration, const Mechanism& device);

/// Return a token that identifies a set of resources. A unit checks it against its resources.
std::string tokenOf(const std::string& unit, const std::string& device, const std::string& scene);

inline constexpr const char* kIdentifier = "enamel_unit";  ///< of the binary

/// Return whether the state can be written as bytes.
bool canSerialise(const UnitConfiguration& configuration) noexcept;

}  // namespace enamel::fmi
