#include "viewer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "data_folder.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "program/recorded.hpp"
#include "scan.hpp"

namespace enamel::viewer {
namespace {

constexpr double kNotice = 3.0, kNoticeByte = 0.03;  // s, and for each letter
constexpr std::size_t kTrail = 150;                  // ticks

const std::string& existing(const std::string& file) {
  static const std::string none;
  return std::filesystem::exists(file) ? file : none;
}

Hand handAt(const Vec3& position, const Grip& grip) {
  Hand hand;
  hand.grip = grip;
  hand.target = hand.position = position;
  return hand;
}

ServoedDevice deviceOf(const Player* player, const Options& options) {
  ServoedDevice device;
  if (player != nullptr) {
    device.parameters = player->parameters();
    return device;
  }
  device = loadServoedDevice(options.device, options.gain);
  device.plugin = options.plugin;
  device.pluginSetup = {options.device, "", options.scene, "", options.pluginParameters};
  return device;
}

// Before anything cuts them.
std::vector<SolidCopy> copiesOf(const SceneFile& scene) {
  std::vector<SolidCopy> copies;
  for (const auto& solid : scene.solids) copies.push_back(solid ? copyOf(*solid) : SolidCopy());
  return copies;
}

std::unique_ptr<Runner> firstRunner(const ServoedDevice& device, const SceneFile& scene, RendererSlot slot,
                                    const std::shared_ptr<Workpiece>& workpiece) {
  Pose start;
  start.position = scene.start;
  return std::make_unique<Runner>(
      std::make_unique<Experiment>(device, Settings{}, scene, start, handAt(scene.start, kFirmGrip), slot, workpiece));
}

Vec3 metres(const glm::dvec3& millimetres) { return Vec3(millimetres.x, millimetres.y, millimetres.z) / kMillimetres; }

}  // namespace

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Viewer::Viewer(const Options& options, Surface& surface)
    : isHeadless_(options.headless),
      surface_(surface),
      player_(options.play.empty() ? nullptr : std::make_unique<Player>(options.play)),
      device_(deviceOf(player_.get(), options)),
      rendererNames_(viewer::rendererNames(options.plugin.get())),
      plant_(makeMechanism(changed(device_.parameters, Settings{}))),
      torques_(*plant_),
      scenePath_(options.scene),
      folder_(options.record.empty() ? "." : options.record),
      scene_(player_ ? player_->scene() : enamel::loadScene(options.scene)),
      begin_(options.begin),
      selected_(options.begin),
      before_(selected_ == RendererSlot::impedance ? RendererSlot::positionControl : RendererSlot::impedance),
      right_(before_),
      workpiece_(std::make_shared<Workpiece>(scene_)),
      solids_(copiesOf(scene_)),
      runner_(player_ ? nullptr : firstRunner(device_, scene_, selected_, workpiece_)),
      stage_(surface, existing(ENAMEL_VIEWER_FONT), existing(ENAMEL_VIEWER_FONT_BOLD)),
      view_(stage_.scene(), stage_.above()),
      charts_(stage_.charts(), existing(ENAMEL_VIEWER_FONT), torques_,
              player_ ? player_->header().guard.period : kPeriod, player_ != nullptr) {
  kinematics_ = rightKinematics_ = plant_->home();
  shown_.bars = rightShown_.bars = plant_->bars(kinematics_.pose);
  shown_.chips = &chips_;
  overlay_.sound = !options.headless && options.script.empty();
  selectCamera(0);
  if (player_) {
    if (!player_->notes().empty()) notify(player_->notes().front());
    return;
  }
  std::error_code error;
  const std::filesystem::path own(options.scene);
  for (const std::filesystem::path& folder :
       {std::filesystem::path(dataFolder()) / "scenes", std::filesystem::absolute(own).parent_path()}) {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
      if (entry.path().extension() == ".toml") found.push_back(entry.path().string());
    std::sort(found.begin(), found.end());
    for (const std::string& path : found) addScene(path);
  }
  addScene(options.scene);
  overlay_.sceneNotes = scene_.notes;
}

// Makes it the chosen one; a file that is in the list already stays where it is.
void Viewer::addScene(const std::string& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  const auto found = std::find(sceneFiles_.begin(), sceneFiles_.end(), whole.string());
  sceneIndex_ = static_cast<int>(found - sceneFiles_.begin());
  if (found != sceneFiles_.end()) return;
  sceneFiles_.push_back(whole.string());
  sceneNames_.push_back(whole.stem().string());
}

void Viewer::drop(const std::vector<std::string>& paths) {
  if (isRefused(Source::live)) return;
  bool shown = false;
  for (const std::string& path : paths) {
    if (shown || !loadScene(path)) continue;
    shown = true;
    addScene(path);
  }
}

glm::dvec3 Viewer::tool() const {
  const Vec3 tool = kMillimetres * frame_.record.pose.position;
  return {tool.x(), tool.y(), tool.z()};
}

glm::dvec3 Viewer::normal() const {
  const Vec3& n = frame_.record.nearest.normal;
  return {n.x(), n.y(), n.z()};
}

void Viewer::notify(const std::string& text) {
  Seen::add(seen_.notices, text);
  overlay_.notice = text;
  noticeEnd_ = now_ + kNotice + kNoticeByte * static_cast<double>(text.size());
}

void Viewer::send(RunnerCommand::Kind kind, int number) {
  RunnerCommand command{kind};
  command.number = number;
  runner_->send(command);
}

bool Viewer::isRefused(Source source) {
  if (source == Source::both || (source == Source::recording) == (player_ != nullptr)) return false;
  notify(player_ ? "This is a recording: nothing in it can be changed." : "Only in a recording (--play FILE).");
  return true;
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
      if (!player_->jump(action == Action::nextEvent)) notify("There is no more contact or act of the guard.");
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

void Viewer::select(RendererSlot slot) {
  if (slot == selected_) return;
  before_ = selected_;
  selected_ = slot;
  comparison_.clear();
  send(RunnerCommand::Kind::select, static_cast<int>(slot));
}

void Viewer::selectRight(RendererSlot slot) {
  if (slot == right_) return;
  right_ = slot;
  comparison_.clear();
  send(RunnerCommand::Kind::selectRight, static_cast<int>(slot));
}

// Both tools begin where the one is; the left one goes on alone.
void Viewer::toggleSplit() {
  if (!split_ && scene_.bur) return notify("Two tools cannot cut one solid: choose a scene without a bur.");
  split_ = !split_;
  builtScale_ = 0.0f;
  comparison_.clear();
  if (split_) {
    cameraBefore_ = camera_;
    presetBefore_ = preset_;
    selectCamera(3);
    if (!rightView_) rightView_.emplace(stage_.right(), stage_.aboveRight());
    if (right_ == selected_) right_ = before_;
  } else {
    camera_ = cameraBefore_;
    preset_ = presetBefore_;
  }
  rebuild(frame_.record.pose, frame_.hand, true);
}

// On anything else the hand would slide off.
bool Viewer::canTour() const {
  const auto& obstacles = scene_.scene.obstacles();
  return !player_ && !scene_.bur && obstacles.size() == 1 && std::holds_alternative<HalfSpace>(obstacles[0].shape);
}

// From the start, at rest, with position control and the spring.
void Viewer::startTour() {
  if (!canTour()) return notify("The tour is for scenes that are one wall, as flat-wall is.");
  if (!split_) toggleSplit();
  if (paused_) act(Action::pause);
  slowdown_ = 1;
  send(RunnerCommand::Kind::slowdown, slowdown_);
  selected_ = RendererSlot::positionControl;
  right_ = RendererSlot::impedance;
  comparison_.clear();
  startAgain();
  Pose start;
  start.position = scene_.start;
  tour_.emplace(scene_.start, nearestContact(scene_.scene, scene_.tool, start, nullptr), overlay_.grip);
  tourBegin_ = now_;
}

// Then the hand is the person's.
void Viewer::endTour(bool skipped) {
  tour_.reset();
  if (skipped) act(Action::home);
  notify("The hand is yours: drag it, or press with the wheel. V: one tool.");
}

void Viewer::selectCamera(int preset) {
  preset_ = preset;
  follows_ = false;
  camera_ = cameraPresets()[static_cast<std::size_t>(preset)].camera;
}

// Nearer at first; then the person's wheel says how near.
void Viewer::followContact(double passed) {
  constexpr double near = 120.0;  // mm
  const Vec3 at = kMillimetres * frame_.record.nearest.point;
  if (follows_ && at.allFinite())
    viewer::follow(camera_, {at.x(), at.y(), at.z()}, now_ < followedNear_ ? near : camera_.distance, passed);
}

// A replaced experiment begins at rest where the tool is.
void Viewer::rebuild(const Pose& start, const Hand& hand, bool keepTests, const std::string& record) {
  try {
    plant_ = makeMechanism(changed(device_.parameters, overlay_.settings));
    const auto make = [&](RendererSlot slot, std::shared_ptr<Workpiece> workpiece) {
      return std::make_unique<Experiment>(device_, overlay_.settings, scene_, start, hand, slot, std::move(workpiece));
    };
    auto left = make(selected_, workpiece_), right = split_ ? make(right_, nullptr) : nullptr;
    if (keepTests) {
      // What is known of the renderers, that of the right one from its own side.
      auto tests = frame_.tests;
      if (const TestPush& test = rightFrame_.tests[indexOf(rightFrame_.selected)]; test.made)
        tests[indexOf(rightFrame_.selected)] = test;
      left->keepTests(tests);
      if (right) right->keepTests(tests);
    }
    if (!split_) rightFrame_ = Frame();
    if (!record.empty()) {
      RecordingHeader header;
      header.deviceFile = std::filesystem::absolute(device_.pluginSetup.devicePath).string();
      header.deviceText = readFile(header.deviceFile);
      header.sceneFile = std::filesystem::absolute(scenePath_).string();
      header.sceneText = readFile(header.sceneFile);
      header.start = start;
      const bool isPlugin = device_.plugin && slotOf(*device_.plugin) == selected_;
      app::nameRenderer(rendererNames_[indexOf(selected_)], isPlugin ? device_.plugin->path() : "", {}, scene_.scene,
                        header);
      recording_ = left->recordTo(record, std::move(header));
      recordingPath_ = record;
      recordingBegin_ = simulated_;
    }
    runner_->replace(std::move(left), std::move(right));
    if (spins_ && scene_.bur) send(RunnerCommand::Kind::spin, 1);
  } catch (const Error& error) {
    notify(error.what());
  }
}

// From the tool at rest where it is, with renderers that begin anew: a recording knows its first state. It ends with
// its experiment.
void Viewer::toggleRecording() {
  std::string path;
  if (!recording_) {
    if (split_) return notify("Two tools are not recorded: V shows one.");
    if (isScan(scenePath_)) return notify("A scan is not recorded as it is dropped: a scene file that names it is.");
    const RemovedVolume& removed = frame_.drilled.removed;
    if (scene_.bur && std::any_of(removed.begin(), removed.end(), [](double volume) { return volume > 0.0; }))
      return notify("A recording begins with whole teeth: Ctrl+Z or Backspace puts back what was drilled.");
    for (int i = 1; path.empty() || std::filesystem::exists(path); ++i) {
      char free[32];
      std::snprintf(free, sizeof(free), "enamel-%03d.rec", i);
      path = (std::filesystem::path(folder_) / free).string();
    }
  }
  rebuild(frame_.record.pose, frame_.hand, true, path);
}

std::string Viewer::endRecording() {
  if (!recording_) return {};
  const RecordingResult result = std::exchange(recording_, nullptr)->close();
  std::string text = recordingPath_ + ": " + std::to_string(result.ticks) + " ticks";
  if (result.lost > 0) text += ", " + std::to_string(result.lost) + " lost";
  if (!result.problem.empty()) text += "; " + result.problem;
  return text + ". --play shows it.";
}

void Viewer::startAgain(bool keepTests) {
  Pose start;
  start.position = scene_.start;
  path_.reset();
  rightFrame_ = Frame();
  rebuild(start, handAt(scene_.start, overlay_.grip), keepTests);
}

// False, with a word of why: it stays as it was.
bool Viewer::loadScene(const std::string& path) {
  try {
    scene_ = isScan(path) ? sceneOfScan(path) : enamel::loadScene(path);
    tour_.reset();
    scenePath_ = path;
    overlay_.sceneNotes = scene_.notes;
    workpiece_ = std::make_shared<Workpiece>(scene_);
    solids_ = copiesOf(scene_);
    plane_.reset();
    sound_.reset();
    for (const std::string& note : scene_.notes) notify(note);
    builtScale_ = 0.0f;
    if (split_ && scene_.bur) toggleSplit();
    comparison_.clear();
    startAgain();
    return true;
  } catch (const Error& error) {
    notify(error.what());
    return false;
  }
}

// All but the scene and the size of the window.
void Viewer::resetAll() {
  overlay_.settings = Settings{};
  overlay_.grip = kFirmGrip;
  if (split_) toggleSplit();
  selected_ = begin_;
  before_ = selected_ == RendererSlot::impedance ? RendererSlot::positionControl : RendererSlot::impedance;
  right_ = before_;
  if (paused_) act(Action::pause);
  slowdown_ = 1;
  send(RunnerCommand::Kind::slowdown, slowdown_);
  if (plane_) cutOpen();
  spins_ = false;
  selectCamera(0);
  startAgain();
  send(RunnerCommand::Kind::restore, 0);
  notify("Settings, renderer, hand, teeth, time and view are as at the start.");
}

std::vector<std::string> Viewer::takePictures() {
  std::vector<std::string> names;
  names.swap(pictures_);
  return names;
}

void Viewer::act(Action action) {
  if (isRefused(actionRows()[static_cast<std::size_t>(action)].source)) return;
  if (player_ && actOnRecording(action)) return;
  if (tour_) {
    switch (action) {
      case Action::swapRenderers:
      case Action::split:
      case Action::testPush:
      case Action::grip:
      case Action::home:
      case Action::reset:
      case Action::nextScene: endTour(true); break;
      case Action::cancel: return endTour(true);
      default: break;
    }
  }
  constexpr int speeds[] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};
  switch (action) {
    case Action::swapRenderers:
      if (split_) {
        const RendererSlot left = selected_;
        select(right_);
        selectRight(left);
      } else {
        select(before_);
      }
      break;
    case Action::split: toggleSplit(); break;
    case Action::tour: startTour(); break;
    case Action::testPush:
      path_.reset();
      send(RunnerCommand::Kind::testPush, 0);
      break;
    case Action::grip: {
      overlay_.grip = overlay_.grip.stiffness == kFirmGrip.stiffness ? kPaperGrip : kFirmGrip;
      RunnerCommand command{RunnerCommand::Kind::grip};
      command.grip = overlay_.grip;
      runner_->send(command);
      break;
    }
    case Action::home: {
      path_.reset();
      RunnerCommand command{RunnerCommand::Kind::handTo};
      command.target = scene_.start;
      runner_->send(command);
      break;
    }
    case Action::reset: resetAll(); break;
    case Action::undo:
      if (recording_ && frame_.drilled.strokes > 0)
        notify("A recording cannot take back what it has drilled: Ctrl+R ends it.");
      else if (frame_.drilled.strokes == 0)
        notify("There is no stroke of a bur to take back.");
      else
        send(RunnerCommand::Kind::undo, 0);
      break;
    case Action::cutAway: cutOpen(); break;
    case Action::sound:
      if (isHeadless_) return notify("There is sound only in a window.");
      overlay_.sound = !overlay_.sound;
      notify(overlay_.sound ? "The bur is heard." : "The bur is not heard.");
      break;
    case Action::nextScene:
      if (!sceneFiles_.empty()) {
        sceneIndex_ = (sceneIndex_ + 1) % static_cast<int>(sceneFiles_.size());
        loadScene(sceneFiles_[static_cast<std::size_t>(sceneIndex_)]);
      }
      break;
    case Action::pause:
      paused_ = !paused_;
      send(paused_ ? RunnerCommand::Kind::pause : RunnerCommand::Kind::resume, 0);
      break;
    case Action::step:
      if (!paused_) act(Action::pause);
      send(RunnerCommand::Kind::step, 1);
      break;
    case Action::stepBack:
    case Action::nextEvent:
    case Action::previousEvent: break;  // of recordings
    case Action::record: toggleRecording(); break;
    case Action::clip: wantsClip_ = !wantsClip_; break;
    case Action::faster:
      for (int i = 9; i >= 0; --i)
        if (speeds[i] < slowdown_) {
          slowdown_ = speeds[i];
          break;
        }
      send(RunnerCommand::Kind::slowdown, slowdown_);
      break;
    case Action::slower:
      for (const int speed : speeds)
        if (speed > slowdown_) {
          slowdown_ = speed;
          break;
        }
      send(RunnerCommand::Kind::slowdown, slowdown_);
      break;
    case Action::camera1:
    case Action::camera2:
    case Action::camera3:
    case Action::camera4: selectCamera(static_cast<int>(action) - static_cast<int>(Action::camera1)); break;
    case Action::follow:
      follows_ = !follows_;
      followedNear_ = now_ + 0.6;
      break;
    case Action::nextCamera: selectCamera((preset_ + 1) % 4); break;
    case Action::previousCamera: selectCamera((preset_ + 3) % 4); break;
    case Action::help: overlay_.help = !overlay_.help; break;
    case Action::panels: overlay_.panels = !overlay_.panels; break;
    case Action::timing: overlay_.timing = !overlay_.timing; break;
    case Action::charts: overlay_.charts = !overlay_.charts; break;
    case Action::fullScreen: fullScreen_ = !fullScreen_; break;
    case Action::screenshot: pictures_.emplace_back(); break;
    case Action::cancel:
      if (!overlay_.help) notify("Ctrl+Q ends the viewer.");
      overlay_.help = false;
      break;
    case Action::quit: end_ = true; break;
  }
}

void Viewer::moveHandBy(const glm::dvec3& millimetres) {
  if (isRefused(Source::live)) return;
  if (tour_) endTour(true);
  path_.reset();
  RunnerCommand command{RunnerCommand::Kind::handBy};
  command.target = metres(millimetres);
  runner_->send(command);
}

void Viewer::pressBy(double newtons) {
  if (isRefused(Source::live)) return;
  if (tour_) endTour(true);
  path_.reset();
  RunnerCommand command{RunnerCommand::Kind::handBy};
  command.target = -newtons * frame_.record.nearest.normal.cwiseQuotient(stiffnessOf(overlay_.grip));
  runner_->send(command);
}

void Viewer::spin(bool on) {
  if (isRefused(Source::live)) return;
  if (!scene_.bur) {
    if (on) notify("The tool of this scene is no bur: nothing spins (scene drill has one).");
    return;
  }
  spins_ = on;
  send(RunnerCommand::Kind::spin, on ? 1 : 0);
}

// Along the tool, towards the camera; or closed again.
void Viewer::cutOpen() {
  builtScale_ = 0.0f;
  if (plane_) {
    plane_.reset();
    return;
  }
  if (std::none_of(solids_.begin(), solids_.end(), [](const SolidCopy& s) { return s.uncut != nullptr; }))
    return notify("There is no solid in this scene to cut open (scene drill has one).");
  const Pose& tool = frame_.record.pose;
  const Vec3 axis = tool.rotation.col(2), towards = metres(camera_.eye()) - tool.position;
  const Vec3 across = towards - axis.dot(towards) * axis;
  plane_ = CutPlane{tool.position, across.norm() > 1e-6 ? Vec3(across.normalized()) : axis.unitOrthogonal().eval()};
}

void Viewer::takeChanges() {
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (!solids_[i].uncut) continue;
    for (BrickChange change; workpiece_->takeChange(i, change);) {
      solids_[i].samples[static_cast<std::size_t>(change.brick)] = change.samples;
      view_.change(i, change.brick);
    }
  }
}

