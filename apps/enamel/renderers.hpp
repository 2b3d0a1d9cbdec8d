// The renderers by name, and what the commands that push share about them.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "enamel/control/device_plant.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

inline constexpr const char* kPositionControl = "position-control";
inline constexpr const char* kImpedance = "impedance";

/// "none", "constant:D" or "random:A..B", in ticks. Throws Error.
Delay parseDelay(const std::string& text);

/// A renderer that a user asked for: a linked one by its name, or a plugin by its path or by its name in pluginFolder().
struct RendererSource {
  std::string name;                             ///< of the linked one, or as the plugin describes itself
  std::shared_ptr<const PluginLibrary> plugin;  ///< nullptr: linked
};

/// Throws PluginError: as findPlugin().
RendererSource findRenderer(const std::string& nameOrPath);

/// The linked renderer; its servo is designed at home. Throws Error.
std::unique_ptr<Renderer> makeRenderer(const std::string& name, const TauModel& model, double period,
                                       const PositionControlOptions& servo, const ImpedanceOptions& impedance);

/// The plant under a renderer: the impedance wall runs on one with mechanical damping along z, as in the paper, the
/// servo on one without.
TauModel plantFor(const std::string& name, TauParameters device, const ImpedanceOptions& impedance);

/// Metrics with their units in the names; what a run does not have is null.
nlohmann::ordered_json toJson(const PushMetrics& metrics);

}  // namespace enamel::app
