// Common parts of all units: variables that a master accesses by reference, modes, and a state.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "description.hpp"
#include "fmi3.hpp"

namespace enamel::fmi {

enum class Phase { instantiated, initialising, stepping, terminated };

struct Condition {
  std::vector<std::vector<double>> values;  ///< by reference
  Phase phase = Phase::instantiated;
  double start = 0.0, last = 0.0;  ///< s: start of the simulation; last communication point
  bool isNew = true;               ///< an input was set after the last computation of outputs
};

/// State of a unit, sufficient to continue bit for bit. Each kind of unit adds its own part.
struct UnitState {
  Condition now;

  explicit UnitState(Condition condition) : now(std::move(condition)) {}
  virtual ~UnitState() = default;
  UnitState(const UnitState&) = delete;
  UnitState& operator=(const UnitState&) = delete;
};

class Unit {
 public:
  Unit(UnitConfiguration configuration, std::shared_ptr<const Mechanism> device);
  virtual ~Unit() = default;
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;

  Condition& now() { return now_; }

  /// End the initialisation. Throws Error.
  virtual void begin() = 0;
  /// Advance by `step` s. Throws Error.
  virtual void step(double step) = 0;

  /// Read variables of a type (double, std::int32_t or bool); set() writes them. Throws Error: an unknown variable, or
  /// one of another type; a wrong number of values; for set(): not finite, or a variable that cannot be set now.
  template <typename T>
  void get(const Reference references[], std::size_t count, T values[], std::size_t valueCount);
  template <typename T>
  void set(const Reference references[], std::size_t count, const T values[], std::size_t valueCount);

  virtual std::unique_ptr<UnitState> copyState() const = 0;
  /// Restore a state. `state`: from copyState() or stateOf() of a unit from the same file.
  virtual void putState(const UnitState& state) = 0;
  /// Convert a state to bytes, and back. Throws Error: this kind of unit has no bytes; bytes of another unit.
  virtual std::string bytesOf(const UnitState& state) const;
  virtual std::unique_ptr<UnitState> stateOf(const std::string& bytes) const;

 protected:
  std::vector<double>& value(const char* name);
  Vec3 vec3(const char* name) { return Eigen::Map<const Vec3>(value(name).data()); }
  JointVector joints(const char* name) {
    return Eigen::Map<const Eigen::VectorXd>(value(name).data(), device_->joints());
  }
  template <typename Derived>
  void put(const char* name, const Eigen::MatrixBase<Derived>& v) {
    std::vector<double>& to = value(name);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = v[static_cast<Eigen::Index>(i)];
  }
  /// Throws Error: start_orientation is not a unit quaternion.
  Pose startPose();

  UnitConfiguration configuration_;
  std::shared_ptr<const Mechanism> device_;
  Condition now_;

 private:
  virtual void refresh() {}  // computes outputs that depend directly on inputs

  // Call visit(variable, its numbers, index of the first one in the caller's array) for each reference.
  template <typename T, typename Visit>
  void eachValue(const Reference references[], std::size_t count, std::size_t valueCount, const Visit& visit);

  std::vector<Variable> variables_;
};

}  // namespace enamel::fmi
