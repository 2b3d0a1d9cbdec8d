// The experiment of the viewer, tick by tick: a scene, the virtual device, renderers to compare, and a person's hand.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "conditions.hpp"
#include "drilled_solids.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/control/first_impact.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/sim/push.hpp"
#include "hand.hpp"
#include "movable.hpp"
#include "servoed_device.hpp"

namespace enamel::viewer {

/// Forces of a test push, N. It is scenario 1 of runPush() with this step after this preload, from rest on the surface.
inline constexpr double kTestForce = 12.0, kTestPreload = 0.5;

/// Results of a test push, judged as in `enamel push` and the study. They and the settings of the push are kept until
/// the next one.
struct TestPush {
  bool made = false;
  FirstImpactVerdict verdict = FirstImpactVerdict::noStep;  ///< noStep: no wall within reach
  Status status = Status::ok;   ///< reason for an early end: stopped by the guard, or the plant left its workspace
  double amount = 0.0;          ///< if unstable: half the force's range, N; if it slipped: tangential path, m
  Settings settings;            ///< settings of the push
  double limit = 0.0;           ///< stiffnessLimit() at that time, N/m
  double depthStiffness = 0.0;  ///< K_d, N/m; 0: the tool did not move deeper
  double deepest = 0.0;         ///< largest depth below the surface, m
  // Set if the verdict is `measured`:
  double stiffness = 0.0;  ///< K_z1, N/m
  double depth = 0.0;      ///< D_z1, m
  double force = 0.0;      ///< F_1 in addition to the preload, N
  double preload = 0.0;    ///< before the step, N
};

/// Ratio of the depths of two test pushes.
struct DepthRatio {
  static constexpr double kLeast = 2e-6;  ///< smaller depths count as this one, m
  std::size_t deeper;                     ///< 0 or 1
  double times;                           ///< at least 1
  bool atLeast;                           ///< the smaller depth was below kLeast
};
/// Return the ratio, or nothing if a push was not measured.
std::optional<DepthRatio> ratioOf(const TestPush& left, const TestPush& right) noexcept;

/// Data of a tick for drawing. Plain data.
struct Frame {
  TickRecord record;
  ContactSnapshot contacts;  ///< contacts within kContactMargin that the renderer received
  Hand hand;
  RendererSlot selected = RendererSlot::positionControl;
  PositionControlState control;  ///< state of position control
  bool holding = false;          ///< the renderer hold keeps the tool at `reference`
  JointVector reference;         ///< joint coordinates, rad or m
  bool testing = false;          ///< a test push is in progress
  Conditions conditions;
  Readout readout;                                        ///< smoothed
  std::array<std::uint64_t, kGuardReasons> guardTicks{};  ///< ticks of this experiment, by GuardReason
  DrillState drilled;                                     ///< set if the scene has a bur
  MovablePoses movable;                                   ///< poses of the obstacles with a suspension
  std::array<TestPush, kMaxRenderers> tests;              ///< last test push of each renderer
  Status plant = Status::ok;                              ///< if not ok, the loop stops until it is replaced
  // Set by the runner:
  bool paused = false;
  int slowdown = 1;
  std::uint64_t droppedSamples = 0;
};

/// Not movable, because the loop refers to its parts.
class Experiment {
 public:
  /// Start with the tool at rest at `start`, held by `hand`. `drilled`: the scene's solids if drilling continues, or
  /// nullptr. Throws Error: as the renderers, the loop and the drill.
  Experiment(const ServoedDevice& device, const Settings& settings, const SceneFile& scene, const Pose& start,
             const Hand& hand, RendererSlot slot, std::shared_ptr<DrilledSolids> drilled = nullptr);
  Experiment(const Experiment&) = delete;
  Experiment& operator=(const Experiment&) = delete;

  /// Run one tick. After a failure of the plant it does nothing. Realtime: yes.
  void tick() noexcept;

  /// Run one tick of two tools under one hand, the hand of `left`: the same springs pull both to the same point. Its
  /// target stays within reach of both tools. During a test push each tool has its own hand, and both pushes begin in
  /// the same tick. Realtime: yes.
  static void tickTogether(Experiment& left, Experiment& right) noexcept;

