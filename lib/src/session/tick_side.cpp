// The part of a session that runs on the loop's thread: no allocation, lock, exception or I/O.
#include <algorithm>
#include <cmath>

#include "runtime/system_thread.hpp"
#include "session/impl.hpp"

namespace enamel {

using session::Mailbox;
using session::Touch;

namespace {

constexpr double kEndOfContact = 0.02;    // s without touching
constexpr double kCutEvent = 0.02;        // s between two events of a cut
constexpr int kSharedCutsPerTick = 4;     // at most, from each other session
constexpr double kCentringReach = 10e-3;  // m from the middle of the device: centring acts fully

bool isTouching(const LoopTick& tick, const Contact& contact) noexcept {
  return contact.gap <= 0.0 && tick.mode == RenderMode::contact;
}

}  // namespace

bool Session::Impl::exists(ObstacleId id) const noexcept {
  const auto slot = static_cast<std::size_t>(id.slot);
  return id.slot >= 0 && slot < world->generation.size() && id.generation != 0 &&
         world->generation[slot] == id.generation;
}

void Session::Impl::setEffect(const Vec6& wrench) noexcept {
  Vec6 ofTool = wrench;
  if (mapped) ofTool.head<3>() /= mapped->scale();
  if (!wrench.isZero(0.0)) stray();
  haptics->setEffect(ofTool);
}

void Session::Impl::spin(bool on) noexcept {
  spins = on;
  if (world->drill) world->drill->spin(on);
}

// stopRecording() closes the file.
void Session::Impl::endRecording() noexcept {
  if (recording == nullptr) return;
  recording = nullptr;
  SessionEvent event;
  event.kind = EventKind::recordingEnd;
  sendEvent(event);
}

// A replay cannot repeat this tick and those after it.
void Session::Impl::stray() noexcept {
  endRecording();
  strays.store(true, std::memory_order_relaxed);
}

void Session::Impl::applySharedCuts() noexcept {
  for (const auto& inbox : inboxes)
    for (int i = 0; i < kSharedCutsPerTick; ++i) {
      Mailbox::Cut& next = inbox->next;
      if (!inbox->isWaiting && !inbox->ring.pop(next)) break;
      const auto slot = static_cast<std::size_t>(next.cut.obstacle);
      inbox->isWaiting = slot >= world->revision.size() || next.revision > world->revision[slot];
      if (inbox->isWaiting) break;  // for a change that the other session has already made
      if (next.revision != world->revision[slot] || !world->solids[slot]) continue;
      stray();
      (void)world->solids[slot]->cut(next.cut.from, next.cut.to, next.cut.radius);
    }
}

// Movable obstacles get the momentum that the tools of other sessions gave them.
void Session::Impl::applySharedPushes() noexcept {
  for (const auto& inbox : inboxes)
    for (Mailbox::Push push; inbox->pushes.pop(push);)
      if (exists({push.slot, push.generation})) haptics->push(push.slot, push.impulse);
}

void Session::Impl::sharePushes() noexcept {
  if (outboxes.empty() || haptics->frame().age > 0) return;
  for (std::size_t i = 0; i < world->generation.size(); ++i) {
    const int slot = static_cast<int>(i);
    const SuspendedState* const state = haptics->scene().motion().suspended(slot);
    if (state == nullptr || state->wrench.isZero(0.0)) continue;
    for (const auto& outbox : outboxes)
      if (outbox) (void)outbox->pushes.push({world->generation[i], slot, period * state->wrench});
  }
}

void Session::Impl::before(Measurement& measurement) noexcept {
  began.store(system::clockNow(), std::memory_order_relaxed);
  queue.run();
  applySharedCuts();
  applySharedPushes();
  const int button = def.clutchButton;
  clutched = clutch || (button >= 0 && (measurement.buttons >> button & 1U) != 0);
  if (!enabled || clutched) measurement.enabled = false;
  if (def.beforeTick) {
    TickAccess access(*this, measurement);
    def.beforeTick(access);
  }
}

void Session::Impl::tick(const LoopTick& tick, const HapticTick& ticked) noexcept {
  const TickFrame& frame = ticked.frame();
  tickNumber = tick.number;
  tickTime = tick.measurement.time;
  if (recording != nullptr) recording->tick(tick, ticked);
  countTime(tick);
  watchDevice(tick);
  watchContacts(tick, frame);
  watchCuts(tick);
  sharePushes();
  publish(tick, frame);
  if (mapped) moveBase(frame);
}

// Clutch: keep the tool where it was while the hand moves. Centring: lead the hand back to the middle.
void Session::Impl::moveBase(const TickFrame& frame) noexcept {
  if (frame.age > 0 || frame.kinematics.q.size() == 0) return;
  const Vec3& base = mapped->map().base.position;
  const Vec3 tool = frame.kinematics.pose.position;
  if (clutched && !haptics->guard().engaged()) {
    if (!isFrozen) frozen = tool;
    isFrozen = true;
    mapped->moveBase(base + frozen - tool);
    return;
  }
  isFrozen = false;
  if (def.centring == 0.0 || frame.contacts.count > 0) return;
  const Vec3 fromMiddle = tool - base;  // in the scene
  const double reach = mapped->map().scale * kCentringReach, distance = fromMiddle.norm();
  const double way = def.centring * frame.kinematics.twist.head<3>().norm() * period;
  if (distance > 0.0) mapped->moveBase(base + way / std::max(distance, reach) * fromMiddle);
}

void Session::Impl::countTime(const LoopTick& tick) noexcept {
  const double time = tick.measurement.time;
  if (tick.measurement.age > 0) ++held;
  if (lastTime >= 0.0 && time > lastTime) {
    const auto passed = std::llround((time - lastTime) / period);
    if (passed > 1) {
      missed += static_cast<std::uint64_t>(passed - 1);
      SessionEvent event;
      event.kind = EventKind::missed;
      event.count = static_cast<std::uint64_t>(passed - 1);
      sendEvent(event);
    }
  }
  lastTime = time;
}

void Session::Impl::watchDevice(const LoopTick& tick) noexcept {
  SessionEvent event;
  const GuardReason now = haptics->guard().fault();
  if (now != GuardReason::none && now != fault) {
    event.kind = EventKind::guardStop;
    event.reason = now;
    sendEvent(event);
  }
  fault = now;
  const bool fails = isLostIn(tick.measurement, haptics->guard().options().period);
  if (fails != isLost) {
    event = SessionEvent{};
    event.kind = fails ? EventKind::deviceLost : EventKind::deviceBack;
    sendEvent(event);
  }
  isLost = fails;
}

void Session::Impl::watchContacts(const LoopTick& tick, const TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  const double time = tick.measurement.time;
  const bool isNew = frame.age == 0 && tick.status == Status::ok;
  Vec3 force = Vec3::Zero();  // at the hand, N
  if (isNew && frame.contacts.count > 0) force = scale() * wrenchOf(k, frame.command - k.gravity).head<3>();
  for (int i = 0; isNew && i < frame.contacts.count; ++i) {
    const Contact& contact = frame.contacts.contacts[static_cast<std::size_t>(i)];
    const auto slot = static_cast<std::size_t>(contact.obstacle);
    if (!isTouching(tick, contact) || slot >= world->generation.size()) continue;
    const ObstacleId id{contact.obstacle, world->generation[slot]};
    Touch* const end = touches.data() + touching;
    Touch* touch =
        std::find_if(touches.data(), end, [&](const Touch& t) { return t.obstacle == id && t.part == contact.part; });
    if (touch == end) {
      if (touching == touches.size()) continue;
      ++touching;
      *touch = Touch{id, contact.part, -1.0, 0.0, contact.point, contact.normal};
      SessionEvent event;
      event.kind = EventKind::contactBegin;
      event.obstacle = id;
      event.part = contact.part;
      event.point = contact.point;
      event.normal = contact.normal;
      event.speed = -contact.normal.dot(contactVelocity(k, contact));
      sendEvent(event);
    }
    if (touch->last == time) continue;  // the deepest contact of the part counts
    touch->last = time;
    touch->point = contact.point;
    touch->normal = contact.normal;
  }
  for (std::size_t i = 0; i < touching;) {
    Touch& touch = touches[i];
    touch.impulse += period * std::max(0.0, touch.normal.dot(force));
    if (exists(touch.obstacle) && time - touch.last < kEndOfContact && time >= touch.last) {
      ++i;
      continue;
    }
    SessionEvent event;
    event.kind = EventKind::contactEnd;
    event.obstacle = touch.obstacle;
    event.part = touch.part;
    event.point = touch.point;
    event.normal = touch.normal;
    event.impulse = touch.impulse;
    sendEvent(event);
    touches[i] = touches[--touching];
  }
}

void Session::Impl::watchCuts(const LoopTick& tick) noexcept {
  for (std::size_t i = 0; i < world->solids.size(); ++i)
    if (world->solids[i]) (void)world->changes[i]->sent.publish(*world->solids[i]);
  if (!world->drill) return;
  bool cuts = false;
  for (const SolidCut& cut : world->drill->lastCuts()) {
    if (cut.obstacle < 0 || tick.measurement.age > 0) continue;
    cuts = true;
    const auto slot = static_cast<std::size_t>(cut.obstacle);
    if (recording == nullptr) stray();  // a replay cuts whole solids
    cutObstacle = {cut.obstacle, world->generation[slot]};
    for (const auto& outbox : outboxes)
      if (outbox && !outbox->ring.push({world->revision[slot], cut})) ++lostCuts;
  }
  if (cuts) {
    const RemovedVolume& volume = world->drill->removed();
    for (std::size_t i = 0; i < removed.size(); ++i) {
      removed[i] += volume[i];
      unreported[i] += volume[i];
    }
  }
  const double time = tick.measurement.time;
  const bool isAny = std::any_of(unreported.begin(), unreported.end(), [](double volume) { return volume > 0.0; });
  if (!isAny || std::abs(time - lastCut) < kCutEvent) return;
  SessionEvent event;
  event.kind = EventKind::cut;
  event.obstacle = cutObstacle;
  event.removed = unreported;
  sendEvent(event);
  unreported = RemovedVolume{};
  lastCut = time;
}

void Session::Impl::sendEvent(SessionEvent event) noexcept {
  event.tick = tickNumber;
  event.time = tickTime;
  if (!events.push(event)) ++dropped;
}

void Session::Impl::publish(const LoopTick& tick, const TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  Snapshot& now = snapshots.next();
  now.tick = tick;
  now.tick.normalForce *= scale();
  now.contacts = frame.contacts;
  for (int i = 0; i < now.contacts.count; ++i)  // as stated
    scaleForces(now.contacts.contacts[static_cast<std::size_t>(i)].material, scale());
  now.wrench.setZero();
  const bool isKnown = tick.status == Status::ok || tick.status == Status::stopped;
  if (isKnown && k.gravity.size() > 0 && k.gravity.size() == frame.command.size()) {
    now.wrench = wrenchOf(k, frame.command - k.gravity);
    now.wrench.head<3>() *= scale();
  }
  if (mapped) now.base = mapped->map().base.position;
  now.fault = fault;
  now.enabled = tick.measurement.enabled;
  now.clutched = clutched;
  now.spins = spins;
  now.burTurns = world->drill ? world->drill->turns() : 0.0;
  now.burTorque = world->drill ? world->drill->load() : 0.0;
  now.burChatter = world->drill ? world->drill->chatter() : 0.0;
  now.removed = removed;
  now.missed = missed;
  now.held = held;
  now.unsent = refused;
  now.droppedEvents = dropped;
  now.lostCuts = lostCuts;
  snapshots.publish();
}

const TickFrame& TickAccess::frame() const noexcept { return session_.haptics->frame(); }

Status TickAccess::move(ObstacleId id, const Pose& pose, const Vec6& twist) noexcept {
  session_.stray();
  return !session_.exists(id) ? Status::ok : session_.world->scene.move(id.slot, pose, twist);
}

Status TickAccess::activate(ObstacleId id, bool active) noexcept {
  session_.stray();
  return !session_.exists(id) ? Status::ok : session_.world->scene.activate(id.slot, active);
}

void TickAccess::spin(bool on) noexcept { session_.spin(on); }

Status TickAccess::setEffect(const Vec6& wrench) noexcept {
  if (!wrench.allFinite()) return Status::notFinite;
  if (!isEffect(wrench)) return Status::outOfRange;
  session_.setEffect(wrench);
  return Status::ok;
}

Status TickAccess::setGripper(double force) noexcept {
  if (!std::isfinite(force)) return Status::notFinite;
  if (std::abs(force) > kLargestEffect) return Status::outOfRange;
  session_.haptics->setGripper(force);
  return Status::ok;
}

const char* toString(EventKind kind) noexcept {
  switch (kind) {
    case EventKind::contactBegin: return "contact begins";
    case EventKind::contactEnd: return "contact ends";
    case EventKind::guardStop: return "the guard stopped rendering";
    case EventKind::cut: return "material removed";
    case EventKind::missed: return "missed deadline";
    case EventKind::deviceLost: return "device lost";
    case EventKind::deviceBack: return "device back";
    case EventKind::recordingEnd: return "recording ended";
    case EventKind::unusualSize: return "unusual size of an obstacle: is its unit right?";
  }
  return "unknown event";
}

}  // namespace enamel
