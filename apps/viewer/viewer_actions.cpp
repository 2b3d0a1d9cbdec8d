// Actions of a person or a script in the viewer.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include "enamel/collision/solid_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "free_path.hpp"
#include "viewer.hpp"

namespace enamel::viewer {
namespace {

// Return whether an action ends a tour before it is performed.
bool endsTour(Action action) {
  constexpr Action actions[] = {Action::swapRenderers, Action::split, Action::testPush, Action::grip,
                                Action::home,          Action::reset, Action::nextScene};
  return std::find(std::begin(actions), std::end(actions), action) != std::end(actions);
}

// Return the next factor of slow motion.
int nextSlowdown(int factor, bool slower) {
  constexpr int factors[] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};
  int next = factor;
  for (const int one : factors) {
    if (slower && one > factor) return one;
    if (!slower && one < factor) next = one;
  }
  return next;
}

}  // namespace

bool Viewer::isRefused(Source source) {
  if (source == Source::both) return false;
  if (live_) return notify("Not available while a device is connected."), true;
  if (source == Source::timed || (source == Source::recording) == (player_ != nullptr)) return false;
  notify(player_ ? "A recording cannot be changed." : "Available only in a recording (--play FILE).");
  return true;
}

void Viewer::send(RunnerCommand::Kind kind, int number) {
  RunnerCommand command{kind};
  command.number = number;
  runner_->send(command);
}

void Viewer::sendHand(RunnerCommand::Kind kind, const Vec3& target) {
  RunnerCommand command{kind};
  command.target = target;
  runner_->send(command);
}

void Viewer::act(Action action) {
  if (live_ && action == Action::record) return recordDevice();
  if (isRefused(actionRows()[static_cast<std::size_t>(action)].source)) return;
  if (player_ && actOnRecording(action)) return;
  if (live_ && action == Action::reset) return live_->reset();
  if (motion_.isTouring() && action == Action::cancel) return endTour(true);
  if (motion_.isTouring() && endsTour(action)) endTour(true);
  if (!actOnTool(action) && !actOnTime(action)) actOnView(action);
}

bool Viewer::actOnRecording(Action action) {
  constexpr double speeds[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0};
  const double speed = player_->speed();
  switch (action) {
    case Action::reset: player_->seek(0.0); return true;
    case Action::pause: player_->setPlaying(!player_->playing()); return true;
    case Action::step: player_->step(1); return true;
    case Action::stepBack: player_->step(-1); return true;
    case Action::nextEvent:
    case Action::previousEvent:
      if (!player_->jump(action == Action::nextEvent)) notify("No further contact or guard event.");
      return true;
    case Action::faster:
      player_->setSpeed(*std::find_if(speeds, std::end(speeds) - 1, [&](double s) { return s > 1.001 * speed; }));
      return true;
    case Action::slower:
      for (const double s : speeds)
        if (s < 0.999 * speed) player_->setSpeed(s);
      return true;
    default: return false;
  }
}

// Perform actions of renderers, hand, bur and scene. Return false for all other actions.
bool Viewer::actOnTool(Action action) {
  switch (action) {
    case Action::swapRenderers:
      if (split_) {
        const RendererSlot left = renderers_.selected;
        select(renderers_.right);
        selectRight(left);
      } else {
        select(renderers_.before);
      }
      return true;
    case Action::split: toggleSplit(); return true;
    case Action::tour: startTour(); return true;
    case Action::testPush:
      motion_.endLine();
      send(RunnerCommand::Kind::testPush);
      return true;
    case Action::grip: {
      overlay_.grip = overlay_.grip.stiffness == kFirmGrip.stiffness ? kPaperGrip : kFirmGrip;
      RunnerCommand command{RunnerCommand::Kind::grip};
      command.grip = overlay_.grip;
      runner_->send(command);
      return true;
    }
    case Action::home:
      motion_.endLine();
      sendHand(RunnerCommand::Kind::handTo, scene_.start);
      return true;
    case Action::reset: resetAll(); return true;
    case Action::undo: undo(); return true;
    case Action::nextScene:
      if (!scenes_.empty()) loadScene(scenes_.choose(scenes_.next()));
      return true;
    case Action::record: toggleRecording(); return true;
    default: return actOnScan(action);
  }
}

