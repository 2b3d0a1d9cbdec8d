// One haptic tick, from what a device measured to the torque that its motors get.
#pragma once

#include "enamel/collision/contacts.hpp"
#include "enamel/device/haptic_device.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Obstacles farther from the tool than this are no contacts of a tick, m.
inline constexpr double kContactMargin = 1e-3;

/// Mechanism::track() -> contacts of the tool with the scene -> renderer. Owns what lasts from tick to tick; refers to
/// mechanism, scene and renderer, which must outlive it. Obstacles may move between ticks, none may be added.
class HapticTick {
 public:
  /// Activates the renderer for ticks of `period` s. `start`: about where the platform is at the first tick (home where
  /// it cannot be reached). Throws Error: as Renderer::activate(). Realtime: no.
  HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer, double period,
             const Pose& start = Pose{});

  /// One tick. Statuses: those of Mechanism::track(), findContacts() and Renderer::step(); on any but ok the command is
  /// zero torque. Realtime: yes.
  [[nodiscard]] Status operator()(const Measurement& measurement, Command& command) noexcept;

  /// What the renderer saw and answered at the last tick. Realtime: yes.
  const TickInput& input() const noexcept { return input_; }
  const TickOutput& output() const noexcept { return output_; }

 private:
  Status see(const Measurement& measurement) noexcept;

  const Mechanism& mechanism_;
  const Scene& scene_;
  Tool tool_;
  Renderer& renderer_;
  ToolTrack track_;
  TickInput input_;
  TickOutput output_;
};

}  // namespace enamel
