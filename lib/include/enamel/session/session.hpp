// A running device in one object: mechanism, scene, tool, renderer, guard, bur, loop and recorder. A host application
// makes one from a SessionDef, starts it with a device, and reads snapshots and events from its own threads.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/solid_changes.hpp"
#include "enamel/device/haptic_device.hpp"
#include "enamel/render/renderer.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/session/open_device.hpp"
#include "enamel/session/types.hpp"
#include "enamel/sim/simulated_device.hpp"

namespace enamel {

/// The session of one device.
///
/// Threads: all functions may be called from any thread while the loop runs, except tick(), which is the loop. They may
/// wait for each other, but the loop never waits for them and never allocates. Changes are made on the caller's thread
/// and handed over: they take effect at the next tick, in the order of the calls. Before start() and the first tick(),
/// they take effect at once. Functions throw Error if an argument is invalid or a name is out of date. They also throw
/// it if 1024 changes are waiting because the loop does not run. After an error nothing has changed. Realtime: no,
/// unless stated otherwise.
///
/// Frames: with a WorkspaceMap, poses, contacts and effects are those of the tool in the scene. Stiffness of a material
/// is force at the hand per distance in the scene. The limits of the guard are those of the device; a box
/// (GuardOptions::workspace) excludes a map.
///
/// Clutch: while the button is pressed, the rendered force ramps out. The tool then stays in the scene while the hand
/// moves, and turns with the hand. Centring: while the hand moves freely, the tool moves up to `centring` times the way
/// of the hand farther from the middle, so that the hand returns to the middle. It does not act within 1 mm of
/// obstacles.
class Session {
 public:
  /// Throws Error as loadDevice(), openDevice(), loadScene(), findRenderer(), makeLinked(), checkMechanism(),
  /// MappedMechanism and HapticTick, and for a value of the definition outside its range.
  explicit Session(const SessionDef& def);
  ~Session();  ///< calls stop()
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Run a loop with a device in a thread of its own: the one whose URL is SessionDef::device, or this one. The device
  /// must outlive stop(), or the session keeps it until the next start(). Throws Error as HapticLoop, and if the
  /// session is already running. stop() ramps out and ends the loop, or marks the end of an own loop.
  void startOpened();
  void start(HapticDevice& device);
  void start(std::unique_ptr<HapticDevice> device);
  void stop() noexcept;
  bool isRunning() const noexcept;

  /// Run one tick in an own loop instead of start(). Command and status are those of HapticTick. The first call may
  /// wait for other callers. Status inactive, and a command of zero, while the loop of start() runs. Realtime: yes.
  [[nodiscard]] Status tick(const Measurement& measurement, Command& command) noexcept;

  /// Return the newest state. Never waits for the loop.
  Snapshot snapshot() const;

  /// Take the oldest event. Return false if no event is waiting. The queue has room for 1024.
  bool nextEvent(SessionEvent& event);

  // Obstacles.

  /// Add an obstacle at rest. Throws Error as Scene::add().
  ObstacleId add(const SessionObstacle& obstacle);

  /// Replace shape, material, thickness and suspension of an obstacle. Its name, its pose and `active` remain.
  void replace(ObstacleId id, const SessionObstacle& by);
  void remove(ObstacleId id);

  /// Return the obstacle with this name; generation 0 if the name is unknown.
  ObstacleId find(const std::string& name) const;

  /// Set pose and twist, as Scene::move(): SceneMotion interpolates poses that come at frame rate.
  void move(ObstacleId id, const Pose& pose, const Vec6& twist = Vec6::Zero());

  /// Set the material of an obstacle. A solid has materials of its layers instead.
  void setMaterial(ObstacleId id, const Material& material);

  /// Set the tap of an obstacle: how the handle vibrates after an impact. A solid has taps of its layers instead.
  void setTap(ObstacleId id, const Tap& tap);

  /// Set the suspension of an obstacle; empty: contact forces do not move it. Its forces are those at the hand. A
  /// movable obstacle continues its motion. Throws Error as Scene::add().
  void setSuspension(ObstacleId id, const std::optional<Suspension>& suspension);

  /// Activate or deactivate an obstacle. An inactive one keeps its memory and cannot be touched.
  void activate(ObstacleId id, bool active);

  /// Move vertices of SessionObstacle::mesh, as moveVertices(). The loop spends about 1 us a vertex in one tick. No
  /// other thread may read the mesh. Throws Error also if an index or position is outside its range, or if two sessions
  /// share the obstacle: then replace() it.
  void moveVertices(ObstacleId id, std::vector<int> vertices, std::vector<Vec3> positions);