// Turn a scan, read it in another unit, or save it.
bool Viewer::actOnScan(Action action) {
  constexpr Action actions[] = {Action::turnX, Action::turnY, Action::turnZ, Action::scanUnit, Action::saveScene};
  if (std::find(std::begin(actions), std::end(actions), action) == std::end(actions)) return false;
  if (!isScan(scenePath_)) return notify("Available only for a scan: drop a mesh on the window."), true;
  ScanPlacement placement = placement_;
  if (action == Action::saveScene) {
    const std::string stem = std::filesystem::path(scenePath_).stem().string();
    const std::string path = freePath(folder_, stem.c_str(), {".toml"}) + ".toml";
    writeFile(path, sceneText_);
    notify(path + ": saved. enamel-viewer " + path + " opens it.");
    return true;
  }
  if (action == Action::scanUnit) {
    constexpr const char* units[] = {"", "mm", "m", "um"};
    const auto* const now = std::find(std::begin(units), std::end(units), placement.unit);
    placement.unit = units[(now - std::begin(units) + 1) % 4];
  } else {
    const int axis = static_cast<int>(action) - static_cast<int>(Action::turnX);
    placement.turn = Eigen::AngleAxisd(1.5707963267948966, Vec3::Unit(axis)).toRotationMatrix() * placement.turn;
  }
  if (!loadScene(scenePath_, placement)) placement_.unit = placement.unit;  // the next one may fit
  return true;
}

bool Viewer::actOnTime(Action action) {
  switch (action) {
    case Action::pause:
      paused_ = !paused_;
      send(paused_ ? RunnerCommand::Kind::pause : RunnerCommand::Kind::resume);
      return true;
    case Action::step:
      if (!paused_) act(Action::pause);
      send(RunnerCommand::Kind::step, 1);
      return true;
    case Action::faster:
    case Action::slower: setSlowdown(nextSlowdown(slowdown_, action == Action::slower)); return true;
    default: return false;
  }
}

void Viewer::actOnView(Action action) {
  switch (action) {
    case Action::cutAway: return cutOpen();
    case Action::saveSolids: return saveSolids();
    case Action::sound:
      if (isHeadless_) return notify("Sound is available only in a window.");
      overlay_.sound = !overlay_.sound;
      return notify(overlay_.sound ? "Sound of the bur is on." : "Sound of the bur is off.");
    case Action::clip: wantsClip_ = !wantsClip_; break;
    case Action::cameraField:
    case Action::cameraDevice:
    case Action::cameraSide:
    case Action::cameraTop: return camera_.select(static_cast<int>(action) - static_cast<int>(Action::cameraField));
    case Action::follow: return camera_.toggleFollowing();
    case Action::nextCamera: return camera_.selectBy(1);
    case Action::previousCamera: return camera_.selectBy(-1);
    case Action::help: overlay_.help = !overlay_.help; break;
    case Action::panels: overlay_.panels = !overlay_.panels; break;
    case Action::timing: overlay_.timing = !overlay_.timing; break;
    case Action::charts: overlay_.charts = !overlay_.charts; break;
    case Action::fullScreen: fullScreen_ = !fullScreen_; break;
    case Action::screenshot: pictures_.emplace_back(); break;
    case Action::cancel: return closeTop();
    case Action::quit: end_ = true; break;
    default: break;  // for recordings only
  }
}

// Close what was opened last over the picture.
void Viewer::closeTop() {
  for (bool* const open : {&overlay_.help, &overlay_.list, &overlay_.timing, &fullScreen_})
    if (std::exchange(*open, false)) return;
  notify("Ctrl+Q ends the viewer.");
}

void Viewer::select(RendererSlot slot) {
  if (slot == renderers_.selected) return;
  renderers_.before = renderers_.selected;
  renderers_.selected = slot;
  comparison_.clear();
  send(RunnerCommand::Kind::select, static_cast<int>(slot));
}

void Viewer::selectRight(RendererSlot slot) {
  if (slot == renderers_.right) return;
  renderers_.right = slot;
  comparison_.clear();
  send(RunnerCommand::Kind::selectRight, static_cast<int>(slot));
}

// Switch the split screen. Both tools begin at the pose of the one; at the end the left one continues alone.
void Viewer::toggleSplit() {
  if (!split_ && scene_.bur) return notify("Two tools cannot cut one solid: choose a scene without a bur.");
  split_ = !split_;
  builtScale_ = 0.0f;
  comparison_.clear();
  if (split_) {
    camera_.keep();
    camera_.select(0);
    if (!right_.view) right_.view.emplace(canvas_.right(), canvas_.aboveRight());
    if (renderers_.right == renderers_.selected) renderers_.right = renderers_.before;
  } else {
    camera_.restore();
  }
  rebuild(left_.frame.record.pose, left_.frame.hand, true);
}

// On any other shape the hand would slide off.
bool Viewer::canTour() const {
  const auto& obstacles = scene_.scene.obstacles();
  return runner_ && !scene_.bur && obstacles.size() == 1 && std::holds_alternative<HalfSpace>(obstacles[0].shape);
}

