// The columns of a study: one renderer of --renderers each, on its own plant.
#pragma once

#include <nlohmann/json.hpp>

#include "study/study.hpp"

namespace enamel::app {

/// Entries that the columns add to a study's manifest, by column name.
struct ColumnRecords {
  nlohmann::ordered_json plugins = nlohmann::ordered_json::object();   ///< version and parameters
  nlohmann::ordered_json dampings = nlohmann::ordered_json::object();  ///< --device-damping, N s/m
  nlohmann::ordered_json servos = nlohmann::ordered_json::object();    ///< CRC-32 of the linked renderers' servos
};

/// Fill the plan's columns and their labels: names, plants, and the renderers of plugins. Needs the device, the plan's
/// setup and the options. Throws Error: an unknown or repeated renderer; a damping or parameter that no renderer uses.
void addColumns(Study& study, ColumnRecords& records);

/// Design the linked renderers of the columns. Needs a plan that has passed checkStudy(). Throws Error: a servo file or
/// a tuned value that does not fit; as designServo().
void makeRenderers(Study& study, ColumnRecords& records);

}  // namespace enamel::app
