// What the viewer runs: a scene, the virtual device, renderers to compare, and a person's hand, tick by tick.
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
#include "servoed_device.hpp"

namespace enamel::viewer {

/// A test push is scenario 1 of runPush() with this force after this preload, from rest on the surface, N.
inline constexpr double kTestForce = 12.0, kTestPreload = 0.5;

/// What a test push measured, as `enamel push` and the study judge it. It and what it was made with stay as they are
/// until the next one.
struct TestPush {
  bool made = false;
  FirstImpactVerdict verdict = FirstImpactVerdict::noStep;  ///< noStep: there was no wall within reach
  Status status = Status::ok;  ///< or why it ended before its time: stopped by the guard; where the plant could not go
  double amount = 0.0;  ///< half the force's range where it is unstable, N; path across the wall where it slipped, m
  Settings settings;    ///< that it was made with
  double limit = 0.0;   ///< stiffnessLimit() then, N/m
  double depthStiffness = 0.0;  ///< K_d, N/m; 0: the tool did not go deeper
  // Where it is `measured`:
  double stiffness = 0.0;  ///< K_z1, N/m
  double depth = 0.0;      ///< D_z1, m
  double force = 0.0;      ///< F_1, beyond the preload, N
  double preload = 0.0;    ///< before the step, N
};

/// Everything that is drawn of a tick. Plain data.
struct Frame {
  TickRecord record;
  ContactSnapshot contacts;  ///< that the renderer saw, within kContactMargin
  Hand hand;
  RendererSlot selected = RendererSlot::positionControl;
  PositionControlState control;  ///< of position control
  bool holding = false;          ///< the renderer hold keeps the tool at
  JointVector reference;         ///< these joint coordinates, rad or m
  bool testing = false;          ///< a test push is under way
  Conditions conditions;
  std::array<std::uint64_t, kGuardReasons> guardTicks{};  ///< of this experiment, by GuardReason
  DrillState drilled;                                     ///< where the scene has a bur
  std::array<TestPush, kMaxRenderers> tests;              ///< the last of each renderer
  Status plant = Status::ok;                              ///< any other: the loop stands still until it is replaced
  // Filled by the runner:
  bool paused = false;
  int slowdown = 1;
  std::uint64_t droppedSamples = 0;
};

/// Not movable: the loop refers to its parts.
class Experiment {
 public:
  /// The tool begins at rest at `start`, held by `hand`. `drilled`: of the scene, where it goes on being drilled, or
  /// nullptr. Throws Error: as the renderers, the loop and the drill do.
  Experiment(const ServoedDevice& device, const Settings& settings, const SceneFile& scene, const Pose& start,
             const Hand& hand, RendererSlot slot, std::shared_ptr<DrilledSolids> drilled = nullptr);
  Experiment(const Experiment&) = delete;
  Experiment& operator=(const Experiment&) = delete;

  /// One tick; nothing happens once the plant has failed. Realtime: yes.
  void tick() noexcept;

  /// One tick of two under one hand, that of `left`, whose target stays within reach of both tools: the same springs to
  /// the same point. In a test push each has a hand of its own, and both pushes begin in the same tick. Realtime: yes.
  static void tickTogether(Experiment& left, Experiment& right) noexcept;

  /// Changes between ticks; select() also goes on after the guard has stopped. Realtime: yes.
  void select(RendererSlot slot) noexcept;
  void moveHandTo(const Vec3& target) noexcept { frame_.hand.target = target; }
  void moveHandBy(const Vec3& displacement) noexcept { frame_.hand.target += displacement; }
  void setGrip(const Grip& grip) noexcept;
  void startTestPush() noexcept;
  /// Results of an experiment before, which are shown on.
  void keepTests(const std::array<TestPush, kMaxRenderers>& tests) noexcept { frame_.tests = tests; }
  /// Of the bur: its pedal; takes back the last stroke, or all. Without one nothing happens.
  void spin(bool on) noexcept;
  void undo() noexcept;
  void restore() noexcept;

  /// Records every tick from now on, to the experiment's end: the file is whole once nobody holds the recorder.
  /// Between ticks; throws Error: as Recorder. Realtime: no.
  std::shared_ptr<Recorder> recordTo(const std::string& path, RecordingHeader header);

  /// Fills in what a frame before the first tick says of contact and drilling. Of the thread that ticks: an experiment
  /// that this one replaces may have been cutting the same solids. Realtime: yes.
  void look() noexcept;
  /// Once a period, whether it ticked or not: what has changed of the solids, to the thread that draws. Realtime: yes.
  void publish() noexcept { drilledSolids_->publish(); }

  /// The last tick's. Realtime: yes.
  const Frame& frame() const noexcept { return frame_; }

 private:
  // One renderer in front of the loop and all behind it.
  class Switched final : public Renderer {
   public:
    using Renderers = std::array<Renderer*, kMaxRenderers>;  // of the plugin: or nullptr
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
  std::shared_ptr<const Mechanism> model_, plant_;  // what the haptic tick knows, and what is there
  RandomStream random_;
  PositionControlRenderer servo_;
  HoldRenderer hold_;
  ImpedanceRenderer spring_;
  PassivityRenderer passive_;         // around a spring of its own
  std::unique_ptr<Renderer> plugin_;  // or nullptr
  Switched switched_;
  VirtualLoop loop_;
  std::shared_ptr<DrilledSolids> drilledSolids_;  // which other experiments on the scene may have too
  std::optional<Drill> drill_;
  std::shared_ptr<Recorder> recorder_;  // or nullptr
  std::uint64_t recorded_ = 0;          // ticks
  bool isReset_ = false;                // since the last tick
  Frame frame_;
  Phase phase_ = Phase::none;
  int phaseTicks_ = 0;
  PushSetup push_;
  SimulatedHand pusher_{push_};
  Vec6 carried_ = Vec6::Zero();  // by the hand that pushes: the weight that the model does not know, N, N m
  double testDrift_ = 0.0;       // across the normal since the push began, m
  ImpactMonitor impact_{kPeriod};
  Grip gripBefore_ = kFirmGrip;
  ConditionWatch conditions_;
};

/// The physical limit of K_z1 for a test push (firstImpactLimit()) at a pose.
struct StiffnessLimit {
  double stiffness = 0.0;     ///< N/m
  double largestForce = 0.0;  ///< of the motors along the normal at the TCP, N
};

/// `plant` at the pose, with its inertia. Realtime: yes.
StiffnessLimit stiffnessLimit(const Kinematics& plant, const JointVector& maxTorque, const Vec3& normal,
                              const Delay& delay) noexcept;

}  // namespace enamel::viewer
