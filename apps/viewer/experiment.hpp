// What the viewer runs: a scene, the virtual device, two renderers to compare, and a person's hand, tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "enamel/collision/scene_file.hpp"
#include "enamel/control/first_impact.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "hand.hpp"

namespace enamel::viewer {

/// Which of the two renderers of an A/B comparison: A is the linked position control and B the linked spring, but where
/// a plugin stands.
enum class RendererSlot : std::uint8_t { a = 0, b = 1 };

constexpr std::size_t indexOf(RendererSlot slot) noexcept { return static_cast<std::size_t>(slot); }

/// Everything that a person can set and that needs a new experiment.
struct Settings {
  PositionControlOptions servo;
  ImpedanceOptions spring;
  double extraMass = 0.0;    ///< on the platform, which the servo does not know of, kg
  double friction = 0.0;     ///< viscous, of every joint, beyond the device file's, N m s/rad
  double toolDamping = 4.0;  ///< mechanical, of the TCP along x, y, z, beyond the device file's, N s/m
  Delay delay;               ///< ticks
  EncoderOptions encoders;
  double noise = 0.0;  ///< of the hand along the contact's normal, standard deviation, N
};

/// A device with the gain of its position servo for kPeriod, and the plugin that stands in one of the slots.
struct ServoedDevice {
  DeviceParameters parameters;
  ServoGain gain;
  std::shared_ptr<const PluginLibrary> plugin;  ///< or nullptr
  PluginSetup pluginSetup;
};

/// Names of the renderers, slot by slot, as `--renderer` and scripts call them: the linked ones' or the plugin's own.
/// A plugin takes the place of the linked renderer of its name, else of A. `plugin`: or nullptr. Realtime: no.
std::array<std::string, 2> rendererNames(const PluginLibrary* plugin);
RendererSlot slotOf(const PluginLibrary& plugin) noexcept;

inline constexpr double kPeriod = 1e-3;     // s, of the haptic loop
inline constexpr double kTestForce = 12.0;  // N, of a test push's step

/// What a test push measured (ImpactWatch): a step of kTestForce on the tool at rest on the surface.
struct TestPush {
  bool made = false;
  FirstImpactVerdict verdict = FirstImpactVerdict::noStep;  ///< noStep: the tool did not come to rest on a wall
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
  RendererSlot selected = RendererSlot::a;
  bool holding = false;           ///< the linked servo holds, at
  JointVector reference;          ///< these joint coordinates, rad or m
  bool testing = false;           ///< a test push is under way
  std::array<TestPush, 2> tests;  ///< the last of each renderer
  Status plant = Status::ok;      ///< any other: the loop stands still until it is replaced
  // Filled by the runner:
  bool paused = false;
  int slowdown = 1;
  std::uint64_t droppedSamples = 0;
};

/// Not movable: the loop refers to its parts.
class Experiment {
 public:
  /// The tool begins at rest at `start`, held by `hand`. Throws Error: as the renderers and the loop do.
  Experiment(const ServoedDevice& device, const Settings& settings, const SceneFile& scene, const Pose& start,
             const Hand& hand, RendererSlot slot);
  Experiment(const Experiment&) = delete;
  Experiment& operator=(const Experiment&) = delete;

  /// One tick; nothing happens once the plant has failed. Realtime: yes.
  void tick() noexcept;

  /// Changes between ticks. Realtime: yes.
  void select(RendererSlot slot) noexcept;
  void moveHandTo(const Vec3& target) noexcept { frame_.hand.target = target; }
  void moveHandBy(const Vec3& displacement) noexcept { frame_.hand.target += displacement; }
  void setGrip(const Grip& grip) noexcept;
  void startTestPush() noexcept;

  /// The last tick's. Realtime: yes.
  const Frame& frame() const noexcept { return frame_; }

 private:
  // One renderer in front of the loop and two behind it.
  class Switched final : public Renderer {
   public:
    Switched(Renderer& a, Renderer& b) noexcept : renderers_{&a, &b} {}
    void select(RendererSlot slot) noexcept;
    bool needsInertia() const noexcept override { return renderers_[selected_]->needsInertia(); }

   private:
    void prepare(double period) override;
    Status render(const TickInput& input, TickOutput& output) noexcept override;
    void resetState() noexcept override;
    StateBlock stateBlock() noexcept override { return {&selected_, sizeof(selected_)}; }

    std::array<Renderer*, 2> renderers_;
    std::uint8_t selected_ = 0;
  };

  enum class Phase : std::uint8_t { none, approach, push };

  void advanceTestPush() noexcept;
  void watchTestPush() noexcept;
  void endTestPush(FirstImpactVerdict verdict) noexcept;

  std::shared_ptr<const Mechanism> model_, plant_;  // what the haptic tick knows, and what is there
  double noise_;
  RandomStream random_;
  PositionControlRenderer servo_;
  ImpedanceRenderer spring_;
  std::unique_ptr<Renderer> plugin_;  // or nullptr
  Switched switched_;
  VirtualLoop loop_;
  Frame frame_;
  Phase phase_ = Phase::none;
  int phaseTicks_ = 0, restTicks_ = 0;
  Vec3 testNormal_ = Vec3::UnitZ(), testPoint_ = Vec3::Zero();
  Vec3 testStart_ = Vec3::Zero();  // of the TCP at the step
  double testDrift_ = 0.0;         // across the normal since then
  ImpactWatch impact_{kPeriod};
  Grip gripBefore_ = kFirmGrip;
};

/// The parameters of a device with a person's changes to it.
DeviceParameters changed(DeviceParameters device, const Settings& settings);

/// The physical limit of K_z1 for a test push (firstImpactLimit()) at a pose.
struct StiffnessLimit {
  double stiffness = 0.0;     ///< N/m
  double largestForce = 0.0;  ///< of the motors along the normal at the TCP, N
};

/// `plant` at the pose, with its inertia. Realtime: yes.
StiffnessLimit stiffnessLimit(const Kinematics& plant, const JointVector& maxTorque, const Vec3& normal, double preload,
                              const Delay& delay) noexcept;

}  // namespace enamel::viewer
