#include "enamel/session/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "runtime/system_thread.hpp"
#include "session/impl.hpp"

namespace enamel {

using session::Group;
using session::Mailbox;
using session::Obstacles;
using session::SessionTool;
using session::World;
using Lock = std::unique_lock<std::mutex>;

namespace {

constexpr double kMostCentring = 0.5;

// The first obstacles of a session: those of its scene file.
std::shared_ptr<Group> groupOf(const SceneFile& file) {
  auto group = std::make_shared<Group>();
  // Ids of another session are very probably refused.
  group->lastGeneration = static_cast<std::uint32_t>(std::hash<Group*>()(group.get()) >> 4U) * 2654435761U >> 1U;
  group->maxForce = file.maxForce;
  Obstacles& all = group->obstacles;
  all.scene = file.scene;
  all.meshes = file.meshes;
  all.solids.assign(file.solids.begin(), file.solids.end());
  for (std::size_t i = 0; i < file.scene.obstacles().size(); ++i) all.generation.push_back(++group->lastGeneration);
  all.revision = all.generation;
  return group;
}

void requireNumber(double value, double low, double high, const char* name, const char* unit) {
  require(value >= low && value <= high, std::string("session: ") + name + " is " + formatNumber(value) +
                                             ", must be in " + formatNumber(low) + " to " + formatNumber(high) + unit);
}

}  // namespace

Session::Impl::Impl(const SessionDef& definition) : def(definition) {
  requireNumber(def.rate, 10.0, 1e5, "the rate", " Hz");
  requireNumber(def.centring, 0.0, kMostCentring, "centring", "");
  requireNumber(def.clutchButton, -1, 31, "the clutch button", "");
  require(def.maxForce >= 0.0,
          "session: the largest force is " + formatNumber(def.maxForce) + " N, must be at least 0");
  require(!def.sharesWith || def.scene.empty(), "session: a scene file and sharesWith exclude each other");
  require(def.device.empty() || !def.mechanism, "session: a device and a mechanism exclude each other");
  period = 1.0 / def.rate;
  if (isDeviceUrl(def.device)) {
    OpenDeviceOptions options;
    options.period = period;
    options.pluginFolder = def.pluginFolder;
    opened = openDevice(def.device, options);
    deviceFile = opened.file;
    deviceText = opened.text;
    device = opened.mechanism;
  } else if (def.mechanism) {
    device = def.mechanism;
  } else {
    deviceFile = def.device;
    deviceText = deviceFile.empty() ? std::string(nominalDeviceText()) : readFile(deviceFile);
    device = makeMechanism(parseDevice(deviceText, deviceFile));
  }
  if (def.map || def.clutchButton >= 0 || def.centring > 0.0)
    mapped = std::make_shared<MappedMechanism>(device, def.map.value_or(WorkspaceMap{}));
  join(def);

  const Mechanism& seen = mapped ? *mapped : *device;
  Kinematics atStart = seen.home();
  const Status startStatus =
      isRotation(start.rotation) ? seen.reach(start, Vec6::Zero(), false, atStart) : Status::outOfRange;
  const bool isOfDevice =
      startStatus == Status::notFinite && start.position.allFinite();  // checkMechanism() reports it
  require(startStatus == Status::ok || isOfDevice,
          std::string("session: the start pose of the tool is ") + toString(startStatus) +
              "; is it in metres, with a rotation matrix, and within the device's workspace?");
  checkMechanism(seen, start);
  choice = choose(def.renderer, def.parameters);
  GuardOptions guard = def.guard ? *def.guard : guardFor(*device, period);
  if (mapped) guard = toScene(guard, mapped->map());
  guard.period = period;
  guard.force = std::min(guard.force, def.maxForce / seen.scale());
  world = makeWorld(group->obstacles, {}, {}, tool_, true);
  solids = *world;
  haptics = std::make_unique<HapticTick>(seen, world->scene, tool_.tool, *choice.renderer, guard, start);
  if (const auto& guides = group->obstacles.scene.guides()) {
    double sum = 0.0;
    for (const Guide& guide : *guides) sum += guide.stiffness;
    if (const double most = haptics->guidance().largestStiffness(); sum > most)
      notes.push_back("guides: their stiffnesses add up to " + formatNumber(sum) +
                      " N/m and are reduced by one factor: the device permits " + formatNumber(std::floor(most)) +
                      " N/m");
  }
  world->tick.reset();
  haptics->attach(world->drill.get());
  ownTick.pose = haptics->frame().kinematics.pose;
  ownTick.requested = JointVector::Zero(device->joints());
  ownTick.command.effort = ownTick.requested;
  const Lock lock(group->mutex);
  for (Impl* member : group->members) {
    const auto there = std::make_shared<Mailbox>(), here = std::make_shared<Mailbox>();
    member->outboxes.push_back(here);
    inboxes.push_back(here);
    outboxes.push_back(there);
    member->inboxes.push_back(there);
  }
  group->members.push_back(this);
  for (std::size_t i = 0; i < group->obstacles.generation.size() && !def.sharesWith; ++i)
    checkSize({static_cast<int>(i), group->obstacles.generation[i]});
}

Session::Impl::~Impl() { leave(); }

// Load the obstacles, or share those of another session.
void Session::Impl::join(const SessionDef& definition) {
  tool_.tool = definition.tool.value_or(Tool{});
  tool_.bur = definition.bur;
  start = definition.start.value_or(mapped ? mapped->home().pose : device->home().pose);
  if (definition.sharesWith) {
    const Impl& other = *definition.sharesWith->impl_;
    group = other.group;
    const Lock lock(group->mutex);
    for (Impl* member : group->members)
      require(!member->hasRun, "session: sharesWith needs sessions that have not run yet");
    def.maxForce = std::min(def.maxForce, group->maxForce);
    return;
  }
  SceneFile file;
  if (!definition.scene.empty()) {
    sceneText = readFile(definition.scene);
    file = parseScene(sceneText, definition.scene);
    notes = file.notes;
    if (!definition.tool) tool_.tool = file.tool;
    if (!definition.tool && !definition.bur) tool_.bur = file.bur;
    if (!definition.start) start.position = file.start;
  }
  def.maxForce = std::min(def.maxForce, file.maxForce);
  group = groupOf(file);
}

Session::Impl::RendererChoice Session::Impl::choose(const std::string& name,
                                                    const std::map<std::string, std::string>& parameters) const {
  const RendererSource source = findRenderer(name, def.pluginFolder);
  if (!source.plugin) requireKnown(source.name, parameters);
  const std::shared_ptr<const Mechanism> seen = mapped ? mapped : device;
  RendererChoice chosen;
  chosen.parameters = parameters;
  if (opened.device && !source.plugin && source.name == kPositionControl && parameters.count("delay") == 0) {
    chosen.parameters["delay"] = std::to_string(opened.delay.low);
    chosen.parameters.emplace("delay-high", std::to_string(opened.delay.high));
  }
  chosen.renderer = source.plugin
                        ? makeRenderer(source.plugin, {deviceFile, deviceText, def.scene, sceneText, chosen.parameters})
                        : makeLinked(source.name, chosen.parameters, seen, period);
  chosen.name = source.name;
  chosen.plugin = source.plugin ? source.plugin->path() : "";
  return chosen;
}

// The other sessions of the group no longer send their cuts here.
void Session::Impl::leave() noexcept {
  const Lock lock(group->mutex);
  group->members.erase(std::remove(group->members.begin(), group->members.end(), this), group->members.end());
  for (Impl* member : group->members)
    member->post([member, mine = inboxes]() noexcept {  // `mine` keeps them: nothing is freed here
      for (auto& outbox : member->outboxes)
        if (std::find(mine.begin(), mine.end(), outbox) != mine.end()) outbox.reset();
    });
}

// Wait until the loop has made all changes.
void Session::Impl::awaitLoop() const {
  const auto begin = std::chrono::steady_clock::now();
  for (queue.collect(); !queue.isEmpty(); queue.collect()) {
    require(std::chrono::steady_clock::now() - begin < std::chrono::seconds(1),
            "session: the loop does not make the changes that are waiting; call tick(), or stop()");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// Lock out other callers. The loop must not wait: it has TickAccess.
std::unique_lock<std::mutex> Session::Impl::lock() const {
  if (isThreaded() && isLoop())
    throw Error("session: a function of the session was called in beforeTick or in a hand; use TickAccess there");
  return std::unique_lock<std::mutex>(group->mutex);
}

void Session::Impl::requireRoom() {
  queue.collect();
  require(queue.hasRoom(), "session: " + std::to_string(session::WorkQueue::kCapacity) +
                               " changes are waiting: the loop does not run; call tick(), or stop()");
}

// The ticks run on this thread, or as soon as the thread of start() begins, on that one.
void Session::Impl::enterLoop(Loop kind) {
  hasRun = true;
  lastTime = -1.0;
  for (const auto& inbox : inboxes)
    for (Mailbox::Push old; inbox->pushes.pop(old);) continue;
  began.store(system::clockNow(), std::memory_order_relaxed);
  atStart();
  runs.store(kind, std::memory_order_release);
}

void Session::Impl::leaveLoop() noexcept {
  runs.store(Loop::none, std::memory_order_release);
  loopThread.store({}, std::memory_order_relaxed);
}

std::size_t Session::Impl::slotOf(ObstacleId id) const {
  const std::vector<std::uint32_t>& generation = group->obstacles.generation;
  const auto slot = static_cast<std::size_t>(id.slot);
  if (id.slot < 0 || slot >= generation.size() || id.generation == 0 || generation[slot] != id.generation)
    throw Error("session: no obstacle has slot " + std::to_string(id.slot) + " and generation " +
                std::to_string(id.generation) + ": it was removed, or it belongs to another session");
  return slot;
}

// Hand a world over to the loop.
void Session::Impl::enter(std::unique_ptr<World> next) {
  const bool isFirst = sceneText.empty() && !hasRun;  // without a scene file, the obstacles are added one by one
  solids = *next;
  post([this, isFirst, next = std::move(next)]() mutable noexcept {
    if (!isFirst) stray();
    session::exchange(*haptics, world, next);
    spin(spins);
  });
}

// Make `next` the obstacles of all sessions of the group.
void Session::Impl::changeObstacles(Obstacles next) {
  std::vector<std::unique_ptr<World>> worlds;
  for (Impl* member : group->members) {
    member->requireRoom();
    worlds.push_back(session::makeWorld(next, group->obstacles, member->solids, member->tool_, false));
  }
  for (std::size_t i = 0; i < worlds.size(); ++i) group->members[i]->enter(std::move(worlds[i]));
  group->obstacles = std::move(next);
}

void Session::Impl::changeObstacle(ObstacleId id, const std::function<void(Obstacle&)>& change) {
  const std::unique_lock<std::mutex> exclusive = lock();
  const std::size_t slot = slotOf(id);
  Obstacles next = group->obstacles;
  Obstacle changed = next.scene.obstacles()[slot];
  change(changed);
  next.scene.replace(id.slot, std::move(changed));
  changeObstacles(std::move(next));
}

// Report a size that suggests another unit. Nothing is reported if 1024 changes are waiting.
void Session::Impl::checkSize(ObstacleId id) {
  SessionEvent event;
  event.kind = EventKind::unusualSize;
  event.obstacle = id;
  event.extent = unusualSize(group->obstacles.scene.obstacles()[static_cast<std::size_t>(id.slot)], scale());
  if (event.extent > 0.0 && queue.hasRoom()) post([this, event]() noexcept { sendEvent(event); });
}

void Session::Impl::select(RendererChoice next) {
  next.renderer->activate(period);  // may take long: before other callers have to wait
  const Lock lock(group->mutex);
  requireRoom();
  std::swap(choice, next);
  post([this, renderer = choice.renderer.get(), old = std::move(next.renderer)]() noexcept {
    endRecording();
    haptics->select(*renderer);
  });
}

Session::Session(const SessionDef& def) : impl_(std::make_unique<Impl>(def)) {}

Session::~Session() { stop(); }

void Session::startOpened() {
  const std::string& url = impl_->def.device;
  require(impl_->opened.device != nullptr,
          "session: startOpened() needs a URL as SessionDef::device, such as virtual:FILE");
  {
    const Lock lock = impl_->lock();
    require(!impl_->isLive(), "session: it is already running; call stop() first");
    // A virtual device begins at rest at the start of the tool. Others are where the user's hand is.
    if (parseDeviceUrl(url).scheme == kVirtualScheme) {
      OpenDeviceOptions options;
      options.period = impl_->period;
      options.start = start();
      impl_->opened = openDevice(url, options);
    }
  }
  start(*impl_->opened.device);
}

void Session::start(HapticDevice& haptic) {
  const Lock lock = impl_->lock();
  require(!impl_->isLive(), "session: it is already running; call stop() first");
  HapticLoopOptions options;
  options.sink = impl_.get();
  options.period = impl_->def.poll;
  if (options.period == 0.0 && &haptic == impl_->opened.device.get()) options.period = impl_->opened.poll;
  options.priority = impl_->def.priority;
  options.lockMemory = impl_->def.lockMemory;
  impl_->enterLoop(Impl::Loop::threaded);
  try {
    impl_->loop = std::make_unique<HapticLoop>(haptic, *impl_->haptics, options);
  } catch (...) {
    impl_->leaveLoop();
    throw;
  }
  std::thread::id starting = std::this_thread::get_id();  // it measured; from here on it is a caller again
  impl_->loopThread.compare_exchange_strong(starting, {});
}

void Session::start(std::unique_ptr<HapticDevice> haptic) {
  require(haptic != nullptr, "session: the device is null");
  start(*haptic);
  const Lock lock = impl_->lock();
  impl_->owned = std::move(haptic);
}

void Session::stop() noexcept {
  if (impl_->isThreaded() && impl_->isLoop()) return;  // the loop cannot wait for itself
  const Lock lock = impl_->lock();
  impl_->loop.reset();
  impl_->leaveLoop();
  impl_->queue.run();
  impl_->queue.collect();
}

bool Session::isRunning() const noexcept { return impl_->isLive(); }

Status Session::tick(const Measurement& measurement, Command& command) noexcept {
  Impl& s = *impl_;
  if (s.isThreaded()) {  // the loop of start() runs the ticks
    command.effort = JointVector::Zero(s.device->joints());
    return Status::inactive;
  }
  if (!s.isLive()) {
    const Lock lock = s.lock();
    s.enterLoop(Impl::Loop::own);
  }
  LoopTick& tick = s.ownTick;
  tick.measurement = measurement;
  s.before(tick.measurement);
  tick.status = (*s.haptics)(tick.measurement, command);
  tick.command = command;
  describe(*s.haptics, tick);
  s.tick(tick, *s.haptics);
  ++tick.number;
  tick.reset = false;
  return tick.status;
}

Snapshot Session::snapshot() const {
  const Lock lock = impl_->lock();
  impl_->snapshots.refresh();
  Snapshot now = impl_->snapshots.latest();
  if (impl_->isLive())
    now.sinceTick = 1e-9 * static_cast<double>(system::clockNow() - impl_->began.load(std::memory_order_relaxed));
  return now;
}

bool Session::nextEvent(SessionEvent& event) {
  const Lock lock = impl_->lock();
  return impl_->events.pop(event);
}

void Session::setTool(const Tool& tool, const std::optional<Bur>& bur) {
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  const SessionTool next{tool, bur};
  const Obstacles& all = impl_->group->obstacles;
  std::unique_ptr<World> world = session::makeWorld(all, all, impl_->solids, next, true);
  impl_->tool_ = next;
  impl_->enter(std::move(world));
}

void Session::setRenderer(const std::string& name, const std::map<std::string, std::string>& parameters) {
  impl_->select(impl_->choose(name, parameters));
}

void Session::setRenderer(std::unique_ptr<Renderer> renderer) {
  require(renderer != nullptr, "session: the renderer is null");
  Impl::RendererChoice own;
  own.renderer = std::move(renderer);
  impl_->select(std::move(own));
}

void Session::setEffect(const Vec6& wrench) {
  require(isEffect(wrench),
          "session: the effect must be finite and at most " + formatNumber(kLargestEffect) + " N and N m");
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  impl_->post([s = impl_.get(), wrench]() noexcept { s->setEffect(wrench); });
}

void Session::setGripper(double force) {
  require(std::abs(force) <= kLargestEffect,
          "session: the force of the gripper must be finite and at most " + formatNumber(kLargestEffect) + " N");
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  impl_->post([s = impl_.get(), force]() noexcept { s->haptics->setGripper(force); });
}

void Session::spin(bool on) {
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  impl_->post([s = impl_.get(), on]() noexcept { s->spin(on); });
}

void Session::clutch(bool on) {
  require(impl_->mapped != nullptr, "session: a clutch needs a workspace map in the definition");
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  impl_->post([s = impl_.get(), on]() noexcept { s->clutch = on; });
}

void Session::enable(bool on) {
  const Lock lock = impl_->lock();
  impl_->requireRoom();
  impl_->post([s = impl_.get(), on]() noexcept { s->enabled = on; });
}

void Session::reset() {
  const Lock lock = impl_->lock();
  if (impl_->loop) return (void)impl_->loop->reset();  // if 16 resets are waiting, one more changes nothing
  impl_->requireRoom();
  impl_->post([s = impl_.get()]() noexcept {
    s->haptics->reset();
    s->ownTick.reset = true;
  });
}

const Mechanism& Session::mechanism() const noexcept { return *impl_->device; }
double Session::period() const noexcept { return impl_->period; }
const std::vector<std::string>& Session::notes() const noexcept { return impl_->notes; }
const OpenedDevice& Session::opened() const noexcept { return impl_->opened; }
const HapticTick& Session::haptics() const noexcept { return *impl_->haptics; }
const HapticLoop* Session::loop() const noexcept { return impl_->loop.get(); }
Pose Session::start() const noexcept { return impl_->mapped ? impl_->mapped->toDevice(impl_->start) : impl_->start; }

std::unique_ptr<SimulatedDevice> makeVirtualDevice(const Session& session, WrenchFunction hand) {
  VirtualDeviceSetup setup;
  setup.start = session.start();
  setup.period = session.period();
  if (!hand) hand = pressingHand(setup.start);
  return std::make_unique<SimulatedDevice>(session.mechanism(), setup, std::move(hand), true);
}

}  // namespace enamel
