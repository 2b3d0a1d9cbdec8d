#include "viewer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "overlay.hpp"
#include "overlay_parts.hpp"
#include "program/plugin_folder.hpp"
#include "program/recorded.hpp"
#include "scan.hpp"

namespace enamel::viewer {
namespace {

constexpr double kNotice = 3.0, kNoticeByte = 0.03;  // s, and per letter
constexpr std::size_t kTrail = 150;                  // ticks
constexpr double kGhost = 5e-5;                      // m: at smaller depths the reference pose is not drawn

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

std::unique_ptr<LiveDevice> connect(const Options& options) {
  if (!options.play.empty() || !isDeviceUrl(options.device)) return nullptr;
  if (isScan(options.scene)) throw Error(options.scene + ": a scan needs the simulated device (--device FILE)");
  SessionDef def;
  def.device = options.device;
  def.scene = options.scene;
  def.renderer = options.renderer;
  def.parameters = options.pluginParameters;
  def.pluginFolder = app::pluginFolder();
  def.maxForce = options.maxForce;
  return std::make_unique<LiveDevice>(def, options.begin);
}

ServoedDevice deviceOf(const Player* player, const LiveDevice* live, const Options& options) {
  ServoedDevice device;
  if (player != nullptr || live != nullptr) {
    device.parameters = player != nullptr ? player->parameters() : live->parameters();
    return device;
  }
  device = loadServoedDevice(options.device, options.gain);
  device.plugin = options.plugin;
  device.pluginSetup = {options.device, "", options.scene, "", options.pluginParameters};
  return device;
}

// Copy the solids before any cut. The first one may have a target.
std::vector<SolidCopy> copiesOf(const SceneFile& scene, const std::string& target) {
  std::vector<SolidCopy> copies;
  for (const auto& solid : scene.solids) copies.push_back(solid ? copyOf(*solid) : SolidCopy());
  if (target.empty()) return copies;
  const auto first = std::find_if(copies.begin(), copies.end(), [](const SolidCopy& copy) { return copy.uncut; });
  if (first == copies.end()) throw Error("--target " + target + " needs a scene with a solid");
  const TriangleMesh mesh = loadMesh(target, 1e-3);
  if (!inspect(mesh).watertight) throw Error(target + ": the target of a preparation must be closed");
  first->target = std::make_shared<MeshModel>(mesh);
  return copies;
}

std::unique_ptr<Runner> firstRunner(const ServoedDevice& device, const SceneFile& scene, RendererSlot slot,
                                    const std::shared_ptr<DrilledSolids>& drilled) {
  Pose start;
  start.position = scene.start;
  return std::make_unique<Runner>(
      std::make_unique<Experiment>(device, Settings{}, scene, start, handAt(scene.start, kFirmGrip), slot, drilled));
}

// Return the text of a scene file, or of the scene that is made for a scan. `note`: about the scan.
std::string sceneTextOf(const std::string& path, const ScanPlacement& placement, std::string& note) {
  if (!isScan(path)) return readFile(path);
  ScanScene scan = sceneOfScan(path, placement);
  note = scan.note;
  return scan.text;
}

// Describe the experiment in a recording's header.
RecordingHeader headerOf(const ServoedDevice& device, const std::string& scenePath, const std::string& sceneText,
                         const SceneFile& scene, const Pose& start, RendererSlot slot) {
  RecordingHeader header;
  header.deviceFile = std::filesystem::absolute(device.pluginSetup.devicePath).string();
  header.deviceText = readFile(header.deviceFile);
  header.sceneFile = std::filesystem::absolute(scenePath).string();
  header.sceneText = sceneText;
  header.start = start;
  const bool isPlugin = device.plugin && slotOf(*device.plugin) == slot;
  nameRenderer(rendererNames(device.plugin.get())[indexOf(slot)], isPlugin ? device.plugin->path() : "",
               isPlugin || slot != RendererSlot::positionControl
                   ? std::map<std::string, std::string>{}
                   : std::map<std::string, std::string>{{"drive", drivesOf(kClosedForm)}},
               scene.scene, header);
  return header;
}

}  // namespace

Viewer::Viewer(const Options& options, Surface& surface)
    : isHeadless_(options.headless),
      surface_(surface),
      player_(options.play.empty() ? nullptr : std::make_unique<Player>(options.play)),
      live_(connect(options)),
      device_(deviceOf(player_.get(), live_.get(), options)),
      rendererNames_(viewer::rendererNames(options.plugin.get())),
      plant_(makeMechanism(changed(device_.parameters, Settings{}))),
      torques_(*plant_),
      folder_(options.folder()),
      scenePath_(options.scene),
      sceneText_(player_ || live_ ? "" : sceneTextOf(options.scene, placement_, overlay_.scanNote)),
      scene_(player_ ? player_->scene()
             : live_ ? enamel::loadScene(options.scene)
                     : parseScene(sceneText_, options.scene)),
      renderers_(options.begin),
      drilledSolids_(std::make_shared<DrilledSolids>(scene_)),
      solids_(copiesOf(scene_, options.target)),
      runner_(player_ || live_ ? nullptr : firstRunner(device_, scene_, renderers_.selected, drilledSolids_)),
      canvas_(surface, existing(ENAMEL_VIEWER_FONT), existing(ENAMEL_VIEWER_FONT_BOLD)),
      charts_(canvas_.charts(), existing(ENAMEL_VIEWER_FONT), torques_,
              player_ ? player_->header().guard.period : kPeriod, player_ != nullptr),
      camera_(fieldCamera(scene_)) {
  left_.view.emplace(canvas_.scene(), canvas_.above());
  for (Pane* const pane : {&left_, &right_}) {
    pane->kinematics = plant_->home();
    pane->shown.bars = plant_->bars(pane->kinematics.pose);
  }
  left_.shown.chips = &bur_.chips();
  overlay_.sound = !options.headless && options.script.empty();
  if (player_) {
    if (!player_->notes().empty()) notify(player_->notes().front());
    return;
  }
  overlay_.sceneNotes = scene_.notes;
  if (live_) return;
  if (!overlay_.scanNote.empty()) notify(overlay_.scanNote);
  scenes_.addFolder(std::filesystem::path(dataFolder()) / "scenes");
  scenes_.addFolder(std::filesystem::absolute(options.scene).parent_path());
  scenes_.add(options.scene);
}

glm::dvec3 Viewer::tool() const { return millimetres(left_.frame.record.pose.position); }

glm::dvec3 Viewer::axis() const { return millimetres(left_.frame.record.pose.rotation.col(2)) / kMillimetres; }

glm::dvec3 Viewer::normal() const { return millimetres(left_.frame.record.nearest.normal) / kMillimetres; }

void Viewer::notify(const std::string& text) {
  DisplayHistory::add(history_.notices, text);
  overlay_.notice = text;
  noticeEnd_ = now_ + kNotice + kNoticeByte * static_cast<double>(text.size());
}

// Replace the experiment; the new one begins at rest at the tool's present pose.
void Viewer::rebuild(const Pose& start, const Hand& hand, bool keepTests, const std::string& record) {
  try {
    plant_ = makeMechanism(changed(device_.parameters, overlay_.settings));
    const auto make = [&](RendererSlot slot, std::shared_ptr<DrilledSolids> drilled) {
      return std::make_unique<Experiment>(device_, overlay_.settings, scene_, start, hand, slot, std::move(drilled));
    };
    auto left = make(renderers_.selected, drilledSolids_), right = split_ ? make(renderers_.right, nullptr) : nullptr;
    if (keepTests) {
      // Results of all renderers; the right renderer's come from its own side.
      auto tests = left_.frame.tests;
      const std::size_t slot = indexOf(right_.frame.selected);
      if (const TestPush& test = right_.frame.tests[slot]; test.made) tests[slot] = test;
      left->keepTests(tests);
      if (right) right->keepTests(tests);
    }
    if (!split_) right_.frame = Frame();
    if (!record.empty())
      recording_ = {
          left->recordTo(record, headerOf(device_, scenePath_, sceneText_, scene_, start, renderers_.selected)), record,
          simulated_};
    runner_->replace(std::move(left), std::move(right));
    if (spins_ && scene_.bur) send(RunnerCommand::Kind::spin, 1);
  } catch (const Error& error) {
    notify(error.what());
  }
}

void Viewer::startAgain(bool keepTests) {
  Pose start;
  start.position = scene_.start;
  motion_.endLine();
  right_.frame = Frame();
  rebuild(start, handAt(scene_.start, overlay_.grip), keepTests);
}

// Load a scene, or make one of a scan. On failure, notify the person and keep the present scene.
bool Viewer::loadScene(const std::string& path, const ScanPlacement& placement) {
  try {
    std::string note;
    const std::string text = sceneTextOf(path, placement, note);
    scene_ = parseScene(text, path);
    sceneText_ = text;
    placement_ = placement;
    overlay_.scanNote = note;
    motion_.endTour();
    scenePath_ = path;
    overlay_.sceneNotes = scene_.notes;
    drilledSolids_ = std::make_shared<DrilledSolids>(scene_);
    solids_ = copiesOf(scene_, "");
    plane_.reset();
    bur_.silence();
    for (const std::string& warning : scene_.notes) notify(warning);
    if (!note.empty()) notify(note);
    builtScale_ = 0.0f;
    camera_.setField(fieldCamera(scene_));
    if (split_ && scene_.bur) toggleSplit();
    comparison_.clear();
    startAgain();
    return true;
  } catch (const Error& error) {
    notify(error.what());
    return false;
  }
}

void Viewer::takeRun() {
  if (motion_.takePush(now_)) send(RunnerCommand::Kind::testPush);
  const std::optional<Vec3> target = motion_.target(now_);
  if (target && !(motion_.isTouring() && left_.frame.testing)) sendHand(RunnerCommand::Kind::handTo, *target);
  if (motion_.tourTime(now_) >= Tour::kLength) endTour(false);
  runner_->collect();
  if (recording_.recorder.use_count() == 1) notify(endRecording());
  left_.frame = runner_->frame();
  if (const Frame* right = runner_->secondFrame(); right != nullptr) right_.frame = *right;
  for (PairSample sample; runner_->nextPair(sample);) comparison_.add(sample);
  takeSolids();
  for (Sample sample; runner_->nextSample(sample);) {
    charts_.add(sample);
    trail_.push_back(sample.position);
    simulated_ += kPeriod;
  }
  if (trail_.size() > kTrail) trail_.erase(trail_.begin(), trail_.end() - static_cast<std::ptrdiff_t>(kTrail));
  const bool lost = runner_->secondFrame() != nullptr && right_.frame.plant != Status::ok;
  if (left_.frame.plant != Status::ok || lost) {
    notify("The tool left the workspace of the device: back to the start.");
    startAgain(true);
  }
}

// Take the cut bricks for picture and sound.
void Viewer::takeSolids() {
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (!solids_[i].uncut) continue;
    for (BrickChange change; live_ ? live_->takeChange(i, change) : drilledSolids_->takeChange(i, change);) {
      solids_[i].samples[static_cast<std::size_t>(change.brick)] = change.samples;
      left_.view->change(i, change.brick);
    }
  }
  if (!scene_.bur) return;
  const char* const trouble = bur_.update(left_.frame, scene_, solids_, overlay_.sound);
  left_.shown.burAngle = bur_.angle();
  if (trouble == nullptr || !overlay_.soundTrouble.empty()) return;
  overlay_.soundTrouble = std::string("No sound: ") + trouble + ".";
  std::fprintf(stderr, "enamel-viewer: no sound: %s\n", trouble);
  notify(overlay_.soundTrouble);
}

