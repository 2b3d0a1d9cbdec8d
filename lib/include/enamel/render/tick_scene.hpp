// The surroundings of a tick: obstacles, their motion, the tool, and the tool's path among the obstacles.
#pragma once

#include <cstddef>

#include "enamel/collision/contacts.hpp"
#include "enamel/render/compliance.hpp"
#include "enamel/render/scene_motion.hpp"

namespace enamel {

/// Margin of contact search, m. Obstacles farther from the tool than this are not contacts of a tick.
inline constexpr double kContactMargin = 1e-3;

/// The scene and the tool of a tick. Make one outside the ticks; HapticTick::exchange() puts it into use in one tick.
class TickScene {
 public:
  /// `scene` must outlive this object. Throws Error as makeToolTrack(). Realtime: no.
  TickScene(const Scene& scene, const Tool& tool);

  /// Return the scene with its obstacles where the last tick had them, and the tool. Realtime: yes.
  const Scene& scene() const noexcept { return motion_.scene(); }
  const Tool& tool() const noexcept { return tool_; }
  /// Return whether a tap on the scene has a transient (Obstacle::tap). Realtime: yes.
  bool hasTaps() const noexcept { return hasTaps_; }
  /// Return whether an obstacle is rough (Material::roughness). Realtime: yes.
  bool isRough() const noexcept { return isRough_; }
  const SceneMotion& motion() const noexcept { return motion_; }
  SceneMotion& motion() noexcept { return motion_; }
  ComplianceMemory& compliance() noexcept { return compliance_; }

  /// Move the obstacles to `time`, s, `elapsed` s after the last call, and find the contacts of the tool at a pose.
  /// `bur`: the parts that spin; `recession`: of the surface that it cuts (Drill), m/s. Statuses as
  /// followContacts(). Realtime: yes.
  [[nodiscard]] Status findContacts(const Pose& pose, double time, double elapsed, const PartRange& bur,
                                    double recession, ContactSnapshot& contacts) noexcept;

  /// Continue the motions of `old` among the obstacles that both have (isSameObstacle()), and the path of the tool if
  /// it is the same. A new obstacle is at rest at its stated pose. `old` may afterwards only be destroyed. Realtime:
  /// yes.
  void takeOver(TickScene& old) noexcept;

  /// Put the obstacles at their stated poses, at rest and whole. forgetPath() forgets the path of the tool. Realtime:
  /// yes.
  void reset() noexcept {
    motion_.reset(*stated_);
    compliance_.reset();
  }
  void forgetPath() noexcept { track_.reset(motion_.scene()); }

  /// Save and load the path of the tool, movable obstacles and compliant materials as stateSize() numbers. loadState()
  /// also resets the other obstacles. Realtime: yes.
  std::size_t stateSize() const noexcept { return motion_.stateSize() + track_.stateSize() + compliance_.stateSize(); }
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

 private:
  const Scene* stated_;  // its poses and twists are where the obstacles shall go
  Tool tool_;
  SceneMotion motion_;
  ComplianceMemory compliance_;
  ToolTrack track_;
  bool hasTaps_, isRough_;
};

}  // namespace enamel
