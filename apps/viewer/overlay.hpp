// What Dear ImGui draws over the scene: panels, numbers, the magnified contact, the gauge of stiffness, help.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

#include "actions.hpp"
#include "camera.hpp"
#include "charts.hpp"
#include "experiment.hpp"
#include "layout.hpp"
#include "player.hpp"

namespace enamel::viewer {

/// What the overlay shows and, of the settings, changes.
struct OverlayState {
  bool panels = true, charts = true, help = false, timing = false;
  Settings settings;
  Grip grip = kFirmGrip;
  std::string notice;  ///< for a while
  bool settingsChanged = false;
  std::vector<Action> actions;  ///< asked for by buttons
  int sceneAsked = -1, rendererAsked = -1, rightAsked = -1;
  std::optional<bool> spinAsked;        ///< of the bur
  bool sound = false;                   ///< is wanted
  std::string soundTrouble;             ///< why there is none all the same, or empty
  std::vector<std::string> sceneNotes;  ///< of its meshes
  std::string problem;                  ///< with what was typed, to be told, or empty
  std::string typedInto;                ///< the slider whose value is being typed, or empty, and:
  std::array<char, 24> typed{};
  std::string tip;      ///< of what the mouse is on, or empty
  double tipSince = 0;  ///< ImGui's time
  bool tipSeen = false;
  std::map<std::string, glm::vec2> controls;  ///< where they stand, pixels: for the report
  int insetStep = 4;                          ///< of the magnification, with hysteresis
  int insetPatience = 0;
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

struct OverlayInput {
  const Frame& frame;
  const Player* player;  ///< the frame's source, or nullptr: a live run
  const std::string& sceneName;
  const std::string& deviceName;
  const PluginLibrary* plugin;         ///< or nullptr
  const SurfaceServoOptions* surface;  ///< that a file gave, or nullptr
  const TorqueStyle& torques;
  const std::vector<std::string>& scenes;  ///< names to choose from
  int sceneIndex;
  StiffnessLimit limit;  ///< for a test push at this pose
  double toolRadius;     ///< of the tool's first part, m; 0: a point
  bool ghost;
  Vec3 ghostPosition;              ///< TCP of the reference pose, m
  const std::vector<Vec3>& trail;  ///< last positions of the TCP, oldest first, m
  TimingNumbers timing;
  double simulated;  ///< s
  const char* cameraName;
  const Bur* bur;  ///< of a live run's tool, or nullptr; then also:
  const std::vector<SolidLayer>* layers;
  double burDepth;  ///< of its tip's lowest point below the uncut surface, m
  bool isCutOpen;
  const Frame* right;  ///< of the split screen's right tool, or nullptr: none; then also:
  bool rightGhost;
  Vec3 rightGhostPosition;
  const Comparison& comparison;
  const Camera& camera;
  double tour;       ///< s since a tour began; negative: there is none
  double recording;  ///< likewise, of simulated time
  double clip;       ///< likewise, of a clip's pictures
};

/// Loads the font at a scale; call again when the scale changes. `font`: a TrueType file, or empty for the built-in.
void setUpOverlay(const std::string& font, const std::string& boldFont, float scale);

/// Draws everything into the current ImGui frame.
void drawOverlay(const Layout& layout, const OverlayInput& input, OverlayState& state);

/// What is wrong, in the order of their pills.
std::array<std::pair<bool, const char*>, 4> badgesOf(const Frame& frame);

/// A stiffness as people read it: "27.1 kN/m". What a test push gave: that, or why there is none.
std::string stiffnessText(double stiffness);
std::string shownText(const TestPush& test);

}  // namespace enamel::viewer
