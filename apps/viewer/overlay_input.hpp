// What the overlay shows, and what a person changes in it.
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
#include "player.hpp"
#include "torque_style.hpp"

namespace enamel::viewer {

/// What buttons, sliders and lists have asked for since the viewer last looked.
struct OverlayRequests {
  std::vector<Action> actions;
  std::optional<std::size_t> scene;  ///< of SceneInput::names
  std::optional<RendererSlot> renderer, right;
  std::optional<bool> spin;  ///< of the bur
  bool settings = false;     ///< OverlayState::settings have changed
  std::string problem;       ///< with what was typed, to be told, or empty
};

/// What the overlay shows and, of the settings, changes.
struct OverlayState {
  bool panels = true, charts = true, help = false, timing = false;
  Settings settings;
  Grip grip = kFirmGrip;
  bool sound = false;                   ///< is wanted
  std::string soundTrouble;             ///< why there is no sound all the same, or empty
  std::string notice;                   ///< for a while
  std::vector<std::string> sceneNotes;  ///< of its meshes
  OverlayRequests asked;
  struct Typing {
    std::string name;  ///< of the slider whose value is being typed, or empty
    std::array<char, 24> text{};
  } typing;
  struct Tip {
    std::string text;  ///< of what the mouse is on, or empty
    double since = 0;  ///< ImGui's time
    bool seen = false;
  } tip;
  struct Zoom {
    int step = 4;  ///< of the magnification, with hysteresis
    int patience = 0;
  } zoom;
  std::map<std::string, glm::vec2> controls;  ///< where they stand, pixels: for the report
};

/// Timing as numbers.
struct TimingNumbers {
  bool available = false;  ///< no haptic thread in simulated time
  bool realtime = false;
  double wakeMedian = 0, wakeHigh = 0, computeMedian = 0, computeHigh = 0, computeLargest = 0;  ///< s; high: p99.9
  unsigned long long periods = 0, missed = 0;
  double framesPerSecond = 0;
  /// Shares of all ticks, in classes of a quarter octave from kShortest up: from one tick's begin to the next one's,
  /// and of its computation.
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
  const PluginLibrary* plugin;  ///< or nullptr
};

struct SceneInput {
  const std::string& name;
  const std::vector<std::string>& names;  ///< to choose from
  std::size_t index;
  double toolRadius;  ///< of the tool's first part, m; 0: a point
  bool isCutOpen;
};

struct BurInput {
  const Bur& bur;
  const std::vector<SolidLayer>& layers;
  double depth;  ///< of its tip's lowest point below the uncut surface, m
};

/// Seconds of simulated time; since a tour, a recording and (of its pictures) a clip began (negative: it has not).
struct ElapsedInput {
  double simulated, tour, recording, clip;
};

struct OverlayInput {
  ToolInput left;
  std::optional<ToolInput> right;  ///< of the split screen
  const Player* player;            ///< the frame's source, or nullptr: a live run
  DeviceInput device;
  SceneInput scene;
  std::optional<BurInput> bur;     ///< of a live run's tool
  const std::vector<Vec3>& trail;  ///< last positions of the TCP, oldest first, m
  const Comparison& comparison;
  const Camera& camera;
  const char* cameraName;
  TimingNumbers timing;
  ElapsedInput elapsed;
};

}  // namespace enamel::viewer