// Start the tour at the scene's start, at rest, with position control and the spring.
void Viewer::startTour() {
  if (!canTour()) return notify("The tour needs a scene with one wall, such as flat-wall.");
  if (!split_) toggleSplit();
  if (paused_) act(Action::pause);
  setSlowdown(1);
  renderers_.selected = RendererSlot::positionControl;
  renderers_.right = RendererSlot::impedance;
  comparison_.clear();
  startAgain();
  Pose start;
  start.position = scene_.start;
  motion_.startTour(Tour(scene_.start, nearestContact(scene_.scene, scene_.tool, start, nullptr), overlay_.grip), now_);
}

// End the tour and give the hand to the person.
void Viewer::endTour(bool skipped) {
  motion_.endTour();
  if (skipped) act(Action::home);
  notify("You now control the hand: drag the tool, or press at the left. V: one tool.");
}

void Viewer::setSlowdown(int factor) {
  slowdown_ = factor;
  send(RunnerCommand::Kind::slowdown, factor);
}

void Viewer::undo() {
  if (left_.frame.drilled.strokes == 0) return notify("No stroke of a bur to undo.");
  if (records()) return notify("Undo is not possible during a recording: Ctrl+R ends it.");
  send(RunnerCommand::Kind::undo);
}

// Reset everything except the scene and the size of the window.
void Viewer::resetAll() {
  overlay_.settings = Settings{};
  overlay_.grip = kFirmGrip;
  if (split_) toggleSplit();
  renderers_ = Choice(renderers_.begin);
  if (paused_) act(Action::pause);
  setSlowdown(1);
  if (plane_) cutOpen();
  spins_ = false;
  camera_.select(0);
  startAgain();
  send(RunnerCommand::Kind::restore);
  notify("Settings, renderer, hand, teeth, time and view have been reset.");
}

// Start or end a recording. It begins with the tool at rest at its present pose and the renderers in their initial
// state, which the replay needs. It ends with its experiment.
void Viewer::toggleRecording() {
  std::string path;
  if (!records()) {
    if (split_) return notify("The split screen cannot be recorded: V shows one tool.");
    const RemovedVolume& removed = left_.frame.drilled.removed;
    if (scene_.bur && std::any_of(removed.begin(), removed.end(), [](double volume) { return volume > 0.0; }))
      return notify("A recording needs teeth without cuts: undo them with Ctrl+Z or Backspace.");
    path = freePath(folder_, "enamel", {".rec"}) + ".rec";
  }
  rebuild(left_.frame.record.pose, left_.frame.hand, true, path);
}

// Start or end a recording of a connected device.
void Viewer::recordDevice() {
  if (records()) return notify(endRecording());
  try {
    const std::string path = freePath(folder_, "enamel", {".rec"}) + ".rec";
    live_->record(path);
    recording_ = {nullptr, path, simulated_};
  } catch (const Error& error) {
    notify(error.what());
  }
}

std::string Viewer::endRecording() {
  if (!records()) return {};
  const RecordingResult result = live_ ? live_->stopRecording() : std::exchange(recording_.recorder, nullptr)->close();
  std::string text = std::exchange(recording_.path, {}) + ": " + std::to_string(result.ticks) + " ticks";
  if (result.lost > 0) text += ", " + std::to_string(result.lost) + " lost";
  if (!result.problem.empty()) text += "; " + result.problem;
  return text + ". --play shows it.";
}

// Take the hand from a tour or a script.
void Viewer::takeHand() {
  if (motion_.isTouring()) endTour(true);
  motion_.endLine();
}

void Viewer::moveHandBy(const glm::dvec3& millimetres) {
  if (isRefused(Source::live)) return;
  takeHand();
  sendHand(RunnerCommand::Kind::handBy, metres(millimetres));
}

void Viewer::pressBy(double newtons) {
  if (isRefused(Source::live)) return;
  takeHand();
  const Vec3& normal = left_.frame.record.nearest.normal;
  sendHand(RunnerCommand::Kind::handBy, -newtons * normal.cwiseQuotient(stiffnessOf(overlay_.grip)));
}

void Viewer::pressWith(double newtons) {
  takeHand();
  const Contact& nearest = left_.frame.record.nearest;
  const Vec3 surface = left_.frame.record.pose.position - nearest.gap * nearest.normal;
  sendHand(RunnerCommand::Kind::handTo, surface - newtons * nearest.normal.cwiseQuotient(stiffnessOf(overlay_.grip)));
}

void Viewer::spin(bool on) {
  if (!live_ && isRefused(Source::live)) return;
  if (!scene_.bur) {
    if (on) notify("The tool of this scene is not a bur: it cannot spin (scene drill has one).");
    return;
  }
  spins_ = on;
  if (live_) return live_->spin(on);
  send(RunnerCommand::Kind::spin, on ? 1 : 0);
}

