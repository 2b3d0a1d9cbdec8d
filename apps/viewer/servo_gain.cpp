#include "servo_gain.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "data_folder.hpp"
#include "enamel/core/error.hpp"

namespace enamel::viewer {

ServoedDevice loadServoedDevice(const std::string& path) {
  ServoedDevice device;
  device.parameters = loadDevice(path);
  const std::string file = dataFolder() + "/reference/servo-nominal.json";
  try {
    const auto rows = nlohmann::json::parse(std::ifstream(file)).at("K");
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 18; ++j)
        device.gain(static_cast<int>(i), static_cast<int>(j)) = rows.at(i).at(j).get<double>();
  } catch (const nlohmann::json::exception& error) {
    throw Error(file + ": cannot read the servo gain K: " + error.what());
  }
  return device;
}

}  // namespace enamel::viewer
