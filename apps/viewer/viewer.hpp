// The viewer between a surface, an experiment and a person.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera.hpp"
#include "charts.hpp"
#include "input.hpp"
#include "overlay.hpp"
#include "player.hpp"
#include "runner.hpp"
#include "scene_view.hpp"
#include "script.hpp"
#include "seen.hpp"
#include "servo_gain.hpp"
#include "sound_output.hpp"
#include "stage.hpp"
#include "surface.hpp"
#include "tour.hpp"

namespace enamel::viewer {

/// What the command line says.
struct Options {
  std::string play;  ///< recording; or empty, then:
  std::string scene, device;
  std::string gain;  ///< file, or empty: loadServoedDevice()
  RendererSlot begin = RendererSlot::positionControl;
  std::shared_ptr<const PluginLibrary> plugin;  ///< or nullptr
  std::map<std::string, std::string> pluginParameters;
  bool headless = false;
  std::string script, record, report;
  glm::ivec2 size{1280, 720};
  float scale = 1.0f;
  double frameRate = 60.0;  ///< of the window, 1/s, at most
  bool fixedStep = false;   ///< of the window: each picture takes 1 / frameRate of the script's time
};

/// Everything but the loop that drives it: see runInWindow() and runHeadless().
class Viewer final : public Driven {
 public:
  /// Loads scene and device, designs the servo, builds the picture; or opens the recording. Throws Error.
  Viewer(const Options& options, Surface& surface);

  Runner* runner() { return runner_.get(); }  ///< nullptr: a recording is played
  Stage& stage() { return stage_; }
  const Frame& frame() const { return frame_; }
  Camera& camera() override { return camera_; }
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
  const Seen& seen() const { return seen_; }
  const std::vector<std::string>& sceneNames() const { return sceneNames_; }
  const OverlayState& overlay() const { return overlay_; }
  bool isInContact() const { return frame_.record.nearest.gap < 0.0 || frame_.record.mode == RenderMode::contact; }
  bool isTouring() const { return tour_.has_value(); }
  bool canTour() const;
  const std::vector<std::string>& rendererNames() const { return rendererNames_; }
  /// Names of pictures that were asked for since the last call; an empty name stands for the next free one.
  std::vector<std::string> takePictures();

  void act(Action action) override;
  void moveHandBy(const glm::dvec3& millimetres) override;
  void pressBy(double newtons) override;
  void spin(bool on) override;
  void seek(double share) override;
  /// Files dropped on the window: scenes and scans, which join the list of scenes; the first one is shown.
  void drop(const std::vector<std::string>& paths) override;
  /// One step of a script, at `now`, s.
  void follow(const ScriptStep& step, double now);

  /// Takes what the haptic side has sent and prepares the next picture; `now` in s.
  void update(double now, const TimingNumbers& timing);
  /// Draws it; a `picture` to be read has smooth edges.
  void draw(bool picture);

 private:
  bool isRefused(Source source);
  bool actOnRecording(Action action);
  void takeRun();
  void takeRecording(double passed);
  void send(RunnerCommand::Kind kind, int number);
  bool loadScene(const std::string& path);
  void addScene(const std::string& path);
  void resetAll();
  void rebuild(const Pose& start, const Hand& hand, bool keepTests, const std::string& record = {});
  void startAgain(bool keepTests = false);
  void toggleRecording();
  void select(RendererSlot slot);
  void selectRight(RendererSlot slot);
  void toggleSplit();
  void startTour();
  void endTour(bool skipped);
  void fillShown(const Frame& frame, Kinematics& kinematics, SceneState& shown) const;
  void takeChanges();
  void takeCut();
  void cutOpen();
  double uncutDistance(const Vec3& point) const;
  Vec3 burTip() const;
  double burDepth() const;
  const std::vector<SolidLayer>* layers() const;
  void selectCamera(int preset);
  void followContact(double passed);
  void watch();

  bool isHeadless_;
  Surface& surface_;
  std::unique_ptr<Player> player_;  // or nullptr
  ServoedDevice device_;
  std::vector<std::string> rendererNames_;
  std::shared_ptr<const Mechanism> plant_;  // with the person's changes
  TorqueStyle torques_;
  std::string scenePath_;                             // of what is shown
  std::string folder_;                                // for recordings
  std::vector<std::string> sceneFiles_, sceneNames_;  // the shipped ones, and the person's own
  int sceneIndex_ = 0;
  SceneFile scene_;
  OverlayState overlay_;
  RendererSlot begin_;              // with which the person began
  RendererSlot selected_, before_;  // for Tab
  RendererSlot right_;              // of the split screen's right tool
  bool split_ = false;
  Camera cameraBefore_;  // of the split screen
  int presetBefore_ = 0;
  std::shared_ptr<Workpiece> workpiece_;
  std::vector<SolidCopy> solids_;  // by obstacle
  std::optional<CutPlane> plane_;
  bool spins_ = false;
  double burTime_ = 0.0;        // of the last frame, s
  RemovedVolume burRemoved_{};  // then, m^3
  Chips chips_;
  std::optional<SoundOutput> sound_;     // since it was first wanted
  std::unique_ptr<Runner> runner_;       // where there is no player
  std::shared_ptr<Recorder> recording_;  // whose ticks one experiment adds, or nullptr
  std::string recordingPath_;
  double recordingBegin_ = 0.0;  // of simulated_, s
  bool wantsClip_ = false;
  double clip_ = -1.0;  // s
  Stage stage_;
  SceneView view_;
  std::optional<SceneView> rightView_;  // since the first split screen
  Charts charts_;
  Camera camera_;
  int preset_ = 0;
  bool follows_ = false;       // the contact
  double followedNear_ = 0.0;  // until then it also comes near
  float builtScale_ = 0.0f;
  Layout layout_;

  Frame frame_;
  Kinematics kinematics_;  // of the plant, with inertia
  SceneState shown_;
  Frame rightFrame_;  // in the split screen, with:
  Kinematics rightKinematics_;
  SceneState rightShown_;
  Comparison comparison_;
  std::vector<Vec3> trail_;
  StiffnessLimit limit_{};
  TimingNumbers timing_;
  double simulated_ = 0.0, now_ = 0.0, updated_ = 0.0, noticeEnd_ = 0.0;
  bool paused_ = false, end_ = false, fullScreen_ = false;
  int slowdown_ = 1;
  std::vector<std::string> pictures_;
  Seen seen_;

  struct Path {
    glm::dvec3 from, to;
    double begin, over;
  };
  std::optional<Path> path_;  // of a script's hand
  std::optional<Tour> tour_;
  double tourBegin_ = 0.0;
};

/// Runs in a window until it is closed, the script ends, or SIGINT or SIGTERM comes, and then writes the report. After
/// SIGUSR1 it also writes one of the next picture, and goes on. Returns the signal that ended it, or 0. Throws Error;
/// also where the window is closed while the tool is in contact. `started`: seconds on the steady clock when the
/// program began.
int runInWindow(const Options& options, double started);

/// Runs a script without a display on simulated time: the same script gives the same pictures. Otherwise as above.
int runHeadless(const Options& options, double started);

/// Seconds on the steady clock.
double steadySeconds();

}  // namespace enamel::viewer