// What happened since the last frame: the bur turns, chips fly, and one hears it.
void Viewer::takeCut() {
  constexpr double shownTurns = 1.7;  // a second: those of a bur are too fast to be seen
  const Drilled& drilled = frame_.drilled;
  if (frame_.record.time < burTime_) chips_ = Chips();
  const double passed = std::max(0.0, frame_.record.time - burTime_);
  burTime_ = frame_.record.time;
  if (drilled.spins) shown_.burAngle += 6.283185307179586 * shownTurns * passed;
  RemovedVolume cut{};
  for (std::size_t i = 0; i < cut.size(); ++i) cut[i] = std::max(0.0, drilled.removed[i] - burRemoved_[i]);
  burRemoved_ = drilled.removed;
  // Out of a hole chips come at its mouth.
  const Vec3 axis = frame_.record.pose.rotation.col(2);
  const double radius = scene_.tool.parts[static_cast<std::size_t>(scene_.bur->part)].radius;
  Vec3 mouth = burTip();
  for (int i = 0; cut != RemovedVolume{} && i < 20; ++i) {
    const double left = 0.5 * radius - uncutDistance(mouth);
    if (left <= 0.0) break;
    mouth += std::max(0.1 * radius, left) * axis;
  }
  chips_.advance(passed, cut, mouth, axis, radius);

  if (overlay_.sound && !sound_) sound_.emplace();
  if (!sound_ || (passed == 0.0 && !frame_.paused)) return;  // in slow motion it goes on
  BurLoad load;
  if (const auto* layers = this->layers(); overlay_.sound && drilled.spins && !frame_.paused && layers != nullptr) {
    load.turns = scene_.bur->turns;
    double power = 0.0;
    for (std::size_t i = 0; i < layers->size(); ++i) {
      load.removal += cut[i] / passed;
      power += (*layers)[i].hardness * cut[i] / passed;
    }
    if (power > 0.0) load.hardness = power / load.removal;
  }
  sound_->set(load);
  if (const char* trouble = sound_->trouble(); trouble != nullptr && overlay_.soundTrouble.empty()) {
    overlay_.soundTrouble = std::string("No sound: ") + trouble + ".";
    std::fprintf(stderr, "enamel-viewer: no sound: %s\n", trouble);
    notify(overlay_.soundTrouble);
  }
}

