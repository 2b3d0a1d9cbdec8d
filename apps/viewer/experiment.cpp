#include "experiment.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "enamel/device/tau/dynamics.hpp"

namespace enamel::viewer {
namespace {

constexpr double kTestPreload = 0.5;               // N, of the hand on the surface before the step
constexpr int kApproachLimit = 3000, kRest = 300;  // ticks
constexpr int kPushTicks = 400;
constexpr double kAtRest = 2e-4;  // m/s

LoopSetup loopSetup(const Settings& settings, const SceneFile& scene, const Pose& start) {
  LoopSetup setup;
  setup.start = start;
  setup.scene = scene.scene;
  setup.tool = scene.tool;
  setup.encoders = settings.encoders;
  setup.delay = settings.delay;
  setup.period = kPeriod;
  return setup;
}

}  // namespace

TauParameters changed(const TauParameters& device, const Settings& settings) {
  TauParameters result = device;
  result.platform.mass += settings.extraMass;
  result.platform.damping.head<3>().array() += settings.toolDamping;
  result.motor.viscousFriction += settings.friction;
  return result;
}

Wall wallOf(const PluginLibrary& plugin) noexcept {
  return std::strcmp(plugin.description().name, "impedance") == 0 ? Wall::impedance : Wall::positionControl;
}

StiffnessLimit stiffnessLimit(const TauModel& model, const TauConfiguration& configuration, const Vec3& normal,
                              double force, double preload, int delay) noexcept {
  const Vec6 gravity = gravityTorque(model, configuration);
  Vec6 push = Vec6::Zero();
  push.head<3>() = normal;
  const Vec6 perNewton = staticTorque(model, configuration, push) - gravity;
  double largest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 6; ++i) {
    const double room = model.maxTorque - (perNewton[i] > 0.0 ? gravity[i] : -gravity[i]);
    if (std::abs(perNewton[i]) > 1e-12) largest = std::min(largest, std::max(0.0, room) / std::abs(perNewton[i]));
  }
  const double mass = effectiveMass(model, configuration, configuration.pose.position, normal);
  const double t1 = (delay + 1) * kPeriod;
  const double share = largest > std::max(force, preload) ? (largest - force) / (largest - preload) : 0.0;
  return {2.0 * mass * share / (t1 * t1), mass, largest};
}

Experiment::Experiment(const ServoedDevice& device, const Settings& settings, const SceneFile& scene, const Pose& start,
                       const Hand& hand, Wall wall)
    : model_(makeModel(device.parameters)),
      plant_(makeModel(changed(device.parameters, settings))),
      noise_(settings.noise),
      random_(1, 0),
      hold_(model_, device.gain, kPeriod, settings.hold),
      spring_(model_, settings.spring),
      plugin_(device.plugin ? makeRenderer(device.plugin, device.pluginSetup) : nullptr),
      switched_(plugin_ && wallOf(*device.plugin) == Wall::positionControl ? *plugin_ : hold_,
                plugin_ && wallOf(*device.plugin) == Wall::impedance ? *plugin_ : spring_),
      loop_(plant_, switched_, loopSetup(settings, scene, start)) {
  frame_.hand = hand;
  frame_.record.pose = start;
  frame_.record.nearest = nearestContact(scene.scene, scene.tool, start, nullptr);
  select(wall);
}

void Experiment::select(Wall wall) noexcept {
  frame_.wall = wall;
  switched_.select(wall);
  phase_ = Phase::none;
}

void Experiment::setGrip(const Grip& grip) noexcept {
  // The force stays as it was: the hand goes where the new springs give it.
  const Vec3 tool = frame_.record.pose.position;
  const Vec3 ratio = stiffnessOf(frame_.hand.grip).cwiseQuotient(stiffnessOf(grip));
  frame_.hand.position = tool + ratio.cwiseProduct(frame_.hand.position - tool);
  frame_.hand.target = tool + ratio.cwiseProduct(frame_.hand.target - tool);
  frame_.hand.grip = grip;
}

