// Data of a session: its definition, its snapshots and its events.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/mapped_mechanism.hpp"
#include "enamel/render/guard.hpp"
#include "enamel/runtime/haptic_loop.hpp"

namespace enamel {

class Session;
class TickAccess;

/// Name of an obstacle of a session. The name of a removed obstacle is never used again.
struct ObstacleId {
  int slot = -1;                 ///< number of the obstacle in the scene
  std::uint32_t generation = 0;  ///< 0: no obstacle

  bool operator==(const ObstacleId& other) const noexcept {
    return slot == other.slot && generation == other.generation;
  }
  bool operator!=(const ObstacleId& other) const noexcept { return !(*this == other); }
};

/// An obstacle for a session. `mesh` or `solid`, if set, replaces the shape: a mesh that can be edited, or a solid that
/// a bur can cut. The session cuts a copy of the solid.
struct SessionObstacle : Obstacle {
  std::shared_ptr<MeshModel> mesh = nullptr;
  std::shared_ptr<const Solid> solid = nullptr;
};

/// Definition of a session. Every member has a default.
struct SessionDef {
  std::string device;                          ///< device file, or URL for startOpened(); empty: `mechanism`
  std::shared_ptr<const Mechanism> mechanism;  ///< null: the nominal TAU
  std::string scene;                           ///< scene file; empty: no obstacles at first
  std::optional<Tool> tool;                    ///< empty: that of the scene file, or a point
  std::optional<Bur> bur;                      ///< empty: that of the scene file, or none
  std::optional<Pose> start;                   ///< of the tool in the scene; empty: that of the scene file, or home

  std::string renderer = "position-control";      ///< name of a linked renderer or of a plugin, or a plugin's path
  std::map<std::string, std::string> parameters;  ///< of the renderer, as in makeLinked(); for example {"delay", "1"}
  std::string pluginFolder;                       ///< where renderers and drivers are searched by name

  double rate = 1000.0;                 ///< ticks per second, Hz
  std::optional<WorkspaceMap> map;      ///< place and scale of the device in the scene; empty: frames are the same
  int clutchButton = -1;                ///< button that freezes the tool while the hand moves on; -1: none
  double centring = 0.0;                ///< see Session; 0 to 0.5
  double maxForce = kUnlimited;         ///< largest rendered force at the hand, N; the scene file's may be smaller
  std::optional<GuardOptions> guard;    ///< instead of guardFor(); for the device, without the map
  int priority = 80;                    ///< SCHED_FIFO priority of the loop's thread
  double poll = 0.0;                    ///< HapticLoopOptions::period, s: for a device with its own clock
  bool lockMemory = true;               ///< as HapticLoopOptions
  std::shared_ptr<Session> sharesWith;  ///< the obstacles are those of this session; `scene` must be empty

  /// Called before each tick on the loop's thread. Must be Realtime: yes.
  std::function<void(TickAccess&)> beforeTick;
};

/// State of a session after one tick. Plain data, in the frame of the scene. Forces are those at the hand.
struct Snapshot {
  /// Pose and twist of the tool, measurement, command, mode, reasons, statuses. normalForce is that of the deepest
  /// contact alone: use `wrench` for the force.
  LoopTick tick;
  ContactSnapshot contacts;    ///< near contacts, the deepest first
  Vec6 wrench = Vec6::Zero();  ///< of the rendered part on the tool at the TCP, N and N m
  Vec3 base = Vec3::Zero();    ///< WorkspaceMap::base.position: changes with the clutch
  GuardReason fault = GuardReason::none;
  bool enabled = true;              ///< by Session::enable() and by the device
  bool clutched = false;            ///< the tool is frozen
  bool spins = false;               ///< the motor of the bur is on
  double burTurns = 0.0;            ///< speed of the bur, turns per second
  double burTorque = 0.0;           ///< of the cut on its motor, N m
  double burChatter = 0.0;          ///< amplitude of its chatter, m
  RemovedVolume removed{};          ///< material removed by this session since its start, m^3 by layer
  std::uint64_t missed = 0;         ///< periods that passed without a tick, by the time stamps
  std::uint64_t held = 0;           ///< ticks without a new sample
  std::uint64_t unsent = 0;         ///< commands that the device of start() refused
  std::uint64_t droppedEvents = 0;  ///< events without room in the queue
  std::uint64_t lostCuts = 0;       ///< cuts that another session did not take in time: its solids have more material
  double sinceTick = 0.0;           ///< s since the last tick began: grows if the loop hangs; 0: no loop runs
};

/// A device that has given no samples for this time is lost, s. A late answer is shorter.
inline constexpr double kLostAfter = 0.1;

/// Return whether a device is lost at a tick. Realtime: yes.
inline bool isLostIn(const Measurement& measurement, double period) noexcept {
  return measurement.failed || measurement.age * period > kLostAfter;
}

/// Largest component of an effect, N and N m.
inline constexpr double kLargestEffect = 1000.0;

/// Return whether a wrench can be an effect. Realtime: yes.
inline bool isEffect(const Vec6& wrench) noexcept {
  return wrench.allFinite() && wrench.cwiseAbs().maxCoeff() <= kLargestEffect;
}

/// Kind of an event in a tick.
enum class EventKind : std::uint8_t {
  contactBegin,  ///< a part of the tool touches an obstacle
  contactEnd,    ///< it has not touched it for 20 ms
  guardStop,     ///< the guard latched a fault: `reason`
  cut,           ///< the bur removed material: `removed`, the sum of up to 20 ms
  missed,        ///< `count` periods passed without a tick
  deviceLost,    ///< the device has given no samples for kLostAfter, or its driver failed
  deviceBack,    ///< it gives samples again; a fault of the guard remains until reset()
  recordingEnd,  ///< a change of scene, tool or renderer ended the recording
  unusualSize,   ///< the size of a new mesh or solid suggests another unit: `extent` (see unusualSize())
};

struct SessionEvent {
  EventKind kind = EventKind::contactBegin;
  std::uint64_t tick = 0;      ///< number of the tick
  double time = 0.0;           ///< of the tick, s
  ObstacleId obstacle;         ///< of contacts and cuts
  int part = 0;                ///< of the tool
  Vec3 point = Vec3::Zero();   ///< of the contact in the scene, m
  Vec3 normal = Vec3::Zero();  ///< of the obstacle
  double speed = 0.0;          ///< contactBegin: speed of the tool against the surface, m/s
  double impulse = 0.0;        ///< contactEnd: integral of the whole rendered force along the normal, at the hand, N s
  GuardReason reason = GuardReason::none;
  RemovedVolume removed{};  ///< m^3 by layer
  std::uint64_t count = 0;  ///< of `missed`
  double extent = 0.0;      ///< unusualSize: the largest one of the obstacle along its axes, m
};

/// Return the name of a kind in plain words. Realtime: yes.
const char* toString(EventKind kind) noexcept;

}  // namespace enamel