// Of the first solid, or nullptr.
const std::vector<SolidLayer>* Viewer::layers() const {
  for (const SolidCopy& solid : solids_)
    if (solid.uncut) return &solid.uncut->layers();
  return nullptr;
}

// From the nearest solid as it was before anything was cut, m; none is far.
double Viewer::uncutDistance(const Vec3& point) const {
  double distance = 1.0;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (!solids_[i].uncut) continue;
    const Pose& solid = scene_.scene.obstacles()[i].pose;
    const Vec3 inSolid = solid.rotation.transpose() * (point - solid.position);
    distance = std::min(distance, signedDistance(*solids_[i].uncut, inSolid).distance);
  }
  return distance;
}

// Of its tip's centre.
Vec3 Viewer::burTip() const {
  const Pose& tool = frame_.record.pose;
  return tool.position + tool.rotation * scene_.tool.parts[static_cast<std::size_t>(scene_.bur->part)].a;
}

double Viewer::burDepth() const {
  if (!scene_.bur) return 0.0;
  return std::max(0.0, scene_.tool.parts[static_cast<std::size_t>(scene_.bur->part)].radius - uncutDistance(burTip()));
}

void Viewer::seek(double share) { player_->seek(share * static_cast<double>(player_->size() - 1) + 0.5); }

