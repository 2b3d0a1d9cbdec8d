// The viewer between a surface, an experiment and a person.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bur_view.hpp"
#include "camera.hpp"
#include "canvas.hpp"
#include "charts.hpp"
#include "data_folder.hpp"
#include "display_history.hpp"
#include "input.hpp"
#include "options.hpp"
#include "overlay_input.hpp"
#include "player.hpp"
#include "runner.hpp"
#include "scan.hpp"
#include "scene_view.hpp"
#include "script.hpp"
#include "surface.hpp"
#include "tour.hpp"

namespace enamel::viewer {

/// The viewer without the loop that drives it: see run.hpp.
class Viewer final : public InputTarget {
 public:
  /// Load scene and device, design the servo and build the picture, or open the recording. Throws Error.
  Viewer(const Options& options, Surface& surface);

  Runner* runner() { return runner_.get(); }  ///< nullptr if a recording is played or a device is connected
  LiveDevice* live() { return live_.get(); }  ///< nullptr if no device is connected
  Canvas& canvas() { return canvas_; }
  const Frame& frame() const { return left_.frame; }
  Camera& camera() override { return camera_.camera(); }
  const Layout& layout() const override { return layout_; }
  glm::dvec3 tool() const override;
  glm::dvec3 axis() const override;
  glm::dvec3 normal() const override;
  bool wantsToEnd() const { return end_; }
  bool fullScreen() const { return fullScreen_; }
  /// Return whether a clip is requested. The loop that drives the viewer makes it and reports its start time.
  bool wantsClip() const { return wantsClip_; }
  /// Return a dropped file that another viewer must show: a recording, or a scene or scan in place of a recording.
  const std::string& wantsToOpen() const { return open_; }
  void endClip() { wantsClip_ = false; }
  void showClip(double seconds) { clip_ = seconds; }
  /// End a running recording. Return its result as a sentence, or an empty text.
  std::string endRecording();
  /// Show a notice for a while.
  void notify(const std::string& text);
  const DisplayHistory& history() const { return history_; }
  const std::vector<std::string>& sceneNames() const { return scenes_.names(); }
  const OverlayState& overlay() const { return overlay_; }
  bool isInContact() const { return frame().record.nearest.gap < 0.0 || frame().record.mode == RenderMode::contact; }
  bool isTouring() const { return motion_.isTouring(); }
  bool canTour() const;
  const std::vector<std::string>& rendererNames() const { return rendererNames_; }
  /// Return the names of pictures requested since the last call; an empty name means the next free one.
  std::vector<std::string> takePictures();

  void act(Action action) override;
  void moveHandBy(const glm::dvec3& millimetres) override;
  void pressBy(double newtons) override;
  void spin(bool on) override;
  void seek(double share) override;
  /// Handle files dropped on the window: show the first scene or scan among them, and add it to the list of scenes.
  void drop(const std::vector<std::string>& paths) override;
  /// Perform one step of a script at `now`, s.
  void follow(const ScriptStep& step, double now);

  /// Take the data of the haptic side and prepare the next picture; `now`: s.
  void update(double now, const TimingNumbers& timing);
  /// Draw the prepared picture; `picture`: antialiased for reading it back.
  void draw(bool picture);

 private:
  // A tool in its pane: the whole scene, or a side of the split screen.
  struct Pane {
    Frame frame;
    Kinematics kinematics;  // of the plant, with inertia
    SceneState shown;
    std::optional<SceneView> view;  // right pane: exists since the first split screen
  };

  // Selected renderers.
  struct Choice {
    explicit Choice(RendererSlot first)
        : begin(first),
          selected(first),
          before(first == RendererSlot::impedance ? RendererSlot::positionControl : RendererSlot::impedance),
          right(before) {}
    RendererSlot begin;             // renderer at the start
    RendererSlot selected, before;  // for Tab
    RendererSlot right;             // of the right tool in the split screen
  };

  // A recording of one experiment, with which it ends, or of a connected device.
  struct Recording {
    std::shared_ptr<Recorder> recorder;  // recorder of the experiment, or nullptr
    std::string path;                    // empty: no recording runs
    double begin = 0.0;                  // in time of simulated_, s
  };

  // viewer_actions.cpp
  bool isRefused(Source source);
  bool actOnRecording(Action action);
  bool actOnTool(Action action);
  bool actOnTime(Action action);
  void actOnView(Action action);
  void send(RunnerCommand::Kind kind, int number = 0);
  void sendHand(RunnerCommand::Kind kind, const Vec3& target);
  void takeHand();
  void select(RendererSlot slot);
  void selectRight(RendererSlot slot);
  void toggleSplit();
  void startTour();
  void endTour(bool skipped);
  void setSlowdown(int factor);
  void undo();
  void saveSolids();
  void cutOpen();
  void resetAll();
  void closeTop();
  void pressWith(double newtons);
  void toggleRecording();
  void recordDevice();
  bool records() const { return !recording_.path.empty(); }
  bool actOnScan(Action action);
  bool canOpen(const std::string& path);

  // viewer.cpp
  bool loadScene(const std::string& path, const ScanPlacement& placement = {});
  void rebuild(const Pose& start, const Hand& hand, bool keepTests, const std::string& record = {});
  void startAgain(bool keepTests = false);
  void takeRun();
  void takeSolids();
  void takeRecording(double passed);
  void takeDevice();
  void takeRequests();
  void fillShown(Pane& pane) const;
  void placeCharts();
  void noteShown();
  void drawPane(Pane& pane, double aspect);
  OverlayInput overlayInput() const;

  bool isHeadless_;
  Surface& surface_;
  std::unique_ptr<Player> player_;    // may be nullptr
  std::unique_ptr<LiveDevice> live_;  // may be nullptr
  ServoedDevice device_;
  std::vector<std::string> rendererNames_;
  std::shared_ptr<const Mechanism> plant_;  // with the person's changes
  TorqueStyle torques_;
  std::string folder_;  // for recordings
  OverlayState overlay_;
  std::string scenePath_;    // of the shown scene, or of its scan
  ScanPlacement placement_;  // of the scan
  std::string sceneText_;    // of the scene file; empty for a recording and a connected device
  std::string open_;
  SceneFile scene_;
  SceneList scenes_;  // shipped scenes and the person's own
  Choice renderers_;
  std::shared_ptr<DrilledSolids> drilledSolids_;
  std::vector<SolidCopy> solids_;  // by obstacle
  std::optional<CutPlane> plane_;
  bool spins_ = false;
  BurView bur_;
  std::unique_ptr<Runner> runner_;  // null if there is a player or a connected device
  Recording recording_;
  Canvas canvas_;
  Pane left_, right_;
  bool split_ = false;
  Charts charts_;
  CameraControl camera_;
  HandMotion motion_;
  float builtScale_ = 0.0f;
  Layout layout_;
  Comparison comparison_;
  std::vector<Vec3> trail_;
  StiffnessLimit limit_{};
  TimingNumbers timing_;
  double simulated_ = 0.0, now_ = 0.0, updated_ = 0.0, noticeEnd_ = 0.0;  // s
  bool paused_ = false, end_ = false, fullScreen_ = false;
  int slowdown_ = 1;
  bool wantsClip_ = false;
  double clip_ = -1.0;                     // s
  GuardReason fault_ = GuardReason::none;  // of a connected device, as notified
  std::vector<std::string> pictures_;
  DisplayHistory history_;
};

}  // namespace enamel::viewer
