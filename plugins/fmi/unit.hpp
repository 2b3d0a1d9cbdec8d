// What every unit has: variables that a master reads and writes by their references, modes, and a state.
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
  double start = 0.0, last = 0.0;  ///< s: of the simulation; of the last communication point
  bool isNew = true;               ///< an input was set since outputs were computed
};

/// What a unit needs to continue bit for bit. Each kind of unit adds its own part.
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

  /// Ends the initialisation. Throws Error.
  virtual void begin() = 0;
  /// Moves on by `step` s. Throws Error.
  virtual void step(double step) = 0;

  /// Reads and writes variables of a type: double, std::int32_t or bool. Throws Error: no such variable, one of another
  /// type; another number of values; set(): not finite, or a variable that cannot be set now.
  template <typename T>
  void get(const Reference references[], std::size_t count, T values[], std::size_t valueCount);
  template <typename T>
  void set(const Reference references[], std::size_t count, const T values[], std::size_t valueCount);

  virtual std::unique_ptr<UnitState> copyState() const = 0;
  /// `state`: of copyState() or stateOf() of a unit from the same file.
  virtual void putState(const UnitState& state) = 0;
  /// Throws Error: not every unit has these; bytes of another unit.
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
  virtual void refresh() {}  // outputs that follow from inputs at once

  // Calls visit(variable, its numbers, place of the first in the caller's array) for each reference.
  template <typename T, typename Visit>
  void eachValue(const Reference references[], std::size_t count, std::size_t valueCount, const Visit& visit);

  std::vector<Variable> variables_;
};

}  // namespace enamel::fmi