void Viewer::takeRecording(double passed) {
  player_->advance(passed);
  left_.frame = player_->frame();
  simulated_ = player_->seconds();
  // Align bins to the same ticks for every position: otherwise their extremes would flicker.
  constexpr int bin = Charts::History::kBinTicks, shown = Charts::History::kBins * bin;
  const auto now = static_cast<std::int64_t>(player_->position()), from = now / bin * bin - shown / 2;
  const std::vector<Sample> samples = player_->samples(from, shown + 1);  // one more completes the last bin
  charts_.clear();
  for (const Sample& sample : samples) charts_.add(sample);
  trail_.clear();
  for (std::int64_t at = now - static_cast<std::int64_t>(kTrail); at <= now; ++at)
    if (const Vec3& position = samples[static_cast<std::size_t>(at - from)].position; position.allFinite())
      trail_.push_back(position);
}

void Viewer::takeDevice() {
  left_.frame = live_->frame();
  for (Sample sample; live_->nextSample(sample);) {
    charts_.add(sample);
    trail_.push_back(sample.position);
    simulated_ += kPeriod;
  }
  if (trail_.size() > kTrail) trail_.erase(trail_.begin(), trail_.end() - static_cast<std::ptrdiff_t>(kTrail));
  const GuardReason fault = live_->snapshot().fault;
  if (fault != fault_ && fault != GuardReason::none)
    notify("Stopped by the guard: " + guardText(fault) + ". Backspace continues.");
  fault_ = fault;
  takeSolids();
}

