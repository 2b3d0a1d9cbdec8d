// The columns of a study: a renderer of --renderers each, on a plant of its own.
#pragma once

#include <nlohmann/json.hpp>

#include "study/study.hpp"

namespace enamel::app {

/// What the columns add to a study's manifest, by their names.
struct ColumnRecords {
  nlohmann::ordered_json plugins = nlohmann::ordered_json::object();   ///< version and parameters
  nlohmann::ordered_json dampings = nlohmann::ordered_json::object();  ///< --device-damping, N s/m
  nlohmann::ordered_json servos = nlohmann::ordered_json::object();  ///< hashes of what the linked ones were made with
};

/// Fill the plan's columns and their labels: names, plants, and the renderers of plugins. Needs the device, the plan's
/// setup and the options. Throws Error: a renderer that there is not, or twice; a damping or parameter for none of
/// them.
void addColumns(Study& study, ColumnRecords& records);

/// Design the linked renderers of the columns. Needs a plan that checkStudy() has passed. Throws Error: a servo file or
/// a tuned value that does not fit; as designServo().
void makeRenderers(Study& study, ColumnRecords& records);

}  // namespace enamel::app
