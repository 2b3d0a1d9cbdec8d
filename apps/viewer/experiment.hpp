// What the viewer runs: a scene, the virtual device, two renderers to compare, and a person's hand, tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "enamel/collision/scene_file.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "hand.hpp"

namespace enamel::viewer {

/// The renderers of an A/B comparison.
enum class Wall : std::uint8_t { positionControl = 0, impedance = 1 };

/// Everything that a person can set and that needs a new experiment.
struct Settings {
  PositionControlOptions hold;
  ImpedanceOptions spring;
  double extraMass = 0.0;    ///< on the platform, which the servo does not know of, kg
  double friction = 0.0;     ///< viscous, of every joint, beyond the device file's, N m s/rad
  double toolDamping = 4.0;  ///< mechanical, of the TCP along x, y, z, beyond the device file's, N s/m
  Delay delay;               ///< ticks
  EncoderOptions encoders;
  double noise = 0.0;  ///< of the hand along the contact's normal, standard deviation, N
};

/// A device with the servo gain that was designed for it at kPeriod, and the plugin that stands for one of the walls.
struct ServoedDevice {
  TauParameters parameters;
  PositionControlRenderer::Gain gain;
  std::shared_ptr<const PluginLibrary> plugin;  ///< or nullptr
  PluginSetup pluginSetup;
};

/// The wall that a plugin stands for: the spring where it is named impedance, else the servo.
Wall wallOf(const PluginLibrary& plugin) noexcept;

inline constexpr double kPeriod = 1e-3;     // s, of the haptic loop
inline constexpr double kTestForce = 12.0;  // N, of a test push

/// What a test push measured: the first impact of a step of force on the tool at rest on the surface.
struct TestPush {
  bool valid = false;
  double stiffness = 0.0;  ///< K_z1 = F / depth, N/m
  double depth = 0.0;      ///< at the first return, m
  double force = 0.0;      ///< of the person along the normal then, N
  double preload = 0.0;    ///< before the step, N
};

/// Everything that is drawn of a tick. Plain data.
struct Frame {
  TickRecord record;
  ContactSnapshot contacts;  ///< that the renderer saw, within kContactMargin
  Hand hand;
  Wall wall = Wall::positionControl;
  bool holding = false;           ///< the servo holds, at
  Vec6 reference = Vec6::Zero();  ///< these joint angles, rad
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
             const Hand& hand, Wall wall);
  Experiment(const Experiment&) = delete;
  Experiment& operator=(const Experiment&) = delete;

  /// One tick; nothing happens once the plant has failed. Realtime: yes.
  void tick() noexcept;

  /// Changes between ticks. Realtime: yes.
  void select(Wall wall) noexcept;
  void moveHandTo(const Vec3& target) noexcept { frame_.hand.target = target; }
  void moveHandBy(const Vec3& way) noexcept { frame_.hand.target += way; }
  void setGrip(const Grip& grip) noexcept;
  void startTestPush() noexcept;

  /// The last tick's. Realtime: yes.
  const Frame& frame() const noexcept { return frame_; }

 private:
  // One renderer in front of the loop and two behind it.
  class Switched final : public Renderer {
   public:
    Switched(Renderer& servo, Renderer& spring) noexcept : renderers_{&servo, &spring} {}
    void select(Wall wall) noexcept;

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

  TauModel model_, plant_;  // what the renderers know, and what is there
  double noise_;
  RandomStream random_;
  PositionControlRenderer hold_;
  ImpedanceRenderer spring_;
  std::unique_ptr<Renderer> plugin_;  // or nullptr
  Switched switched_;
  VirtualLoop loop_;
  Frame frame_;
  Phase phase_ = Phase::none;
  int phaseTicks_ = 0, restTicks_ = 0;
  Vec3 testNormal_ = Vec3::UnitZ(), testPoint_ = Vec3::Zero();
  double lastSpeed_ = 0.0;
  TestPush test_;
  Grip gripBefore_ = kFirmGrip;
};

/// The parameters of a device with a person's changes to it.
TauParameters changed(const TauParameters& device, const Settings& settings);

/// The physical limit of K_z1 without a force sensor, N/m: 2 m (F_max - F) / (F_max - F_0) / t1^2, t1 = (d + 1) Ts,
/// with the effective mass m at the TCP along the normal, the largest normal force F_max that the motors give beyond
/// gravity, a preload F_0 and a delay of d ticks.
struct StiffnessLimit {
  double stiffness;     ///< N/m
  double mass;          ///< kg
  double largestForce;  ///< F_max, N
};
StiffnessLimit stiffnessLimit(const TauModel& model, const TauConfiguration& configuration, const Vec3& normal,
                              double force, double preload, int delay) noexcept;

}  // namespace enamel::viewer
