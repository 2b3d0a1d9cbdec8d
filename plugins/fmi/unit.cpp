#include "unit.hpp"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "enamel/core/error.hpp"

namespace enamel::fmi {
namespace {

template <typename T>
constexpr Type typeOf = std::is_same_v<T, double> ? Type::real
                        : std::is_same_v<T, bool> ? Type::boolean
                                                  : Type::integer;

}  // namespace

Unit::Unit(UnitConfiguration configuration, std::shared_ptr<const Mechanism> device)
    : configuration_(std::move(configuration)),
      device_(std::move(device)),
      variables_(variablesOf(configuration_, *device_)) {
  for (const Variable& variable : variables_) now_.values.push_back(variable.start);
}

std::string Unit::bytesOf(const UnitState&) const { throw Error("its state cannot be serialised"); }
std::unique_ptr<UnitState> Unit::stateOf(const std::string&) const { throw Error("its state cannot be serialised"); }

std::vector<double>& Unit::value(const char* name) {
  for (std::size_t i = 0; i < variables_.size(); ++i)
    if (std::strcmp(variables_[i].name, name) == 0) return now_.values[i];
  throw Error(std::string("unknown variable ") + name);
}

Pose Unit::startPose() {
  const std::vector<double>& o = value("start_orientation");
  const Eigen::Quaternion<double> orientation(o[0], o[1], o[2], o[3]);
  if (!(std::abs(orientation.norm() - 1.0) < 1e-6)) throw Error("start_orientation must be a unit quaternion to 1e-6");
  return {vec3("start_position"), orientation.normalized().toRotationMatrix()};
}

template <typename T, typename Visit>
void Unit::eachValue(const Reference references[], std::size_t count, std::size_t valueCount, const Visit& visit) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= variables_.size()) throw Error("unknown variable " + std::to_string(references[i]));
    const Variable& variable = variables_[references[i]];
    if (variable.type != typeOf<T>) throw Error(std::string(variable.name) + " has another type");
    std::vector<double>& values = now_.values[references[i]];
    if (valueCount - at < values.size())
      throw Error(std::string(variable.name) + " has " + std::to_string(values.size()) + " numbers, more than given");
    visit(variable, values, at);
    at += values.size();
  }
  if (at != valueCount) throw Error("more values are given than the variables have");
}

template <typename T>
void Unit::get(const Reference references[], std::size_t count, T values[], std::size_t valueCount) {
  if (now_.phase == Phase::stepping) refresh();
  eachValue<T>(references, count, valueCount, [&](const Variable& variable, auto& from, std::size_t at) {
    if (variable.causality == Causality::independent) from[0] = now_.last;
    for (std::size_t k = 0; k < from.size(); ++k) values[at + k] = static_cast<T>(from[k]);
  });
}

template <typename T>
void Unit::set(const Reference references[], std::size_t count, const T values[], std::size_t valueCount) {
  eachValue<T>(references, count, valueCount, [&](const Variable& variable, auto& to, std::size_t at) {
    const bool isInput = variable.causality == Causality::input;
    const bool early = now_.phase == Phase::instantiated || now_.phase == Phase::initialising;
    if (!isInput && !(variable.causality == Causality::parameter && early))
      throw Error(std::string(variable.name) + " cannot be set now");
    for (std::size_t k = 0; k < to.size(); ++k) {
      const auto number = static_cast<double>(values[at + k]);
      if (!std::isfinite(number)) throw Error(std::string(variable.name) + " is not finite");
      to[k] = number;
    }
    now_.isNew = true;
  });
}

template void Unit::get(const Reference[], std::size_t, double[], std::size_t);
template void Unit::get(const Reference[], std::size_t, std::int32_t[], std::size_t);
template void Unit::get(const Reference[], std::size_t, bool[], std::size_t);
template void Unit::set(const Reference[], std::size_t, const double[], std::size_t);
template void Unit::set(const Reference[], std::size_t, const std::int32_t[], std::size_t);
template void Unit::set(const Reference[], std::size_t, const bool[], std::size_t);

}  // namespace enamel::fmi
