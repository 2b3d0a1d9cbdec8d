// One haptic tick, from measured joints to the torque that a renderer proposes.
#pragma once

#include "enamel/collision/contacts.hpp"
#include "enamel/device/kinematics.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Obstacles farther from the tool than this are no contacts of a tick, m.
inline constexpr double kContactMargin = 1e-3;

/// What one tick leaves to the next: where the search for the pose and for the contacts begins. Made outside the ticks.
struct TickMemory {
  Configuration tracked;  ///< of the previous tick
  ToolCache contacts;     ///< of makeToolCache() for the scene and the tool
};

/// Forward kinematics -> pose, twist -> contacts of the tool with the scene -> renderer.
///
/// `q` (rad) and `rates` (rad/s) are measured at `time` (s). `input` is what the renderer saw: contacts within
/// kContactMargin. Statuses: those of forwardKinematics(), findContacts() and Renderer::step(); on any but ok the
/// output is a fault with zero torque. Realtime: yes.
[[nodiscard]] Status hapticTick(const DeviceModel& model, const Scene& scene, const Tool& tool, double time,
                                const Vec6& q, const Vec6& rates, TickMemory& memory, Renderer& renderer,
                                TickInput& input, TickOutput& output) noexcept;

}  // namespace enamel
