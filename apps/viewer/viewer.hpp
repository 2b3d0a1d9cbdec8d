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
#include "scene_view.hpp"
#include "script.hpp"
#include "surface.hpp"
#include "tour.hpp"

namespace enamel::viewer {

/// Everything but the loop that drives it: see run.hpp.
class Viewer final : public InputTarget {
 public:
  /// Loads scene and device, designs the servo, builds the picture; or opens the recording. Throws Error.
  Viewer(const Options& options, Surface& surface);

  Runner* runner() { return runner_.get(); }  ///< nullptr: a recording is played
  Canvas& canvas() { return canvas_; }
  const Frame& frame() const { return left_.frame; }
  Camera& camera() override { return camera_.camera(); }
  const Layout& layout() const override { return layout_; }
  glm::dvec3 tool() const override;
  glm::dvec3 normal() const override;
  bool wantsToEnd() const { return end_; }
  bool fullScreen() const { return fullScreen_; }
  /// A clip is wanted; the loop that drives the viewer makes it, and says since when.
  bool wantsClip() const { return wantsClip_; }
  void endClip() { wantsClip_ = false; }
  void showClip(double seconds) { clip_ = seconds; }
  /// Ends a recording that is under way: what came of it, in a sentence; or nothing.
  std::string endRecording();
  /// A word for a while.
  void notify(const std::string& text);
  const DisplayHistory& history() const { return history_; }
  const std::vector<std::string>& sceneNames() const { return scenes_.names(); }
  const OverlayState& overlay() const { return overlay_; }
  bool isInContact() const { return frame().record.nearest.gap < 0.0 || frame().record.mode == RenderMode::contact; }
  bool isTouring() const { return motion_.isTouring(); }
  bool canTour() const;
  const std::vector<std::string>& rendererNames() const { return rendererNames_; }
  /// Names of pictures that were asked for since the last call; an empty name stands for the next free one.
  std::vector<std::string> takePictures();

  void act(Action action) override;
  void moveHandBy(const glm::dvec3& millimetres) override;
  void pressBy(double newtons) override;
  void spin(bool on) override;
  void seek(double share) override;
  /// Files dropped on the window: the first scene or scan among them is shown and joins the list of scenes.
  void drop(const std::vector<std::string>& paths) override;
  /// One step of a script, at `now`, s.
  void follow(const ScriptStep& step, double now);

  /// Takes what the haptic side has sent and prepares the next picture; `now` in s.
  void update(double now, const TimingNumbers& timing);
  /// Draws it; a `picture` to be read has smooth edges.
  void draw(bool picture);

 private:
  // A tool in its pane: of the whole scene, or of the split screen.
  struct Pane {
    Frame frame;
    Kinematics kinematics;  // of the plant, with inertia
    SceneState shown;
    std::optional<SceneView> view;  // of the right one: since the first split screen
  };

  // Which renderers are chosen.
  struct Choice {
    explicit Choice(RendererSlot first)
        : begin(first),
          selected(first),
          before(first == RendererSlot::impedance ? RendererSlot::positionControl : RendererSlot::impedance),
          right(before) {}
    RendererSlot begin;             // with which the person began
    RendererSlot selected, before;  // for Tab
    RendererSlot right;             // of the split screen's right tool
  };

  // Of the ticks of one experiment, with which it ends.
  struct Recording {
    std::shared_ptr<Recorder> recorder;  // that the experiment feeds, or nullptr
    std::string path;
    double begin = 0.0;  // of simulated_, s
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
  void cutOpen();
  void resetAll();
  void toggleRecording();

  // viewer.cpp
  bool loadScene(const std::string& path);
  void rebuild(const Pose& start, const Hand& hand, bool keepTests, const std::string& record = {});
  void startAgain(bool keepTests = false);
  void takeRun();
  void takeSolids();
  void takeRecording(double passed);
  void takeRequests();
  void fillShown(Pane& pane) const;
  void placeCharts();
  void noteShown();
  void drawPane(Pane& pane, double aspect);
  OverlayInput overlayInput() const;

  bool isHeadless_;
  Surface& surface_;
  std::unique_ptr<Player> player_;  // or nullptr
  ServoedDevice device_;
  std::vector<std::string> rendererNames_;
  std::shared_ptr<const Mechanism> plant_;  // with the person's changes
  TorqueStyle torques_;
  std::string folder_;     // for recordings
  std::string scenePath_;  // of what is shown
  SceneFile scene_;
  SceneList scenes_;  // the shipped ones, and the person's own
  OverlayState overlay_;
  Choice renderers_;
  std::shared_ptr<DrilledSolids> drilledSolids_;
  std::vector<SolidCopy> solids_;  // by obstacle
  std::optional<CutPlane> plane_;
  bool spins_ = false;
  BurView bur_;
  std::unique_ptr<Runner> runner_;  // where there is no player
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
  double clip_ = -1.0;  // s
  std::vector<std::string> pictures_;
  DisplayHistory history_;
};

}  // namespace enamel::viewer
