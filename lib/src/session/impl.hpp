// The parts of a session and the threads that use them.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "enamel/core/spsc_ring.hpp"
#include "enamel/runtime/triple_buffer.hpp"
#include "enamel/session/session.hpp"
#include "session/work_queue.hpp"
#include "session/world.hpp"

namespace enamel {
namespace session {

/// Effects of a loop on shared obstacles, on their way to the loop of another session.
struct Mailbox {
  struct Cut {
    std::uint32_t revision = 0;  // of the obstacle
    SolidCut cut;
  };
  SpscRing<Cut, 4096> ring;
  Cut next;  // of the receiving loop; waits while this loop does not have the revision yet
  bool isWaiting = false;
  struct Push {
    std::uint32_t generation = 0;  // of the obstacle
    int slot = 0;
    Vec6 impulse = Vec6::Zero();  // of a tick, on a movable obstacle
  };
  SpscRing<Push, 256> pushes;
};

/// Obstacles that one or more sessions share. Callers hold the mutex; no loop does.
struct Group {
  std::mutex mutex;
  Obstacles obstacles;
  std::uint32_t lastGeneration = 0;  // or revision
  double maxForce = kUnlimited;      // of the scene file, N
  std::vector<Session::Impl*> members;
};

/// A part of the tool that touches an obstacle.
struct Touch {
  ObstacleId obstacle;
  int part = 0;
  double last = 0.0;     // time of the last contact, s
  double impulse = 0.0;  // at the hand, N s
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
};

}  // namespace session

struct Session::Impl final : TickSink {
  enum class Loop : std::uint8_t { none, own, threaded };  // what runs the ticks: nothing, tick(), start()

  /// A renderer, and its names in a recording's header.
  struct RendererChoice {
    std::unique_ptr<Renderer> renderer;
    std::string name, plugin;
    std::map<std::string, std::string> parameters;
  };

  explicit Impl(const SessionDef& def);
  ~Impl() override;

  // Callers, with the group's mutex; choose() and select() without.
  template <typename Function>
  void post(Function function) {
    queue.post(std::move(function), isLive() && !isLoop());
  }
  std::unique_lock<std::mutex> lock() const;
  // Return whether the caller is the thread of the ticks.
  bool isLoop() const noexcept { return loopThread.load(std::memory_order_relaxed) == std::this_thread::get_id(); }
  bool isThreaded() const noexcept { return runs.load(std::memory_order_acquire) == Loop::threaded; }
  bool isLive() const noexcept { return runs.load(std::memory_order_acquire) != Loop::none; }
  void requireRoom();
  void join(const SessionDef& def);
  void leave() noexcept;
  void awaitLoop() const;
  void enter(std::unique_ptr<session::World> next);
  std::size_t slotOf(ObstacleId id) const;
  void changeObstacles(session::Obstacles next);
  void changeObstacle(ObstacleId id, const std::function<void(Obstacle&)>& change);
  void checkSize(ObstacleId id);
  std::shared_ptr<Solid> ownSolid(ObstacleId id);
  RendererChoice choose(const std::string& name, const std::map<std::string, std::string>& parameters) const;
  void select(RendererChoice next);
  void enterLoop(Loop kind);
  void leaveLoop() noexcept;

  // The loop.
  void atStart() noexcept override { loopThread.store(std::this_thread::get_id(), std::memory_order_relaxed); }
  void before(Measurement& measurement) noexcept override;
  void unsent() noexcept override { ++refused; }
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override;
  bool exists(ObstacleId id) const noexcept;
  double scale() const noexcept { return mapped ? mapped->scale() : 1.0; }
  void setEffect(const Vec6& wrench) noexcept;
  void spin(bool on) noexcept;
  void endRecording() noexcept;
  void stray() noexcept;
  void applySharedCuts() noexcept;
  void applySharedPushes() noexcept;
  void sharePushes() noexcept;
  void moveBase(const TickFrame& frame) noexcept;
  void countTime(const LoopTick& tick) noexcept;
  void watchContacts(const LoopTick& tick, const TickFrame& frame) noexcept;
  void watchDevice(const LoopTick& tick) noexcept;
  void watchCuts(const LoopTick& tick) noexcept;
  void sendEvent(SessionEvent event) noexcept;
  void publish(const LoopTick& tick, const TickFrame& frame) noexcept;

  // Constant after construction.
  SessionDef def;
  std::shared_ptr<const Mechanism> device;
  std::shared_ptr<MappedMechanism> mapped;  // null: the frames are the same
  double period = 1e-3;
  std::vector<std::string> notes;
  Pose start;           // of the tool in the scene
  OpenedDevice opened;  // of a URL; its device is null without one
  std::string deviceFile, deviceText, sceneText;

  // Callers, with the group's mutex.
  std::shared_ptr<session::Group> group;
  session::SessionTool tool_;
  session::OwnSolids solids;  // of the newest world
  RendererChoice choice;      // the newest; without a name: an own object
  mutable session::WorkQueue queue;
  std::unique_ptr<Recorder> recorder;
  std::unique_ptr<HapticDevice> owned;  // of start(); may be null
  std::unique_ptr<HapticLoop> loop;
  std::atomic<bool> strays{false};  // ticks depend on what a recording does not contain
  bool hasRun = false;
  std::atomic<Loop> runs{Loop::none};
  std::atomic<std::thread::id> loopThread{};  // while `runs`

  // The loop.
  std::unique_ptr<session::World> world;
  std::unique_ptr<HapticTick> haptics;
  Recorder* recording = nullptr;
  bool enabled = true, clutch = false, clutched = false, spins = false;
  bool isFrozen = false;  // the tool is held in the scene by moving the base
  Vec3 frozen = Vec3::Zero();
  LoopTick ownTick;              // of tick()
  std::uint64_t tickNumber = 0;  // of the last tick
  double tickTime = 0.0;         // s
  std::array<session::Touch, 16> touches;
  std::size_t touching = 0;
  GuardReason fault = GuardReason::none;
  bool isLost = false;
  double lastTime = -1.0, lastCut = 0.0;  // s
  std::uint64_t missed = 0, held = 0, refused = 0, dropped = 0, lostCuts = 0;
  RemovedVolume removed{}, unreported{};
  ObstacleId cutObstacle;
  std::vector<std::shared_ptr<session::Mailbox>> outboxes, inboxes;  // fixed while a loop runs

  // Between the loop and the callers.
  SpscRing<SessionEvent, 1024> events;
  mutable TripleBuffer<Snapshot> snapshots;
  std::atomic<std::int64_t> began{0};  // the last tick, or the loop before its first one; of system::clockNow(), ns
};

}  // namespace enamel
