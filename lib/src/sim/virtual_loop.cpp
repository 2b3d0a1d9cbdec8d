#include "enamel/sim/virtual_loop.hpp"

#include <cmath>
#include <string>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

TauConfiguration reachable(const TauModel& model, const Pose& start) {
  TauConfiguration configuration;
  if (const Status status = inverseKinematics(model, start, configuration); status != Status::ok)
    throw Error(std::string("the start pose is ") + toString(status));
  return configuration;
}

const LoopSetup& checked(const LoopSetup& setup) {
  checkLoop(setup);
  return setup;
}

}  // namespace

void checkLoop(const LoopSetup& setup) {
  const auto require = [](bool condition, const std::string& message) {
    if (!condition) throw Error(message);
  };
  require(!setup.scene.obstacles().empty(), "the scene has no obstacle");
  require(setup.period > 0.0 && setup.period <= 0.1,
          "period is " + formatNumber(setup.period) + ", must be in (0, 0.1] s");
  require(setup.substeps >= 1 && setup.substeps <= 1000,
          "substeps is " + std::to_string(setup.substeps) + ", must be in 1 to 1000");
  require(0 <= setup.delay.low && setup.delay.low <= setup.delay.high && setup.delay.high <= kMaxDelay,
          "delay is " + std::to_string(setup.delay.low) + ".." + std::to_string(setup.delay.high) +
              ", must be in 0 to " + std::to_string(kMaxDelay) + " ticks, low first");
  require(setup.encoders.cutoff > 0.0 && std::isfinite(setup.encoders.cutoff),
          "cutoff of the rate filter is " + formatNumber(setup.encoders.cutoff) + ", must be greater than 0 Hz");
}

VirtualLoop::VirtualLoop(const TauModel& model, Renderer& renderer, const LoopSetup& setup)
    : model_(model),
      renderer_(renderer),
      setup_(checked(setup)),
      random_(setup.seed, setup.run),
      plant_(reachable(model, setup.start)),
      memory_{plant_, makeToolCache(setup.scene, setup.tool)},
      plantContacts_(memory_.contacts),
      encoders_(setup.encoders, model.encoderCounts, setup.period),
      motors_(setup.delay, gravityTorque(model, plant_)) {
  state_.position = setup.start.position;
  state_.orientation = setup.start.rotation;
  renderer_.activate(setup.period);
}

// Everything up to the torque that acts during this tick.
Status VirtualLoop::begin(TickRecord& record) noexcept {
  record.tick = tick_;
  record.time = static_cast<double>(tick_) * setup_.period;
  record.pose = state_.pose();
  record.twist = state_.twist;
  if (const Status status = inverseKinematics(model_, record.pose, plant_); status != Status::ok) return status;

  const Measurement m = encoders_.measure(jointAngles(plant_), jointRates(model_, plant_, state_.twist));
  record.status =
      hapticTick(model_, setup_.scene, setup_.tool, record.time, m.q, m.rates, memory_, renderer_, input_, output_);
  record.q = m.q;
  record.command = output_.torque;
  record.torque = motors_.actuate(tick_, output_.torque, random_);
  record.rendered = wrenchFromTorques(model_, plant_, record.torque - gravityTorque(model_, plant_));
  record.nearest = nearestContact(setup_.scene, setup_.tool, record.pose, &plantContacts_);
  record.normalForce = output_.normalForce;
  record.mode = output_.mode;
  record.saturated = output_.saturated;
  return Status::ok;
}

}  // namespace enamel
