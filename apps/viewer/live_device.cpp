#include "live_device.hpp"

#include "enamel/core/error.hpp"

namespace enamel::viewer {

LiveDevice::LiveDevice(SessionDef def, RendererSlot slot)
    : def_(std::move(def)), scene_(loadScene(def_.scene)), cache_(makeToolCache(scene_.scene, scene_.tool)) {
  bool hasTicked = false;
  def_.beforeTick = [this, hasTicked](TickAccess& access) mutable {
    if (const bool isPressed = (access.measurement().buttons & 1U) != 0; isPressed != isPressed_)
      access.spin(isPressed_ = isPressed);
    if (hasTicked) look(access.frame());
    hasTicked = true;
  };
  session_ = std::make_unique<Session>(def_);
  for (const Obstacle& obstacle : scene_.scene.obstacles()) obstacles_.push_back(session_->find(obstacle.name));
  parameters_ = parseDevice(session_->opened().text, session_->opened().file);
  largest_ = session_->mechanism().limits().effort;
  for (double& limit : largest_)
    if (limit == 0.0) limit = 1.0;
  frame_.selected = slot;
  frame_.record.pose = session_->start();
  frame_.record.torque = frame_.record.command = frame_.record.q = JointVector::Zero(largest_.size());
  frame_.record.nearest = nearestContact(scene_.scene, scene_.tool, frame_.record.pose, nullptr);
  frame_.readout = readoutOf(frame_.record);
  frames_.next() = frame_;
  frames_.publish();
  session_->startOpened();
}

const Frame& LiveDevice::frame() noexcept {
  frames_.refresh();
  return frames_.latest();
}

// Describe a tick as VirtualLoop does, with the pose that the device measured.
void LiveDevice::look(const TickFrame& tick) noexcept {
  TickRecord& r = frame_.record;
  ++r.tick;
  r.time = tick.time;
  r.torque = tick.command;
  describe(tick, tick.kinematics, session_->haptics().scene().scene(), scene_.tool, &cache_, r);
  ++frame_.guardTicks[static_cast<std::size_t>(r.guard)];
  frame_.contacts = tick.contacts;
  frame_.movable = movablePoses(session_->haptics().scene().scene());
  if (const Drill* const drill = session_->haptics().drill(); drill != nullptr) {
    frame_.drilled.spins = drill->spins();
    frame_.drilled.turns = drill->turns();
    frame_.drilled.feed = drill->feed();
    frame_.drilled.chatter = drill->chatter();
    frame_.drilled.pitch = drill->chatterFrequency();
    for (std::size_t i = 0; tick.age == 0 && i < drill->removed().size(); ++i)
      frame_.drilled.removed[i] += drill->removed()[i];
  }
  frame_.hand.target = frame_.hand.position = r.pose.position;
  frame_.conditions = conditions_.add(r, largest_);
  frame_.readout = readouts_.add(r);
  frame_.conditions.edge = false;  // the stops of the simulated device
  if (!samples_.push(sampleOf(r))) ++dropped_;
  frame_.droppedSamples = dropped_;
  frames_.next() = frame_;
  frames_.publish();
}

}  // namespace enamel::viewer
