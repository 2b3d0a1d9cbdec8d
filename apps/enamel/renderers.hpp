// The renderers by name, and what the commands that push share about them.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "enamel/control/servo_design.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

inline constexpr const char* kPositionControl = "position-control";
inline constexpr const char* kImpedance = "impedance";

/// "none", "constant:D" or "random:A..B", in ticks. Throws Error.
Delay parseDelay(const std::string& text);

/// The paper's servo about a pose at rest. Throws DesignError.
ServoDesign designAt(const DeviceModel& model, const Pose& pose, double period);

/// A renderer by its name; the servo is designed at home. Throws Error.
std::unique_ptr<Renderer> makeRenderer(const std::string& name, const DeviceModel& model, double period,
                                       const PositionControlOptions& servo, const ImpedanceOptions& impedance);

/// The plant under a renderer: the impedance wall runs on one with mechanical damping along z, as in the paper, the
/// servo on one without.
DeviceModel plantFor(const std::string& name, DeviceParameters device, const ImpedanceOptions& impedance);

/// Metrics with their units in the names; what a run does not have is null.
nlohmann::ordered_json toJson(const PushMetrics& metrics);

}  // namespace enamel::app