void Viewer::follow(const ScriptStep& step, double now) {
  now_ = now;
  switch (step.kind) {
    case ScriptStep::Kind::action: act(step.action); break;
    case ScriptStep::Kind::hand: {
      if (tour_) endTour(true);
      const Vec3 from = kMillimetres * frame_.hand.target;
      path_ = Path{{from.x(), from.y(), from.z()}, step.target, now, step.over};
      break;
    }
    case ScriptStep::Kind::spin: spin(step.number != 0); break;
    case ScriptStep::Kind::view: camera_ = step.view; break;
    case ScriptStep::Kind::renderer: select(static_cast<RendererSlot>(step.number)); break;
    case ScriptStep::Kind::right: selectRight(static_cast<RendererSlot>(step.number)); break;
    case ScriptStep::Kind::set:
      for (const SettingRow& row : settingRows())
        if (step.name == row.name) row.apply(overlay_.settings, step.value);
      overlay_.settingsChanged = true;
      break;
    case ScriptStep::Kind::scene: loadScene(step.name); break;
    case ScriptStep::Kind::slowdown:
      if (player_) {
        player_->setSpeed(1.0 / step.number);
        break;
      }
      slowdown_ = step.number;
      send(RunnerCommand::Kind::slowdown, slowdown_);
      break;
    case ScriptStep::Kind::seek: player_->seek(std::round(step.value / player_->header().guard.period)); break;
    case ScriptStep::Kind::size: surface_.resize(step.size); break;
    case ScriptStep::Kind::picture: pictures_.push_back(step.name); break;
    case ScriptStep::Kind::frames: break;  // of the headless loop
    case ScriptStep::Kind::end: end_ = true; break;
  }
}

