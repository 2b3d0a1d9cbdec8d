// One haptic tick, from measured joints to the torque that a renderer proposes.
#pragma once

#include "enamel/collision/scene.hpp"
#include "enamel/device/kinematics.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Forward kinematics -> pose, twist -> contacts of the TCP with the scene -> renderer.
///
/// `q` (rad) and `rates` (rad/s) are measured at `time` (s). `tracked` is the previous tick's configuration and becomes
/// this tick's. `input` is what the renderer saw. Statuses: those of forwardKinematics() and of Renderer::step(); on
/// any but ok the output is a fault with zero torque. Realtime: yes.
[[nodiscard]] Status hapticTick(const DeviceModel& model, const Scene& scene, double time, const Vec6& q,
                                const Vec6& rates, Configuration& tracked, Renderer& renderer, TickInput& input,
                                TickOutput& output) noexcept;

}  // namespace enamel