void Experiment::startTestPush() noexcept {
  const Contact& nearest = frame_.record.nearest;
  testNormal_ = nearest.normal;
  testPoint_ = frame_.record.pose.position - nearest.gap * nearest.normal;
  if (phase_ == Phase::none) gripBefore_ = frame_.hand.grip;
  phase_ = Phase::approach;
  phaseTicks_ = restTicks_ = 0;
  test_ = TestPush{};
  setGrip(kFirmGrip);
}

// Brings the tool to rest on the surface under a small preload, then lets go of a step of force.
void Experiment::advanceTestPush() noexcept {
  if (phase_ == Phase::none) return;
  ++phaseTicks_;
  const Vec3 perNewton = testNormal_.cwiseQuotient(stiffnessOf(frame_.hand.grip));
  frame_.hand.target = testPoint_ - kTestPreload * perNewton;
  if (phase_ == Phase::approach) {
    const bool still = frame_.record.nearest.gap < 1e-5 && frame_.record.twist.head<3>().norm() < kAtRest;
    restTicks_ = still ? restTicks_ + 1 : 0;
    if (restTicks_ >= kRest) {
      phase_ = Phase::push;
      phaseTicks_ = 0;
      test_.preload = -testNormal_.dot(frame_.record.person.head<3>());
      lastSpeed_ = 0.0;
    } else if (phaseTicks_ >= kApproachLimit) {
      phase_ = Phase::none;
    }
  } else if (phaseTicks_ >= kPushTicks) {
    phase_ = Phase::none;
  }
  if (phase_ == Phase::none) setGrip(gripBefore_);
}

void Experiment::watchTestPush() noexcept {
  if (phase_ != Phase::push || test_.valid) return;
  const double speed = testNormal_.dot(frame_.record.twist.head<3>());
  const double depth = -frame_.record.nearest.gap;
  if (phaseTicks_ > 1 && depth > 0.0 && lastSpeed_ < 0.0 && speed >= 0.0) {
    test_.valid = true;
    test_.depth = depth;
    test_.force = -testNormal_.dot(frame_.record.person.head<3>());
    test_.stiffness = test_.force / depth;
    frame_.tests[static_cast<std::size_t>(frame_.wall)] = test_;
  }
  lastSpeed_ = speed;
}

void Experiment::tick() noexcept {
  if (frame_.plant != Status::ok) return;
  advanceTestPush();
  TickRecord& record = frame_.record;
  moveHand(frame_.hand, record.pose.position, kPeriod);
  const Vec3 normal = phase_ == Phase::push ? testNormal_ : frame_.record.nearest.normal;
  double pressed = phase_ == Phase::push ? kTestForce - kTestPreload : 0.0;
  if (noise_ > 0.0) pressed += noise_ * random_.normal(RandomStream::Purpose::noise, record.tick + 1);
  const double time = loop_.time();
  frame_.plant = loop_.tick(HandLoad(frame_.hand, time, -pressed * normal), record);
  frame_.contacts = loop_.input().contacts;
  frame_.holding = frame_.wall == Wall::positionControl && hold_.holding();
  frame_.reference = hold_.reference();
  watchTestPush();
  frame_.testing = phase_ != Phase::none;
}

void Experiment::Switched::select(Wall wall) noexcept {
  selected_ = static_cast<std::uint8_t>(wall);
  renderers_[selected_]->reset();
}

void Experiment::Switched::prepare(double period) {
  for (Renderer* renderer : renderers_) renderer->activate(period);
}

Status Experiment::Switched::render(const TickInput& input, TickOutput& output) noexcept {
  return renderers_[selected_]->step(input, output);
}

void Experiment::Switched::resetState() noexcept {
  for (Renderer* renderer : renderers_) renderer->reset();
}

}  // namespace enamel::viewer
