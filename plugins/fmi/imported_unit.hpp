// A unit (*.fmu) from any tool, opened for use as a plant: with its description read and its binary loaded.
#pragma once

#include <atomic>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "archive.hpp"
#include "enamel/device/mechanism.hpp"
#include "fmi3.hpp"

namespace enamel::fmi {

/// References of a variable's numbers: one for an array, or one for each scalar; empty: the unit lacks it.
struct FoundVariable {
  std::vector<Reference> references;
  std::size_t size = 0;
};

class ImportedUnit {
 public:
  /// Throws Error with the file and the reason: as plantsOf() (import.hpp).
  ImportedUnit(const std::string& path, const Mechanism& device);
  ~ImportedUnit();
  ImportedUnit(const ImportedUnit&) = delete;
  ImportedUnit& operator=(const ImportedUnit&) = delete;

  const std::string& path() const noexcept { return path_; }
  std::string resources() const { return archive_.folder() + "/resources/"; }

  FoundVariable torque, force, moment, position, orientation, velocity, angularVelocity, q, rates, startPosition,
      startOrientation;
  bool anyStep = false;  ///< false: all its steps must have the same size
  bool onlyOne = false;  ///< only one instance is possible
  std::string token;

  InstantiateCoSimulation* instantiate = nullptr;
  FreeInstance* free = nullptr;
  EnterInitializationMode* enterInitialization = nullptr;
  Transition *exitInitialization = nullptr, *terminate = nullptr;
  Get<double>* get = nullptr;
  Set<double>* set = nullptr;
  DoStep* doStep = nullptr;

  mutable std::atomic<bool> taken{false};  ///< if onlyOne: an instance exists

 private:
  struct Wanted;

  [[noreturn]] void refuse(const std::string& reason) const;
  void readDescription();
  void findVariables(std::size_t joints, bool turns);
  pugi::xml_node variable(const std::string& name) const;
  Reference check(const pugi::xml_node& node, const std::string& name, const Wanted& wanted) const;
  void checkDimension(const std::string& name, const std::string& unit, const Wanted& wanted) const;
  FoundVariable find(const std::string& name, const Wanted& wanted) const;
  FoundVariable require(const std::string& name, const Wanted& wanted) const;
  void loadBinary();
  template <typename Function>
  void symbol(const char* name, Function*& function);

  std::string path_;
  UnpackedArchive archive_;
  pugi::xml_document document_;
  std::string identifier_;
  void* handle_ = nullptr;
};

}  // namespace enamel::fmi
