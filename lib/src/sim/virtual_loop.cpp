#include "enamel/sim/virtual_loop.hpp"

#include "core/message.hpp"

namespace enamel {

void describe(const TickFrame& tick, const Kinematics& device, const Scene& scene, const Tool& tool, ToolCache* cache,
              TickRecord& record) noexcept {
  record.pose = device.pose;
  record.twist = device.twist;
  record.requested = tick.output.torque;
  record.command = tick.command;
  record.rendered = wrenchOf(device, record.torque - device.gravity);
  record.nearest = nearestContact(scene, tool, device.pose, cache);
  record.gapRate = record.nearest.normal.dot(contactVelocity(device, record.nearest));
  record.normalForce = tick.reason == GuardReason::none
                           ? tick.output.normalForce
                           : record.nearest.normal.dot(wrenchOf(device, record.command - device.gravity).head<3>());
  record.mode = tick.output.mode;
  record.saturated = tick.output.saturated;
  record.guard = tick.reason;
}

void checkLoop(const LoopSetup& setup) {
  checkVirtualDevice(setup);
  require(!setup.scene.obstacles().empty(), "the scene has no obstacle");
  require(setup.force >= 0.0, "the force limit is " + formatNumber(setup.force) + ", must be at least 0 N");
}

namespace {

GuardOptions guardOf(const Mechanism& plant, const Mechanism& model, const LoopSetup& setup) {
  GuardOptions guard = guardFor(plant, setup.period);
  guard.drive = model.limits().drive;  // as the model knows it
  guard.on = setup.guarded;
  guard.force = setup.force;
  return guard;
}

}  // namespace

VirtualLoop::VirtualLoop(const Mechanism& plant, const Mechanism& model, Renderer& renderer, const LoopSetup& setup)
    : VirtualLoop(std::make_unique<ClosedFormPlant>(plant, setup.integrator, setup.substeps), model, renderer, setup) {}

VirtualLoop::VirtualLoop(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer,
                         const LoopSetup& setup)
    : scene_((checkLoop(setup), setup.scene)),
      tool_(setup.tool),
      device_(std::move(plant), setup),
      wrapped_(setup.wrapper ? setup.wrapper(device_) : nullptr),
      driver_(wrapped_ ? *wrapped_ : device_),
      tick_(model, scene_, tool_, renderer, guardOf(device_.plant().mechanism(), model, setup), setup.start),
      trueCache_(makeToolCache(scene_, tool_)) {}

Status VirtualLoop::restart(const Pose& start) {
  if (const Status status = device_.restart(start); status != Status::ok) return status;
  tick_.restart(start);
  command_ = Command();
  return Status::ok;
}

Status VirtualLoop::tick(const ExternalWrench& load, TickRecord& record) noexcept {
  if (const Status status = react(record); status != Status::ok) return status;
  record.handWrench = load(record.time, record.pose, record.twist);
  return device_.advance(load);
}

Status VirtualLoop::tick(const ExternalWrench& before, double instant, const ExternalWrench& after,
                         TickRecord& record) noexcept {
  if (const Status status = react(record); status != Status::ok) return status;
  record.handWrench = before(record.time, record.pose, record.twist);
  return device_.advance(before, instant, after);
}

// Everything up to the torque that acts during this tick.
Status VirtualLoop::react(TickRecord& record) noexcept {
  const Status measured = driver_.measure(measurement_);
  if (measured != Status::ok && measured != Status::stale) return measured;
  if (measured == Status::ok) {
    measurement_.age = 0;
  } else {  // no sample arrived
    ++measurement_.age;
    measurement_.time = device_.time();
  }
  record.status = tick_(measurement_, command_);
  if (const Status status = driver_.actuate(command_); status != Status::ok) return status;

  record.tick = device_.tick();
  record.time = device_.time();
  record.q = measurement_.q;
  record.torque = device_.torque();
  describe(tick_.frame(), device_.kinematics(), tick_.scene().scene(), tool_, &trueCache_, record);
  return Status::ok;
}

}  // namespace enamel