void Viewer::takeRun() {
  if (tour_) {
    RunnerCommand command{RunnerCommand::Kind::handTo};
    command.target = tour_->hand(now_ - tourBegin_);
    runner_->send(command);
    if (now_ - tourBegin_ >= Tour::kLength) endTour(false);
  }
  if (path_) {
    const double share = path_->over > 0.0 ? std::min(1.0, (now_ - path_->begin) / path_->over) : 1.0;
    RunnerCommand command{RunnerCommand::Kind::handTo};
    command.target = metres(glm::mix(path_->from, path_->to, share));
    runner_->send(command);
    if (share >= 1.0) path_.reset();
  }
  runner_->collect();
  if (recording_ && recording_.use_count() == 1) notify(endRecording());
  frame_ = runner_->frame();
  if (const Frame* right = runner_->secondFrame(); right != nullptr) rightFrame_ = *right;
  for (PairSample sample; runner_->nextPair(sample);) comparison_.add(sample);
  takeChanges();
  if (scene_.bur) takeCut();
  for (Sample sample; runner_->nextSample(sample);) {
    charts_.add(sample);
    trail_.push_back(sample.position);
    simulated_ += kPeriod;
  }
  if (trail_.size() > kTrail) trail_.erase(trail_.begin(), trail_.end() - static_cast<std::ptrdiff_t>(kTrail));
  const bool lost = runner_->secondFrame() != nullptr && rightFrame_.plant != Status::ok;
  if (frame_.plant != Status::ok || lost) {
    notify("The tool left the reach of the device: back to the start.");
    startAgain(true);
  }
}

