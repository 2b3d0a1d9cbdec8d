// Inputs of the overlay, and changes that a person makes in it.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "actions.hpp"
#include "camera.hpp"
#include "compare.hpp"
#include "experiment.hpp"
#include "layout.hpp"
#include "live_device.hpp"
#include "player.hpp"
#include "torque_style.hpp"

namespace enamel::viewer {

/// Requests of buttons, sliders and lists since the viewer last took them.
struct OverlayRequests {
  std::vector<Action> actions;
  std::optional<std::size_t> scene;  ///< index in SceneInput::names
  std::optional<RendererSlot> renderer, right;
  std::optional<bool> spin;     ///< switch the bur
  std::optional<double> press;  ///< force of the hand into the wall, N
  bool settings = false;        ///< OverlayState::settings have changed
  std::string problem;          ///< problem with a typed value, to be shown; or empty
};

/// State of the overlay, and the settings that it changes.
struct OverlayState {
  bool panels = true, charts = true, help = false, timing = false;

  bool list = false;  ///< the list of scenes is unfolded; false folds it
  Settings settings;
  Grip grip = kFirmGrip;
  bool sound = false;                   ///< sound is requested
  std::string soundTrouble;             ///< why nothing is heard nevertheless, or empty
  std::string notice;                   ///< shown for a while
  std::string scanNote;                 ///< about the scan of the scene; empty: no scan
  std::vector<std::string> sceneNotes;  ///< about the scene's meshes
  OverlayRequests asked;
  struct Typing {
    std::string name;  ///< slider whose value is being typed, or empty
    std::array<char, 24> text{};
  } typing;
  struct Tip {
    std::string text;  ///< tip for the item under the mouse, or empty
    double since = 0;  ///< time of ImGui
    bool seen = false;
  } tip;
  struct Zoom {
    int step = 4;  ///< magnification, with hysteresis
    int patience = 0;
  } zoom;
  std::vector<std::string> readouts;          ///< texts of the read-outs in this picture, for the report
  std::map<std::string, glm::vec2> controls;  ///< positions in pixels, for the report
};

/// Timing as numbers.
struct TimingNumbers {
  bool available = false;  ///< false in simulated time, which has no haptic thread
  bool realtime = false;
  double wakeMedian = 0, wakeHigh = 0, computeMedian = 0, computeHigh = 0, computeLargest = 0;  ///< s; high: p99.9
  unsigned long long periods = 0, missed = 0;
  double framesPerSecond = 0;
  /// Shares of all ticks in classes of a quarter octave from kShortest up: interval between the starts of ticks, and
  /// time of their computation.
  static constexpr std::size_t kClasses = 54;
  static constexpr double kShortest = 1e-6;  // s
  std::array<float, kClasses> interval{}, compute{};
};

/// A tool that is shown.
struct ToolInput {
  const Frame& frame;
  std::optional<Vec3> ghost;  ///< TCP of the reference pose, m
};

struct DeviceInput {
  const std::string& name;
  const TorqueStyle& torques;
  StiffnessLimit limit;         ///< for a test push at this pose
  const PluginLibrary* plugin;  ///< may be nullptr
};

struct SceneInput {
  const std::string& name;
  const std::vector<std::string>& names;  ///< scenes to choose from
  std::size_t index;
  double toolRadius;  ///< radius of the tool's first part, m; 0: a point
  bool isCutOpen;
};

struct BurInput {
  const Bur& bur;
  const std::vector<SolidLayer>& layers;
  double depth;  ///< depth of its tip's lowest point below the uncut surface, m
};

/// Seconds of simulated time; then seconds since the start of the tour, the recording and the clip (negative: none).
struct ElapsedInput {
  double simulated, tour, recording, clip;
};

struct OverlayInput {
  ToolInput left;
  std::optional<ToolInput> right;  ///< in the split screen
  const Player* player;            ///< source of the frame; nullptr: no recording
  const LiveDevice* live;          ///< source of the frame; nullptr: no connected device
  DeviceInput device;
  SceneInput scene;
  std::optional<BurInput> bur;     ///< the tool of a live run
  const std::vector<Vec3>& trail;  ///< last positions of the TCP, oldest first, m
  const Comparison& comparison;
  const Camera& camera;
  int view;  ///< CameraControl::view()
  TimingNumbers timing;
  ElapsedInput elapsed;

  /// Return whether the force of the hand is known: only in a simulation.
  bool knowsHand() const { return player == nullptr && live == nullptr; }
  /// Return whether the read-outs belong to one tick, because a person can follow single ticks.
  bool showsTick() const { return left.frame.paused || left.frame.slowdown > 1; }
};

}  // namespace enamel::viewer
