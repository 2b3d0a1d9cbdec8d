#include "enamel/control/servo_file.hpp"

#include <nlohmann/json.hpp>

#include "core/message.hpp"
#include "enamel/core/file.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

ServoFile loadServo(const std::string& path) {
  using Json = nlohmann::json;
  const auto refuse = [&path](const std::string& key, const std::string& problem) {
    throw ConfigurationError(path, 0, key, problem);
  };
  const Json json = Json::parse(readJson(path), nullptr, false);
  if (!json.is_object()) refuse("", "must be the JSON file of a servo design");
  if (json.value("kind", Json()) == "surface")
    refuse("kind", "is \"surface\": position control does not need a file any more");
  const auto require = [&](const char* key, bool (Json::*isType)() const noexcept, const char* type) -> const Json& {
    const auto found = json.find(key);
    if (found == json.end()) refuse(key, "is missing");
    if (!((*found).*isType)()) refuse(key, std::string("must be ") + type);
    return *found;
  };

  ServoFile servo;
  servo.model = require("model", &Json::is_string, "a string").get<std::string>();
  servo.period = require("period", &Json::is_number, "a number").get<double>();
  if (!(servo.period >= 1e-5 && servo.period <= 0.1))
    refuse("period", "is " + formatNumber(servo.period) + ", must be in 1e-05 to 0.1 s");
  const Json& rows = require("K", &Json::is_array, "a list of rows");
  const std::size_t n = rows.size();
  if (n < 1 || n > kMaxJoints)
    refuse("K", "has " + std::to_string(n) + " rows, must have 1 to " + std::to_string(kMaxJoints));
  servo.gain.resize(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(3 * n));
  for (std::size_t i = 0; i < n; ++i) {
    const std::string key = "K[" + std::to_string(i) + "]";
    if (!rows[i].is_array() || rows[i].size() != 3 * n)
      refuse(key, "must be a list of " + std::to_string(3 * n) + " numbers");
    for (std::size_t j = 0; j < 3 * n; ++j) {
      if (!rows[i][j].is_number()) refuse(key + "[" + std::to_string(j) + "]", "must be a number");
      servo.gain(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  }
  return servo;
}

}  // namespace enamel