  /// Changes between ticks. select() also resets a fault of the guard. Realtime: yes.
  void select(RendererSlot slot) noexcept;
  void moveHandTo(const Vec3& target) noexcept { frame_.hand.target = target; }
  void moveHandBy(const Vec3& displacement) noexcept { frame_.hand.target += displacement; }
  void setGrip(const Grip& grip) noexcept;
  void startTestPush() noexcept;
  /// Continue to show the results of an earlier experiment.
  void keepTests(const std::array<TestPush, kMaxRenderers>& tests) noexcept { frame_.tests = tests; }
  /// Pedal of the bur, and undo of the last stroke or of all. Without a bur they do nothing.
  void spin(bool on) noexcept;
  void undo() noexcept;
  void restore() noexcept;

  /// Record every tick from now on until the experiment ends. The file is complete when the last reference to the
  /// recorder is gone. Call it between ticks. Throws Error: as Recorder. Realtime: no.
  std::shared_ptr<Recorder> recordTo(const std::string& path, RecordingHeader header);

  /// Fill in contact and drilling in the frame before the first tick. Call it on the haptic thread, because an
  /// experiment that this one replaces may still have been cutting the same solids. Realtime: yes.
  void look() noexcept;
  /// Send changes of the solids to the drawing thread. Call it once per period, with or without a tick. Realtime: yes.
  void publish() noexcept { drilledSolids_->publish(); }

  /// Return the frame of the last tick. Realtime: yes.
  const Frame& frame() const noexcept { return frame_; }

 private:
  // Presents all renderers to the loop as one.
  class Switched final : public Renderer {
   public:
    using Renderers = std::array<Renderer*, kMaxRenderers>;  // the plugin may be nullptr
    explicit Switched(const Renderers& renderers) noexcept : renderers_(renderers) {}
    void select(RendererSlot slot) noexcept;
    bool needsInertia() const noexcept override { return renderers_[selected_]->needsInertia(); }

   private:
    void prepare(double period) override;
    Status render(const TickFrame& input, TickOutput& output) noexcept override;
    void resetState() noexcept override;
    StateBlock stateBlock() noexcept override { return {&selected_, sizeof(selected_)}; }

    Renderers renderers_;
    std::uint8_t selected_ = 0;
  };

  enum class Phase : std::uint8_t { none, approach, push };

  void tickHeld() noexcept;
  bool isThere() const noexcept;
  void moveOwnHand() noexcept;
  void advanceTestPush(bool mayBegin) noexcept;
  void watchTestPush() noexcept;
  void endTestPush(FirstImpactVerdict verdict, Status status = Status::ok) noexcept;
  void fillDrillState() noexcept;

  Settings settings_;
  std::shared_ptr<const Mechanism> model_, plant_;  // model of the haptic tick, and the simulated device
  RandomStream random_;
  PositionControlRenderer servo_;
  HoldRenderer hold_;
  ImpedanceRenderer spring_;
  PassivityRenderer passive_;         // around a separate spring
  std::unique_ptr<Renderer> plugin_;  // may be nullptr
  Switched switched_;
  VirtualLoop loop_;
  std::shared_ptr<DrilledSolids> drilledSolids_;  // shared with other experiments on the scene
  std::optional<Drill> drill_;
  std::shared_ptr<Recorder> recorder_;  // may be nullptr
  std::uint64_t recorded_ = 0;          // ticks
  bool isReset_ = false;                // since the last tick
  Frame frame_;
  Phase phase_ = Phase::none;
  int phaseTicks_ = 0;
  PushSetup push_;
  SimulatedHand pusher_{push_};
  Vec6 carried_ = Vec6::Zero();  // held by the pushing hand: weight that the model does not contain, N, N m
  double testDrift_ = 0.0;       // tangential path since the push began, m
  double testDeepest_ = 0.0;     // largest depth below the surface since then, m
  ImpactMonitor impact_{kPeriod};
  Grip gripBefore_ = kFirmGrip;
  ConditionWatch conditions_;
  ReadoutFilter readouts_;
};

/// Physical limit of K_z1 for a test push (firstImpactLimit()) at a pose.
struct StiffnessLimit {
  double stiffness = 0.0;     ///< N/m
  double largestForce = 0.0;  ///< of the motors along the normal at the TCP, N
};

/// Compute the limit. `plant`: at the pose, with inertia. Realtime: yes.
StiffnessLimit stiffnessLimit(const Kinematics& plant, const JointVector& maxTorque, const Vec3& normal,
                              const Delay& delay) noexcept;

}  // namespace enamel::viewer