void Viewer::takeRecording(double passed) {
  player_->advance(passed);
  frame_ = player_->frame();
  simulated_ = player_->seconds();
  // Bins begin at the same ticks at every place, or their smallest and largest values would flicker.
  constexpr int bin = Charts::kBinTicks, shown = Charts::kBins * bin;
  const auto now = static_cast<std::int64_t>(player_->position()), from = now / bin * bin - shown / 2;
  const std::vector<Sample> samples = player_->samples(from, shown + 1);  // one more completes the last bin
  charts_.clear();
  for (const Sample& sample : samples) charts_.add(sample);
  trail_.clear();
  for (std::int64_t at = now - static_cast<std::int64_t>(kTrail); at <= now; ++at)
    if (const Vec3& position = samples[static_cast<std::size_t>(at - from)].position; position.allFinite())
      trail_.push_back(position);
}

void Viewer::fillShown(const Frame& frame, Kinematics& kinematics, SceneState& shown) const {
  const Contact& contact = frame.record.nearest;
  if (plant_->reach(frame.record.pose, Vec6::Zero(), true, kinematics) == Status::ok)
    shown.bars = plant_->bars(kinematics.pose);
  shown.pose = kinematics.pose;
  if (!player_) shown.hand = frame.hand.position;  // which no recording knows
  shown.force = frame.record.rendered.head<3>();
  shown.touching.clear();
  for (int i = 0; i < frame.contacts.count; ++i) {
    const bool held = i == 0 && frame.record.mode == RenderMode::contact;
    if (frame.drilled.spins) break;  // they would hide the work
    if (held || frame.contacts.contacts[i].gap <= 0.0) shown.touching.push_back(frame.contacts.contacts[i]);
  }
  shown.ghost.reset();
  if (frame.holding) {
    Kinematics reference = kinematics;
    const JointVector atRest = JointVector::Zero(plant_->joints());
    if (plant_->track(frame.reference, atRest, false, reference) == Status::ok) shown.ghost = reference.pose;
  } else if (contact.gap < 0.0 && !frame.drilled.spins) {
    shown.ghost = Pose{frame.record.pose.position - contact.gap * contact.normal, frame.record.pose.rotation};
  }
}

