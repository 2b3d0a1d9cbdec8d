#include "enamel/sim/push.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/message.hpp"

namespace enamel {
namespace {

constexpr double kOnset = 1.0, kHandStill = 2.0;  // s
constexpr double kLongestRun = 3600.0;            // s

}  // namespace

SimulatedHand::SimulatedHand(const PushSetup& setup) noexcept
    : hand_(setup.hand),
      start_(gripOf(setup.start)),
      times_(timesOf(setup)),
      random_(setup.seed, setup.run),
      period_(setup.period) {
  if (hand_.arm) arm_.emplace(*hand_.arm);
}

bool SimulatedHand::stepsInside(std::uint64_t tick) const noexcept {
  return hand_.scenario == 1 && hand_.instant > 0.0 && tick == times_.onset && !hand_.arm;
}

void SimulatedHand::hold(std::uint64_t tick, bool stepped) noexcept {
  const bool pressed = hand_.preload > 0.0 && hand_.scenario == 1;
  held_ = 0.0;
  if (hand_.scenario == 1) {
    if (tick >= times_.onset && (stepped || !stepsInside(tick)))
      held_ = hand_.force;
    else if (pressed)
      held_ = hand_.preload;
  }
  if (pressed || tick >= times_.steady) held_ += hand_.noise * random_.normal(RandomStream::Purpose::noise, tick);
}

void SimulatedHand::moveArm(const Pose& pose, const Vec6& twist) noexcept {
  if (arm_) arm_->move(held_, way(gripOf(pose)), speed(gripOf(pose, twist)), period_);
}

Vec6 SimulatedHand::operator()(double time, const Pose& pose, const Vec6& twist) const noexcept {
  const Pose grip = gripOf(pose);
  const Vec6 motion = gripOf(pose, twist);
  Vec6 wrench = Vec6::Zero();
  if (hand_.guide) wrench = guidingWrench(grip, motion, start_, hand_.normal);
  wrench.head<3>() -= force(time, grip, motion) * hand_.normal;
  wrench.tail<3>() += (grip.position - pose.position).cross(wrench.head<3>());
  if (hand_.rest) {
    const Vec3 arm = pose.rotation * hand_.rest->point, held = start_.position + start_.rotation * hand_.rest->point;
    const Vec3 force = hand_.rest->grip.stiffness * (held - pose.position - arm) -
                       hand_.rest->grip.damping * translationAt(twist, arm);
    wrench.head<3>() += force;
    wrench.tail<3>() += arm.cross(force);
  }
  return wrench;
}

Pose SimulatedHand::gripOf(const Pose& pose) const noexcept {
  return {pose.position + pose.rotation * hand_.grip, pose.rotation};
}

Vec6 SimulatedHand::gripOf(const Pose& pose, const Vec6& twist) const noexcept {
  Vec6 motion = twist;
  motion.head<3>() = translationAt(twist, pose.rotation * hand_.grip);
  return motion;
}

double SimulatedHand::force(double time, const Pose& pose, const Vec6& twist) const noexcept {
  if (arm_) return arm_->push(way(pose), speed(twist));
  if (hand_.scenario == 1) return held_;
  const HandMotion hand = handMotion(hand_.force, time);
  const Vec3& n = hand_.normal;
  const double spring = kPaperGrip.stiffness * (hand.position - n.dot(pose.position - start_.position));
  return held_ - spring - kPaperGrip.damping * (hand.velocity - n.dot(twist.head<3>()));
}

double SimulatedHand::way(const Pose& pose) const noexcept {
  return -hand_.normal.dot(pose.position - start_.position);
}

double SimulatedHand::speed(const Vec6& twist) const noexcept { return -hand_.normal.dot(twist.head<3>()); }

HandMotion handMotion(double force, double time) noexcept {
  // Three phases whose displacements add up to -F_c / 40 at 2 s: a (0.45^2 + 0.45 * 0.1) = a * 0.2475.
  const double a = -force / 9.9;  // m/s^2
  const double t1 = std::clamp(time - 1.0, 0.0, 0.45), t2 = std::clamp(time - 1.45, 0.0, 0.10),
               t3 = std::clamp(time - 1.55, 0.0, 0.45);
  const double fastest = a * 0.45;
  HandMotion motion{0.5 * a * t1 * t1, a * t1};
  motion.position += fastest * t2 + fastest * t3 - 0.5 * a * t3 * t3;
  motion.velocity -= a * t3;
  if (time >= 2.0) motion.velocity = 0.0;
  return motion;
}

double randomInstant(std::uint64_t seed, std::uint32_t run) noexcept {
  return RandomStream(seed, run).uniform(RandomStream::Purpose::instant, 0);
}

PushTimes timesOf(const PushSetup& setup) noexcept {
  const auto tickAt = [&setup](double time) {
    return static_cast<std::uint64_t>(std::llround(std::max(0.0, time) / setup.period));
  };
  return {tickAt(kOnset), tickAt(setup.hand.scenario == 1 ? kOnset : kHandStill), tickAt(setup.duration - 1.0),
          tickAt(setup.duration)};
}

void setToolTip(const Vec3& tip, PushSetup& setup) {
  setup.tool = Tool();
  setup.tool.parts[0].a = setup.tool.parts[0].b = tip;
  setup.hand.grip = tip;
  setup.scene = flatWall(setup.start.position + setup.start.rotation * tip, setup.hand.normal);
}

void setScene(const SceneFile& file, PushSetup& setup) {
  setup.scene = file.scene;
  setup.tool = file.tool;
  setup.force = std::min(setup.force, file.maxForce);
  setup.start.position = file.start;
  require(placeOnSurface(setup), "the scene has no surface near its start: move start closer to an obstacle");
}

bool placeOnSurface(PushSetup& setup) noexcept {
  // Move by the distance repeatedly; the steps shrink as fast as the surface permits.
  Contact nearest = nearestContact(setup.scene, setup.tool, setup.start, nullptr);
  for (int step = 0; step < 100 && std::abs(nearest.gap) > 1e-12; ++step) {
    setup.start.position -= nearest.gap * nearest.normal;
    nearest = nearestContact(setup.scene, setup.tool, setup.start, nullptr);
  }
  setup.hand.normal = nearest.normal;
  return setup.start.position.allFinite();
}

void checkPush(const PushSetup& setup) {
  checkLoop(setup);
  const HandModel& p = setup.hand;
  require(p.scenario == 1 || p.scenario == 2, "scenario is " + std::to_string(p.scenario) + ", must be 1 or 2");
  if (p.arm) {
    const Arm& a = *p.arm;
    require(p.scenario == 1, "scenario is 2, must be 1 with an arm");
    require(a.mass > 0.0 && std::isfinite(a.mass),
            "the arm's mass is " + formatNumber(a.mass) + ", must be above 0 kg");
    for (const double value : {a.damping, a.stiffness, a.grip.stiffness, a.grip.damping})
      require(value >= 0.0 && std::isfinite(value),
              "a damping or stiffness of the arm is " + formatNumber(value) + ", must be at least 0");
  }
  if (p.rest) {
    require(p.rest->point.squaredNorm() <= 1.0,
            "the finger rests " + formatNumber(p.rest->point.norm()) + " m from the TCP, must be within 1 m");
    for (const double value : {p.rest->grip.stiffness, p.rest->grip.damping})
      require(value >= 0.0 && std::isfinite(value),
              "a damping or stiffness of the finger rest is " + formatNumber(value) + ", must be at least 0");
  }
  require(std::abs(p.normal.norm() - 1.0) <= 1e-6,
          "the normal of the push has the length " + formatNumber(p.normal.norm()) + ", must be 1");
  require(p.grip.squaredNorm() <= 1.0,
          "the grip is " + formatNumber(p.grip.norm()) + " m from the TCP, must be within 1 m");
  require(p.force >= 0.0 && p.force <= 1e3, "force is " + formatNumber(p.force) + ", must be in 0 to 1000 N");
  require(p.preload >= 0.0 && p.preload <= 1e3, "preload is " + formatNumber(p.preload) + ", must be in 0 to 1000 N");
  require(p.instant >= 0.0 && p.instant < 1.0,
          "instant of the step is " + formatNumber(p.instant) + ", must be at least 0 and below 1 tick");
  require(p.noise >= 0.0 && p.noise <= 1e3, "noise is " + formatNumber(p.noise) + ", must be in 0 to 1000 N");
  require(setup.duration >= 0.0 && setup.duration <= kLongestRun,
          "duration is " + formatNumber(setup.duration) + ", must be in 0 to 3600 s");
}

PushResult runPush(const Mechanism& mechanism, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&)>& record) {
  return runPush(std::make_unique<ClosedFormPlant>(mechanism, setup.integrator, setup.substeps), mechanism, renderer,
                 setup, [&record](const TickRecord& tick, const VirtualLoop&) { record(tick); });
}

PushResult runPush(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&, const VirtualLoop&)>& record) {
  checkPush(setup);
  VirtualLoop loop(std::move(plant), model, renderer, setup);
  SimulatedHand hand(setup);
  const PushTimes times = timesOf(setup);
  PushResult result{Status::ok, 0, GuardReason::none};
  TickRecord tick;
  for (std::uint64_t i = 0; i < times.end; ++i) {
    hand.hold(i);
    if (hand.stepsInside(i)) {
      SimulatedHand stepped = hand;
      stepped.hold(i, true);
      result.status = loop.tick(hand, setup.hand.instant * setup.period, stepped, tick);
    } else {
      result.status = loop.tick(hand, tick);
    }
    if (result.status != Status::ok) break;
    hand.moveArm(tick.pose, tick.twist);
    ++result.ticks;
    record(tick, loop);
    if (isFault(tick.guard)) {
      result.status = Status::stopped;
      result.guard = tick.guard;
      break;
    }
  }
  renderer.deactivate();
  return result;
}

}  // namespace enamel
