#include "experiment.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/control/tuning.hpp"
#include "enamel/sim/plant_maker.hpp"

namespace enamel::viewer {
namespace {

constexpr int kApproachLimit = 1500;           // ticks
constexpr double kThere = 2e-4, kSlow = 5e-3;  // m and m/s: end of an approach
constexpr int kRestWatched = static_cast<int>(ImpactMonitor::kRestWindow / kPeriod + 0.5);

LoopSetup loopSetup(const Settings& settings, const SceneFile& scene, const Pose& start) {
  LoopSetup setup;
  setup.start = start;
  setup.scene = scene.scene;
  setup.tool = scene.tool;
  setup.encoders = settings.encoders;
  setup.delay = settings.delay;
  setup.period = kPeriod;
  setup.force = scene.maxForce;
  return setup;
}

}  // namespace

StiffnessLimit stiffnessLimit(const Kinematics& plant, const JointVector& maxTorque, const Vec3& normal,
                              const Delay& delay) noexcept {
  const double mass = effectiveMass(plant, plant.pose.position, normal);
  const double largest = largestForce(plant, maxTorque, plant.pose.position, normal);
  return {firstImpactLimit(mass, kPeriod, delay.high, kTestForce, largest, kTestPreload), largest};
}

std::optional<DepthRatio> ratioOf(const TestPush& left, const TestPush& right) noexcept {
  for (const TestPush* const one : {&left, &right})
    if (!one->made || one->verdict != FirstImpactVerdict::measured) return std::nullopt;
  const std::size_t deeper = right.deepest > left.deepest ? 1 : 0;
  const double most = std::max({left.deepest, right.deepest, DepthRatio::kLeast});
  const double least = std::min(left.deepest, right.deepest);
  return DepthRatio{deeper, most / std::max(least, DepthRatio::kLeast), least < DepthRatio::kLeast};
}

Experiment::Experiment(const ServoedDevice& device, const Settings& settings, const SceneFile& scene, const Pose& start,
                       const Hand& hand, RendererSlot slot, std::shared_ptr<DrilledSolids> drilled)
    : settings_(settings),
      model_(makeMechanism(modelFor(kClosedForm, device.parameters))),
      plant_(makeMechanism(changed(device.parameters, settings))),
      random_(1, 0),
      servo_(positionControlFor(*model_, kPeriod, settings.delay.low, settings.delay.high)),
      hold_(device.gain, kPeriod, settings.hold),
      spring_(settings.spring),
      passive_(std::make_unique<ImpedanceRenderer>(settings.spring)),
      plugin_(device.plugin ? makeRenderer(device.plugin, device.pluginSetup) : nullptr),
      switched_([&] {
        Switched::Renderers renderers{&servo_, &spring_, &hold_, &passive_, nullptr};
        if (plugin_) renderers[indexOf(slotOf(*device.plugin))] = plugin_.get();
        return renderers;
      }()),
      loop_(*plant_, *model_, switched_, loopSetup(settings, scene, start)),
      drilledSolids_(drilled ? std::move(drilled) : std::make_shared<DrilledSolids>(scene)) {
  if (scene.bur) loop_.attach(&drill_.emplace(scene.tool, scene.solids, *scene.bur));
  static_cast<LoopSetup&>(push_) = loopSetup(settings, scene, start);
  push_.hand.force = kTestForce;
  push_.hand.preload = kTestPreload;
  push_.hand.noise = settings.noise;
  frame_.hand = hand;
  frame_.record.pose = start;
  frame_.record.torque = plant_->home().gravity;
  if (drilledSolids_.use_count() == 1) look();  // no other experiment cuts the solids
  select(slot);
}

std::shared_ptr<Recorder> Experiment::recordTo(const std::string& path, RecordingHeader header) {
  recorder_ = std::make_shared<Recorder>(path, std::move(header), loop_.hapticTick());
  isReset_ = false;  // the select() of the constructor does not count
  return recorder_;
}

void Experiment::look() noexcept {
  fillDrillState();
  if (frame_.record.nearest.part < 0)
    frame_.record.nearest = nearestContact(loop_.scene(), loop_.tool(), frame_.record.pose, nullptr);
  frame_.readout = readoutOf(frame_.record);
}

void Experiment::spin(bool on) noexcept {
  if (!drill_) return;
  drill_->spin(on);
  if (on) drilledSolids_->beginStroke();
  fillDrillState();
}

void Experiment::undo() noexcept {
  if (!drill_) return;
  drilledSolids_->undo();
  if (drill_->spins()) drilledSolids_->beginStroke();
  fillDrillState();
}

void Experiment::restore() noexcept {
  drilledSolids_->restore();
  if (drill_ && drill_->spins()) drilledSolids_->beginStroke();
  fillDrillState();
}

void Experiment::fillDrillState() noexcept {
  if (drill_)
    frame_.drilled = {drill_->spins(),
                      drill_->turns(),
                      drill_->feed(),
                      drill_->chatter(),
                      drill_->chatterFrequency(),
                      drilledSolids_->removed(),
                      drilledSolids_->strokes()};
}

void Experiment::select(RendererSlot slot) noexcept {
  frame_.selected = slot;
  switched_.select(slot);
  if (loop_.guard().fault() != GuardReason::none) loop_.reset();
  isReset_ = true;
  if (phase_ != Phase::none) setGrip(gripBefore_);
  phase_ = Phase::none;
}

void Experiment::setGrip(const Grip& grip) noexcept {
  // Keep the force: move the hand to the position where the new springs give it.
  const Vec3 tool = frame_.record.pose.position;
  const Vec3 ratio = stiffnessOf(frame_.hand.grip).cwiseQuotient(stiffnessOf(grip));
  frame_.hand.position = tool + ratio.cwiseProduct(frame_.hand.position - tool);
  frame_.hand.target = tool + ratio.cwiseProduct(frame_.hand.target - tool);
  frame_.hand.grip = grip;
}

// Push upright, on the surface nearest to the hand's target; in contact, nearest to the tool.
void Experiment::startTestPush() noexcept {
  if (phase_ == Phase::none) gripBefore_ = frame_.hand.grip;
  push_.start = Pose();
  push_.start.position = frame_.record.nearest.gap > 0.0 ? frame_.hand.target : frame_.record.pose.position;
  phase_ = Phase::approach;
  phaseTicks_ = 0;
  if (!placeOnSurface(push_)) return endTestPush(FirstImpactVerdict::noStep);
  setGrip(kFirmGrip);
}

bool Experiment::isThere() const noexcept {
  if (phase_ != Phase::approach) return false;
  const bool near = (frame_.record.pose.position - push_.start.position).norm() < kThere &&
                    frame_.record.twist.head<3>().norm() < kSlow;
  return near || phaseTicks_ >= kApproachLimit;
}

// The hand moves the tool to the surface. There the push starts from rest in a restarted loop, independent of what
// happened before.
void Experiment::advanceTestPush(bool mayBegin) noexcept {
  if (phase_ != Phase::approach) return;
  ++phaseTicks_;
  frame_.hand.target =
      push_.start.position - kTestPreload * push_.hand.normal.cwiseQuotient(stiffnessOf(frame_.hand.grip));
  if (!mayBegin || !isThere()) return;
  if (loop_.restart(push_.start) != Status::ok) return endTestPush(FirstImpactVerdict::noStep);
  isReset_ = true;
  phase_ = Phase::push;
  pusher_ = SimulatedHand(push_);
  Kinematics known;
  carried_.setZero();
  if (model_->reach(push_.start, Vec6::Zero(), false, known) == Status::ok)
    carried_ = wrenchOf(known, loop_.device().kinematics().gravity - known.gravity);
  impact_ = ImpactMonitor(kPeriod);
  testDrift_ = testDeepest_ = 0.0;
  conditions_.beginBlock();
}

// Judge the push as the study's MetricsCollector does.
void Experiment::watchTestPush() noexcept {
  if (phase_ != Phase::push) return;
  const TickRecord& record = frame_.record;
  const PushTimes times = timesOf(push_);
  const Vec3& normal = push_.hand.normal;
  const Vec3 moved = record.pose.position - push_.start.position;
  testDrift_ = std::max(testDrift_, (moved - normal.dot(moved) * normal).norm());
  testDeepest_ = std::max(testDeepest_, -record.nearest.gap);
  const ImpactTick tick{record.nearest.gap, record.gapRate,   -normal.dot(record.handWrench.head<3>()),
                        testDrift_,         record.saturated, record.torque.cwiseQuotient(plant_->limits().effort)};
  if (record.tick >= times.onset)
    impact_.push(tick);
  else if (record.tick + kRestWatched >= times.onset)
    impact_.rest(tick);
  if (isFault(record.guard))
    endTestPush(FirstImpactVerdict::unstable, Status::stopped);
  else if (record.tick + 1 >= times.end)
    endTestPush(impact_.verdict());
}

void Experiment::endTestPush(FirstImpactVerdict verdict, Status status) noexcept {
  TestPush& test = frame_.tests[indexOf(frame_.selected)];
  test = TestPush();
  test.made = true;
  test.verdict = verdict;
  test.status = status;
  test.settings = settings_;
  Kinematics inertia = loop_.device().kinematics();
  if (plant_->reach(push_.start, Vec6::Zero(), true, inertia) == Status::ok)
    test.limit = stiffnessLimit(inertia, plant_->limits().effort, push_.hand.normal, settings_.delay).stiffness;
  if (impact_.deepest() > 0.0) test.depthStiffness = kTestForce / impact_.deepest();
  test.deepest = testDeepest_;
  if (verdict == FirstImpactVerdict::measured) {
    test.stiffness = impact_.stiffness();
    test.depth = impact_.depth();
    test.force = impact_.force();
    test.preload = impact_.preload();
  } else if (verdict == FirstImpactVerdict::slips) {
    test.amount = testDrift_;
  } else if (verdict == FirstImpactVerdict::unstable) {
    test.amount = 0.5 * conditions_.forceRange();
  }
  phase_ = Phase::none;
  setGrip(gripBefore_);
}

void Experiment::tick() noexcept {
  if (frame_.plant != Status::ok) return;
  advanceTestPush(true);
  moveOwnHand();
  tickHeld();
}

// During a push the hand stays where it was, because no spring pushes.
void Experiment::moveOwnHand() noexcept {
  if (phase_ == Phase::push) return;
  keepWithinReach(frame_.hand, frame_.record.pose.position);
  moveHand(frame_.hand, kPeriod);
}

void Experiment::tickTogether(Experiment& left, Experiment& right) noexcept {
  if (left.frame_.plant != Status::ok || right.frame_.plant != Status::ok) return;
  if (left.phase_ != Phase::none || right.phase_ != Phase::none) {
    const bool waits = left.phase_ == Phase::approach && right.phase_ == Phase::approach;
    const bool mayBegin = !waits || (left.isThere() && right.isThere());
    for (Experiment* const one : {&left, &right}) {
      one->advanceTestPush(mayBegin);
      one->moveOwnHand();
    }
  } else {
    Hand& hand = left.frame_.hand;
    for (const Experiment* const one : {&left, &right}) keepWithinReach(hand, one->frame_.record.pose.position);
    moveHand(hand, kPeriod);
    right.frame_.hand = hand;
  }
  left.tickHeld();
  right.tickHeld();
}

// Run one tick with the hand at its present position.
void Experiment::tickHeld() noexcept {
  TickRecord& record = frame_.record;
  if (phase_ == Phase::push) {
    pusher_.hold(loop_.device().tick());
    const auto push = [this](double time, const Pose& pose, const Vec6& twist) noexcept -> Vec6 {
      return pusher_(time, pose, twist) + carried_;
    };
    frame_.plant = loop_.tick(push, record);
    if (frame_.plant != Status::ok) {
      record.pose = push_.start;  // restart position
      endTestPush(FirstImpactVerdict::unstable, frame_.plant);
      frame_.plant = loop_.restart(push_.start);
    }
  } else {
    Vec3 tremor = Vec3::Zero();
    if (settings_.noise > 0.0)
      tremor = -settings_.noise * random_.normal(RandomStream::Purpose::noise, record.tick + 1) * record.nearest.normal;
    frame_.plant = loop_.tick(HandWrench(frame_.hand, loop_.device().time(), tremor), record);
    if (frame_.plant != Status::ok && phase_ == Phase::approach) {  // left the workspace on its way: place it
      frame_.plant = loop_.restart(push_.start);
      record.pose = push_.start;
      record.twist.setZero();
      frame_.hand.position = frame_.hand.target;
      frame_.hand.velocity.setZero();
    }
  }
  if (recorder_ && frame_.plant == Status::ok)
    recorder_->add(recorded_++, loop_.measurement(), loop_.hapticTick(), loop_.command(), record.status, isReset_);
  isReset_ = false;
  ++frame_.guardTicks[static_cast<std::size_t>(record.guard)];
  frame_.contacts = loop_.frame().contacts;
  frame_.movable = movablePoses(loop_.hapticTick().scene().scene());
  frame_.control = servo_.state();
  frame_.holding = frame_.selected == RendererSlot::hold && hold_.holding();
  frame_.reference = hold_.reference();
  if (drill_) {
    drilledSolids_->add(drill_->removed());
    fillDrillState();
  }
  watchTestPush();
  frame_.conditions = conditions_.add(record, plant_->limits().effort);
  frame_.readout = readouts_.add(record);
  frame_.testing = phase_ != Phase::none;
}

void Experiment::Switched::select(RendererSlot slot) noexcept {
  selected_ = static_cast<std::uint8_t>(slot);
  renderers_[selected_]->reset();
}

void Experiment::Switched::prepare(double period) {
  for (Renderer* renderer : renderers_)
    if (renderer != nullptr) renderer->activate(period);
}

Status Experiment::Switched::render(const TickFrame& input, TickOutput& output) noexcept {
  return renderers_[selected_]->step(input, output);
}

void Experiment::Switched::resetState() noexcept {
  for (Renderer* renderer : renderers_)
    if (renderer != nullptr) renderer->reset();
}

}  // namespace enamel::viewer