void Viewer::update(double now, const TimingNumbers& timing) {
  const double passed = now - updated_;
  now_ = updated_ = now;
  timing_ = timing;
  if (player_)
    takeRecording(passed);
  else
    takeRun();

  if (overlay_.settingsChanged) {
    overlay_.settingsChanged = false;
    rebuild(frame_.record.pose, frame_.hand, true);
  }
  if (overlay_.sceneAsked >= 0) {
    sceneIndex_ = overlay_.sceneAsked;
    overlay_.sceneAsked = -1;
    loadScene(sceneFiles_[static_cast<std::size_t>(sceneIndex_)]);
  }
  if (overlay_.rendererAsked >= 0) select(static_cast<RendererSlot>(std::exchange(overlay_.rendererAsked, -1)));
  if (overlay_.rightAsked >= 0) selectRight(static_cast<RendererSlot>(std::exchange(overlay_.rightAsked, -1)));
  if (!overlay_.problem.empty()) notify(std::exchange(overlay_.problem, {}));
  if (overlay_.spinAsked) spin(*std::exchange(overlay_.spinAsked, std::nullopt));
  std::vector<Action> actions;
  actions.swap(overlay_.actions);
  for (const Action action : actions) act(action);
  if (now > noticeEnd_) overlay_.notice.clear();
  followContact(passed);
  watch();

  fillShown(frame_, kinematics_, shown_);
  if (split_) fillShown(rightFrame_, rightKinematics_, rightShown_);
  limit_ = stiffnessLimit(kinematics_, plant_->limits().torque, frame_.record.nearest.normal, overlay_.settings.delay);

  layout_ = split_ ? layOutSplit(surface_.size(), surface_.scale(), overlay_.panels)
                   : layOut(surface_.size(), surface_.scale(), overlay_.panels, overlay_.charts,
                            player_ ? 0 : static_cast<int>(rendererNames_.size()));
  std::array<ChartPlace, kCharts> places;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Area& a = layout_.chart[i];
    const float title = kChartTitle * layout_.scale, side = 6 * layout_.scale, right = 20 * layout_.scale;
    places[i] = {side, layout_.charts.height - a.y - a.height, std::max(1.0f, a.width - side - right),
                 std::max(1.0f, a.height - title)};
  }
  charts_.update(places, layout_.scale, limit_.largestForce);
}