// Perform the requests of the overlay.
void Viewer::takeRequests() {
  OverlayRequests& asked = overlay_.asked;
  if (std::exchange(asked.settings, false)) rebuild(left_.frame.record.pose, left_.frame.hand, true);
  if (asked.scene) loadScene(scenes_.choose(*std::exchange(asked.scene, std::nullopt)));
  if (asked.renderer) select(*std::exchange(asked.renderer, std::nullopt));
  if (asked.right) selectRight(*std::exchange(asked.right, std::nullopt));
  if (!asked.problem.empty()) notify(std::exchange(asked.problem, {}));
  if (asked.press) pressWith(*std::exchange(asked.press, std::nullopt));
  if (asked.spin) spin(*std::exchange(asked.spin, std::nullopt));
  for (const Action action : std::exchange(asked.actions, {})) act(action);
}

void Viewer::fillShown(Pane& pane) const {
  const Frame& frame = pane.frame;
  SceneState& shown = pane.shown;
  const Contact& contact = frame.record.nearest;
  if (plant_->reach(frame.record.pose, Vec6::Zero(), true, pane.kinematics) == Status::ok)
    shown.bars = plant_->bars(pane.kinematics.pose);
  shown.pose = pane.kinematics.pose;
  if (runner_) shown.hand = frame.hand.position;
  shown.force = frame.record.rendered.head<3>();
  shown.movable = frame.movable;
  shown.touching.clear();
  for (int i = 0; i < frame.contacts.count; ++i) {
    const bool held = i == 0 && frame.record.mode == RenderMode::contact;
    if (frame.drilled.spins) break;  // contacts would hide the drilled place
    if (held || frame.contacts.contacts[i].gap <= 0.0) shown.touching.push_back(frame.contacts.contacts[i]);
  }
  shown.ghost.reset();
  if (frame.holding) {
    Kinematics reference = pane.kinematics;
    const JointVector atRest = JointVector::Zero(plant_->joints());
    if (plant_->track(frame.reference, atRest, false, reference) == Status::ok) shown.ghost = reference.pose;
  } else if (contact.gap < -kGhost && !frame.drilled.spins) {
    shown.ghost = Pose{frame.record.pose.position - contact.gap * contact.normal, frame.record.pose.rotation};
  }
}

