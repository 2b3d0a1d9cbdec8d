#include "design_results.hpp"

#include <nlohmann/json.hpp>

namespace enamel::app {

std::vector<Requirement> requirementsOf(const ServoDesign& design, const DevicePlant& plant) {
  return measureRequirements(design, linearPlant(design, plant.jacobian), plant.jacobian);
}

nlohmann::ordered_json toJson(const std::vector<Requirement>& requirements) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Requirement& r : requirements)
    list.push_back({{"name", r.name},
                    {"unit", r.unit},
                    {"limit", r.limit},
                    {"values", r.values},
                    {"worst", r.worst()},
                    {"met", r.met()}});
  return list;
}

WallDevice wallDeviceOf(const DevicePlant& plant, double damping, double period) {
  return {plant.effectiveMass, damping, period};
}

}  // namespace enamel::app