// Save each solid as it is now, with its cuts.
void Viewer::saveSolids() {
  if (layersOf(solids_) == nullptr) return notify("This scene has no solid to save (scene drill has one).");
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (!solids_[i].uncut) continue;
    Solid solid = *solids_[i].uncut;
    for (int brick = 0; brick < solid.bricks(); ++brick)
      solid.set(brick, solids_[i].samples[static_cast<std::size_t>(brick)]);
    try {
      const std::string path = freePath(folder_, scene_.scene.obstacles()[i].name.c_str(), {".solid"}) + ".solid";
      saveSolid(solid, path);
      notify(path + ": saved.");
    } catch (const Error& error) {
      notify(error.what());
    }
  }
}

// Cut the solids open along the tool, facing the camera; or close them again.
void Viewer::cutOpen() {
  builtScale_ = 0.0f;
  if (plane_) {
    plane_.reset();
    return;
  }
  if (layersOf(solids_) == nullptr) return notify("This scene has no solid to cut open (scene drill has one).");
  const Pose& tool = left_.frame.record.pose;
  const Vec3 axis = tool.rotation.col(2), towards = metres(camera().eye()) - tool.position;
  const Vec3 across = towards - axis.dot(towards) * axis;
  plane_ = CutPlane{tool.position, across.norm() > 1e-6 ? Vec3(across.normalized()) : axis.unitOrthogonal().eval()};
}

void Viewer::seek(double share) { player_->seek(share * static_cast<double>(player_->size() - 1) + 0.5); }

// Return whether a dropped file can be shown by another viewer. If not, notify the person.
bool Viewer::canOpen(const std::string& path) {
  try {
    if (isRecording(path))
      (void)Player(path);
    else
      (void)parseScene(isScan(path) ? sceneOfScan(path).text : readFile(path), path);
    return true;
  } catch (const Error& error) {
    notify(error.what());
    return false;
  }
}

void Viewer::drop(const std::vector<std::string>& paths) {
  if (live_) return notify("Not available while a device is connected.");
  for (const std::string& path : paths)
    if (player_ || isRecording(path)) {
      if (!canOpen(path)) continue;
      open_ = path;
      return;
    } else if (loadScene(path)) {
      return scenes_.add(path);
    }
}

std::vector<std::string> Viewer::takePictures() {
  std::vector<std::string> names;
  names.swap(pictures_);
  return names;
}

void Viewer::follow(const ScriptStep& step, double now) {
  now_ = now;
  switch (step.kind) {  // a connected device has no simulated hand, renderers, settings and time
    case ScriptStep::Kind::hand:
    case ScriptStep::Kind::renderer:
    case ScriptStep::Kind::right:
    case ScriptStep::Kind::set:
    case ScriptStep::Kind::scene:
    case ScriptStep::Kind::slowdown:
    case ScriptStep::Kind::seek:
      if (live_) return notify("Not available while a device is connected.");
      break;
    default: break;
  }
  switch (step.kind) {
    case ScriptStep::Kind::action: act(step.action); break;
    case ScriptStep::Kind::hand:
      if (motion_.isTouring()) endTour(true);
      motion_.startLine(kMillimetres * left_.frame.hand.target, {step.target.x, step.target.y, step.target.z},
                        step.over, now);
      break;
    case ScriptStep::Kind::spin: spin(step.number != 0); break;
    case ScriptStep::Kind::view: camera() = step.view; break;
    case ScriptStep::Kind::renderer: select(static_cast<RendererSlot>(step.number)); break;
    case ScriptStep::Kind::right: selectRight(static_cast<RendererSlot>(step.number)); break;
    case ScriptStep::Kind::set:
      for (const SettingRow& row : settingRows())
        if (step.name == row.name) row.apply(overlay_.settings, step.value);
      overlay_.asked.settings = true;
      break;
    case ScriptStep::Kind::scene: loadScene(step.name); break;
    case ScriptStep::Kind::slowdown:
      if (player_)
        player_->setSpeed(1.0 / step.number);
      else
        setSlowdown(step.number);
      break;
    case ScriptStep::Kind::seek: player_->seek(std::round(step.value / player_->header().guard.period)); break;
    case ScriptStep::Kind::size: surface_.resize(step.size); break;
    case ScriptStep::Kind::picture: pictures_.push_back(step.name); break;
    case ScriptStep::Kind::frames: break;  // performed by the headless loop
    case ScriptStep::Kind::end: end_ = true; break;
  }
}

}  // namespace enamel::viewer