void Viewer::update(double now, const TimingNumbers& timing) {
  const double passed = now - updated_;
  now_ = updated_ = now;
  timing_ = timing;
  if (player_)
    takeRecording(passed);
  else if (live_)
    takeDevice();
  else
    takeRun();
  takeRequests();
  if (now > noticeEnd_) overlay_.notice.clear();
  const TickRecord& record = left_.frame.record;
  if (record.nearest.point.allFinite()) camera_.follow(millimetres(record.nearest.point), passed);
  noteShown();

  fillShown(left_);
  if (split_) fillShown(right_);
  limit_ = stiffnessLimit(left_.kinematics, plant_->limits().effort, record.nearest.normal, overlay_.settings.delay);
  layout_ = split_ ? layOutSplit(surface_.size(), surface_.scale(), overlay_.panels, motion_.isTouring())
                   : layOut(surface_.size(), surface_.scale(), overlay_.panels, overlay_.charts,
                            player_ ? 0
                            : live_ ? -1
                                    : static_cast<int>(rendererNames_.size()));
  placeCharts();
}

void Viewer::placeCharts() {
  const float title = kChartTitle * layout_.scale, side = 6 * layout_.scale, right = 20 * layout_.scale;
  std::array<Rect, kCharts> places;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Rect& a = layout_.chart[i];
    places[i] = {side, layout_.charts.height - a.y - a.height, std::max(1.0f, a.width - side - right),
                 std::max(1.0f, a.height - title)};
  }
  charts_.update(places, layout_.scale, limit_.largestForce);
}