void Viewer::watch() {
  Seen::add(seen_.scenes, scene_.name);
  if (!player_) Seen::add(seen_.renderers, rendererNames_[indexOf(frame_.selected)]);
  for (const auto& [on, name] : badgesOf(frame_)) {
    if (on) Seen::add(seen_.badges, name);
  }
  Seen::add(seen_.tips, overlay_.tip);
  Seen::add(seen_.stiffnesses, stiffnessText(overlay_.settings.spring.stiffness));
  seen_.deepest = std::max(seen_.deepest, -frame_.record.nearest.gap);
}

void Viewer::draw(bool picture) {
  if (builtScale_ != layout_.scale) {
    view_.build(shown_.bars, scene_, solids_, plane_, layout_.scale);
    if (split_) rightView_->build(rightShown_.bars, scene_, solids_, plane_, layout_.scale);
    builtScale_ = layout_.scale;
  }
  const auto seeFrom = [this](SceneState& shown, const Frame& frame) {
    shown.distance = camera_.distance;
    shown.eye = metres(camera_.eye());
    shown.watched = frame.record.nearest.point;
  };
  seeFrom(shown_, frame_);
  // There, blue is the left tool's.
  const auto shownIn = [this](SceneState shown) {
    if (split_) shown.ghost.reset();
    return shown;
  };
  view_.update(shownIn(shown_));
  const double aspect =
      static_cast<double>(layout_.scene.width) / std::max(1.0, static_cast<double>(layout_.scene.height));
  view_.look(camera_, aspect);
  if (split_) {
    seeFrom(rightShown_, rightFrame_);
    rightView_->update(shownIn(rightShown_));
    rightView_->look(camera_, aspect);
  }
  const std::vector<SolidLayer>* const layers = this->layers();
  const OverlayInput input{frame_,
                           player_.get(),
                           scene_.name,
                           plant_->name(),
                           device_.plugin.get(),
                           device_.surface ? &*device_.surface : nullptr,
                           torques_,
                           sceneNames_,
                           sceneIndex_,
                           limit_,
                           scene_.tool.parts[0].radius,
                           shown_.ghost.has_value(),
                           shown_.ghost ? shown_.ghost->position : Vec3::Zero(),
                           trail_,
                           timing_,
                           simulated_,
                           follows_ ? "follow" : cameraPresets()[static_cast<std::size_t>(preset_)].name,
                           !player_ && scene_.bur && layers != nullptr ? &*scene_.bur : nullptr,
                           layers,
                           burDepth(),
                           plane_.has_value(),
                           split_ ? &rightFrame_ : nullptr,
                           rightShown_.ghost.has_value(),
                           rightShown_.ghost ? rightShown_.ghost->position : Vec3::Zero(),
                           comparison_,
                           camera_,
                           tour_ ? now_ - tourBegin_ : -1.0,
                           recording_ ? simulated_ - recordingBegin_ : -1.0,
                           clip_};
  stage_.draw(
      layout_, [&] { drawOverlay(layout_, input, overlay_); }, picture);
}

}  // namespace enamel::viewer