  /// Replace the solid by a new copy, without cuts. Take the newest samples of a changed brick for drawing; return
  /// false if no brick has changed. After restore() and replace() they are changes of the new copy.
  void restore(ObstacleId id);
  bool takeChange(ObstacleId id, BrickChange& change);

  /// Begin a stroke of a solid, and undo the last one, as Solid::mark() and undo(). Without a stroke, undo() does
  /// nothing. Throw Error also if two sessions share the obstacle: then restore() it.
  void mark(ObstacleId id);
  void undo(ObstacleId id);

  /// Return the solid as it was given, without cuts; null for other shapes. Its bricks have the numbers of the changes.
  std::shared_ptr<const Solid> solid(ObstacleId id) const;

  /// Return a copy of the solid with the cuts that the loop has sent. After stop() these are all.
  Solid cutSolid(ObstacleId id);

  // Guides, tool, renderer, control.

  /// Set all guides of the scene (Guidance). They ramp in. Throws Error as Scene::setGuides().
  void setGuides(std::vector<Guide> guides);

  /// Change the tool. Without a bur, nothing is cut. Throws Error as Drill and checkTool().
  void setTool(const Tool& tool, const std::optional<Bur>& bur = std::nullopt);

  /// Change the renderer. It starts without knowledge. Throws Error as the constructor.
  void setRenderer(const std::string& name, const std::map<std::string, std::string>& parameters = {});
  void setRenderer(std::unique_ptr<Renderer> renderer);

  /// Set the effect of HapticTick::setEffect(), N and N m at the hand, in the axes of the scene, at most
  /// kLargestEffect.
  void setEffect(const Vec6& wrench);

  /// Set the force of the gripper's motor, N, opening it, at most kLargestEffect. The device cuts it at its limit.
  void setGripper(double force);

  void spin(bool on);    ///< start or stop the bur
  void clutch(bool on);  ///< as the clutch button
  void enable(bool on);  ///< render, or ramp out
  void reset();          ///< continue after a fault of the guard

  /// Record ticks to a file. Throws Error as Recorder, and if the recording could not be replayed. That is so:
  ///
  /// - with a WorkspaceMap, shared obstacles, an own mechanism, or an own renderer object;
  /// - if obstacles and tool are not those of the scene file, or without one: those of flatWall() and a point;
  /// - after an effect, a cut or a motion of an obstacle before the recording.
  ///
  /// A change of the scene, the tool or the renderer, an effect and a motion of an obstacle end the recording.
  /// stopRecording() returns its result; without a recording, an empty one.
  void record(const std::string& path);
  RecordingResult stopRecording();

  // Access to the objects below.

  const Mechanism& mechanism() const noexcept;             ///< of the device, without the map
  Pose start() const noexcept;                             ///< of the device at the first tick, without the map
  double period() const noexcept;                          ///< s
  const std::vector<std::string>& notes() const noexcept;  ///< of the scene file
  const OpenedDevice& opened() const noexcept;             ///< of the URL; without one, its device is null

  /// Return the haptic tick. Only on the thread of tick() or of SessionDef::beforeTick, or while no loop runs.
  const HapticTick& haptics() const noexcept;

  /// Return the loop of start(), for its timing and counters; null without one. It ends with stop(). Only on the
  /// thread that calls start() and stop().
  const HapticLoop* loop() const noexcept;

  struct Impl;  ///< private to the library

 private:
  std::unique_ptr<Impl> impl_;
};

/// The functions for SessionDef::beforeTick, on the loop's thread. Realtime: yes. The changes act in this tick, and
/// only in this session. An obstacle that was removed meanwhile is ignored.
class TickAccess {
 public:
  const Measurement& measurement() const noexcept { return measurement_; }  ///< of this tick
  const TickFrame& frame() const noexcept;                                  ///< of the tick before

  [[nodiscard]] Status move(ObstacleId id, const Pose& pose, const Vec6& twist = Vec6::Zero()) noexcept;
  [[nodiscard]] Status activate(ObstacleId id, bool active) noexcept;
  void spin(bool on) noexcept;
  Status setEffect(const Vec6& wrench) noexcept;  ///< notFinite, outOfRange: above kLargestEffect
  Status setGripper(double force) noexcept;       ///< the same

 private:
  friend class Session;
  TickAccess(Session::Impl& session, const Measurement& measurement) : session_(session), measurement_(measurement) {}
  Session::Impl& session_;
  const Measurement& measurement_;
};

/// Make a virtual device for a session: an ideal one in real time, at the session's start, held by a hand (N, N m; in
/// the device's frame). Default: pressingHand(). The device refers to the session. Throws Error as SimulatedDevice.
std::unique_ptr<SimulatedDevice> makeVirtualDevice(const Session& session, WrenchFunction hand = {});

}  // namespace enamel