void Viewer::noteShown() {
  const Frame& frame = left_.frame;
  DisplayHistory::add(history_.scenes, scene_.name);
  if (!player_) DisplayHistory::add(history_.renderers, rendererNames_[indexOf(frame.selected)]);
  for (const auto& [on, name] : badgesOf(frame)) {
    if (on) DisplayHistory::add(history_.badges, name);
  }
  DisplayHistory::add(history_.tips, overlay_.tip.text);
  for (const std::string& text : overlay_.readouts)
    if (text.find("\u00d7") != std::string::npos) DisplayHistory::add(history_.ratios, text);
  DisplayHistory::add(history_.stiffnesses, stiffnessText(overlay_.settings.spring.stiffness));
  history_.deepest = std::max(history_.deepest, -frame.record.nearest.gap);
}

void Viewer::drawPane(Pane& pane, double aspect) {
  const Camera& camera = camera_.camera();
  if (builtScale_ != layout_.scale) pane.view->build(pane.shown.bars, scene_, solids_, plane_, layout_.scale);
  SceneState shown = pane.shown;
  shown.distance = camera.distance;
  shown.eye = metres(camera.eye());
  shown.watched = pane.frame.record.nearest.point;
  if (split_) shown.ghost.reset();  // there, blue is the left tool's colour
  pane.view->update(shown);
  pane.view->look(camera, aspect);
}

void Viewer::draw(bool picture) {
  const double aspect =
      static_cast<double>(layout_.scene.width) / std::max(1.0, static_cast<double>(layout_.scene.height));
  drawPane(left_, aspect);
  if (split_) drawPane(right_, aspect);
  builtScale_ = layout_.scale;
  const OverlayInput input = overlayInput();
  canvas_.draw(
      layout_, [&] { drawOverlay(layout_, input, overlay_); }, picture);
}

OverlayInput Viewer::overlayInput() const {
  const auto toolOf = [](const Pane& pane) {
    const std::optional<Pose>& ghost = pane.shown.ghost;
    return ToolInput{pane.frame, ghost ? std::optional<Vec3>(ghost->position) : std::nullopt};
  };
  OverlayInput input{toolOf(left_),
                     std::nullopt,
                     player_.get(),
                     live_.get(),
                     {plant_->name(), torques_, limit_, device_.plugin.get()},
                     {scene_.name, scenes_.names(), scenes_.index(), scene_.tool.parts[0].radius, plane_.has_value()},
                     std::nullopt,
                     trail_,
                     comparison_,
                     camera_.camera(),
                     camera_.view(),
                     timing_,
                     {simulated_, motion_.tourTime(now_), records() ? simulated_ - recording_.begin : -1.0, clip_}};
  if (split_) input.right.emplace(toolOf(right_));
  if (const auto* layers = layersOf(solids_); !player_ && scene_.bur && layers != nullptr)
    input.bur.emplace(BurInput{*scene_.bur, *layers, burDepth(scene_, solids_, left_.frame.record.pose)});
  return input;
}

}  // namespace enamel::viewer
