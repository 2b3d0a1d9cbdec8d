// Random closed loops in simulation: devices, renderers, delays, and all errors in what a device or a host may report.
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/virtual_coupling.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_device.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_closed_loops {

namespace {

constexpr double kPeriod = 1e-3;
constexpr int kTicks = 600, kFaultAt = 300;
constexpr double kDeepest = 2e-3;  // m, of position control without any reported problem

enum class Trouble {
  none,
  reportsZero,
  reportsTurned,
  reportsLess,
  reportsNoise,
  reportsHuge,
  silent,
  fails,
  loses,
  jumps,
  jitters,
  repeats,
  ratesZero,
  ratesTurned,
  notFinite,
  swaps,
  toggles,
  claimsSpeed,
  movesInFrames,
  teleports,
  count
};
constexpr const char* kNames[] = {"none",         "reports zero", "reports turned", "reports less",    "reports noise",
                                  "reports huge", "silent",       "fails",          "loses",           "jumps",
                                  "jitters",      "repeats",      "rates zero",     "rates turned",    "not finite",
                                  "swaps",        "toggles",      "claims speed",   "moves in frames", "teleports"};

// A random loop, determined by its number.
struct Case {
  explicit Case(std::uint64_t number) : random(number) {
    device = pick(5);
    renderer = pick(4);
    trouble = static_cast<Trouble>(pick(static_cast<int>(Trouble::count)));
    delay = pick(4);
    force = 0.3 + 12.0 * uniform();
    stiffness = random.power(2.5, 4.5);
    isQuantised = pick(4) > 0;
    size = uniform();
  }
  double uniform() { return random.uniform(0.0, 1.0); }
  int pick(int count) { return std::min(count - 1, static_cast<int>(uniform() * count)); }

  test::Random random;
  int device, renderer, delay;
  Trouble trouble;
  double force, stiffness, size;
  bool isQuantised;
};

const std::shared_ptr<const Mechanism>& mechanismOf(int device) {
  static const std::array<std::shared_ptr<const Mechanism>, 5> all = [] {
    std::array<std::shared_ptr<const Mechanism>, 5> made;
    const char* files[] = {"tau-nominal.toml", "tau-detailed.toml", "delta.toml", "cartesian-3.toml",
                           "cartesian-6.toml"};
    for (std::size_t i = 0; i < made.size(); ++i)
      made[i] = makeMechanism(idealOf(loadDevice(test::deviceFile(files[i]))));
    return made;
  }();
  return all[static_cast<std::size_t>(device)];
}

std::unique_ptr<Renderer> rendererOf(const Case& c, const Mechanism& mechanism) {
  const auto spring = [&] { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{c.stiffness, 0.0}); };
  switch (c.renderer) {
    case 0: return std::make_unique<PositionControlRenderer>(positionControlFor(mechanism, kPeriod, c.delay, c.delay));
    case 1: return spring();
    case 2: return std::make_unique<PassivityRenderer>(spring());
    default:
      return std::make_unique<VirtualCouplingRenderer>(VirtualCouplingOptions{std::min(c.stiffness, 5e3), 2.0, 0.02});
  }
}

class Driver final : public HapticDevice {
 public:
  Driver(VirtualDevice& device, Case& c) : device_(device), c_(c) {}
  Status measure(Measurement& m) noexcept override {
    const Status status = device_.measure(m);
    if (status != Status::ok) return status;
    const int tick = tick_++ - 1 - kFaultAt;
    const Measurement before = last_;
    last_ = m;
    if (offset_.size() > 0) hidden_ += offset_.dot(m.applied->cwiseAbs() + before.applied->cwiseAbs());
    if (c_.trouble == Trouble::silent) m.applied.reset();
    if (tick < 0) return Status::ok;
    const Status told = spoil(tick, before, m);
    if (m.q.allFinite()) offset_ = (m.q - last_.q).cwiseAbs();
    return told;
  }
  // Work that wrong samples may have hidden, J.
  double hidden() const { return hidden_; }
  Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

 private:
  Status spoil(int tick, const Measurement& before, Measurement& m) {
    const JointVector noise = JointVector::NullaryExpr(m.q.size(), [this] { return c_.uniform() - 0.5; });
    switch (c_.trouble) {
      case Trouble::reportsZero: m.applied->setZero(); break;
      case Trouble::reportsTurned: *m.applied *= -1.0; break;
      case Trouble::reportsLess: *m.applied *= 0.4 + 0.6 * c_.size; break;
      case Trouble::reportsNoise: *m.applied += c_.size * noise; break;
      case Trouble::reportsHuge:
        if (tick % 50 == 0) m.applied->setConstant(100.0);
        break;
      case Trouble::fails:
        if (tick == 20) return Status::notFinite;
        break;
      case Trouble::loses:
        if (c_.uniform() < 0.3 * c_.size) return Status::stale;
        break;
      case Trouble::jumps:
        if (tick % 40 == 0) m.q[0] += 1e-4 * std::exp(6.0 * c_.size);
        break;
      case Trouble::jitters: m.time += 0.3e-3 * (c_.uniform() - 0.5); break;
      case Trouble::repeats:
        if (tick % 7 == 0) m = before;
        break;
      case Trouble::ratesZero: m.rates.setZero(); break;
      case Trouble::ratesTurned: m.rates *= -1.0; break;
      case Trouble::notFinite:
        if (tick == 30) m.q[0] = std::nan("");
        break;
      case Trouble::swaps:
        if (tick % 90 == 0) std::swap(m.q[0], m.q[1]);
        break;
      case Trouble::toggles: m.enabled = (tick / 40) % 2 == 1; break;
      default: break;
    }
    return Status::ok;
  }

  VirtualDevice& device_;
  Case& c_;
  Measurement last_;
  JointVector offset_;  // error of the last sample
  double hidden_ = 0.0;
  int tick_ = 0;
};

// Change the wall as the host would.
void moveWall(Case& c, int tick, Scene& scene) {
  Pose pose = scene.obstacles()[0].pose;
  Vec6 twist = Vec6::Zero();
  const int frame = 2 + static_cast<int>(30.0 * c.size);
  if (c.trouble == Trouble::claimsSpeed) {
    twist[2] = 4.0 * (c.size - 0.5);
  } else if (c.trouble == Trouble::movesInFrames && tick % frame == 0) {
    const double way = 1e-3 * frame * 0.03 * std::sin(0.01 * tick);
    pose.position.z() += way;
    twist[2] = way / kPeriod;
  } else if (c.trouble == Trouble::teleports && tick == 50) {
    pose.position.z() += 4e-3 * (c.size - 0.5);
  }
  REQUIRE(scene.move(0, pose, twist) == Status::ok);
}

// Result of a loop.
struct Outcome {
  double beyond = 0.0;   // largest energy given to the tool above the guard's budget, from the true motion, J
  double allowed = 0.0;  // allowed part of it, J: until a command that the guard changed reaches the motors
  double depth = 0.0;    // largest depth below the wall while no problem was reported, m
  bool isFault = false;
};

// The guard's energy rule, computed from the true torques and motion: the reference for the guard's accounts.
class TrueAccount {
 public:
  explicit TrueAccount(const GuardOptions& options) : options_(options) {}
  // Return the energy above the budget, J.
  double add(const VirtualDevice& device, double wallSpeed) {
    const Kinematics& k = device.kinematics();
    const Vec6 wrench = wrenchOf(k, device.torque() - k.gravity), now = device.state().twist,
               twist = 0.5 * (twist_ + now);
    twist_ = now;
    const double force = wrench.head<3>().norm();
    peak_ = std::max(force, peak_ * (1.0 - kPeriod / 0.2));
    largestPower = std::max(largestPower, wrench.dot(twist));
    if (last_.size() > 0) hidden += 0.5 * options_.encoderStep.dot((device.torque() - last_).cwiseAbs());
    last_ = device.torque();
    energy_ += kPeriod * (wrench.dot(twist) - twist.dot(options_.damping * twist) - wrench[2] * wallSpeed);
    energy_ = std::max(energy_, -0.5 * peak_ * peak_ / options_.softest);
    if (energy_ > 0.0) energy_ = std::max(0.0, energy_ - kPeriod * options_.power);
    return energy_ - options_.energy;
  }
  double largestPower = 0.0;  // W
  double hidden = 0.0;        // hidden by rounding to counts, J: the guard counts a lower bound

 private:
  const GuardOptions& options_;
  double energy_ = 0.0, peak_ = 0.0;  // J, N
  JointVector last_;                  // torque
  Vec6 twist_ = Vec6::Zero();
};

Outcome outcomeOf(Case& c) {
  const Mechanism& mechanism = *mechanismOf(c.device);
  const std::unique_ptr<Renderer> renderer = rendererOf(c, mechanism);
  VirtualDeviceSetup setup;
  setup.start.position = {0.0, 0.0, 2e-3};
  setup.delay = {c.delay, c.delay};
  setup.encoders = {c.isQuantised, c.isQuantised ? RateSource::lowPass : RateSource::exact, 100.0};
  VirtualDevice device(mechanism, setup);
  Driver driver(device, c);
  Scene scene = flatWall();
  GuardOptions options = guardFor(mechanism, kPeriod);
  options.delay = c.delay;
  HapticTick haptics(mechanism, scene, Tool{}, *renderer, options, setup.start);
  LoopBody loop(driver, haptics, {});
  const double largest = largestForce(mechanism.home(), mechanism.limits().effort, Vec3::Zero(), Vec3::UnitZ());
  const double press = std::min(c.force, 0.6 * largest);
  const auto hand = [&](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = guidingWrench(pose, twist, setup.start, Vec3::UnitZ());
    wrench[2] -= (time < 0.05 ? 0.5 : press) + 3.0 * twist[2];
    return wrench;
  };
  Outcome outcome;
  int stopped = 0;  // ticks since a fault
  TrueAccount account(options);
  JointVector last = JointVector::Zero(mechanism.joints());
  for (int i = 0; i < kTicks; ++i) {
    if (i >= kFaultAt) moveWall(c, i - kFaultAt, scene);
    loop.step();
    const JointVector& command = loop.tick().command.effort;
    REQUIRE(command.size() == mechanism.joints());
    REQUIRE(command.allFinite());
    REQUIRE((command.cwiseAbs() - options.torque).maxCoeff() <= 0.0);
    if (i > 0) REQUIRE(((command - last).cwiseAbs() - kPeriod * options.slew).maxCoeff() <= 1e-9);
    last = command;
    outcome.isFault = outcome.isFault || isFault(loop.tick().reason);
    REQUIRE(outcome.isFault == (haptics.guard().fault() != GuardReason::none));
    if (outcome.isFault) REQUIRE(loop.tick().status != Status::ok);
    const Obstacle& wall = haptics.scene().scene().obstacles()[0];
    if (!outcome.isFault && loop.tick().reason == GuardReason::none)
      outcome.depth = std::max(outcome.depth, wall.pose.position.z() - device.state().position.z());
    if (device.advance(hand) != Status::ok) break;
    stopped += outcome.isFault;
    if (stopped * kPeriod > options.rampOut + 5e-3) break;  // its torque has ramped out
    outcome.beyond = std::max(outcome.beyond, account.add(device, wall.twist[2]));
  }
  // The guard detects an excess one tick later, and its command acts after the delay. If the configuration is unknown,
  // it cannot know what pushes the tool: everything ramps out.
  const GuardReason fault = haptics.guard().fault();
  const bool isKnown = fault != GuardReason::measurement && fault != GuardReason::jump &&
                       fault != GuardReason::frozen && fault != GuardReason::unreachable;
  const double ramp = isKnown ? 0.0 : 0.5 * options.rampOut;
  outcome.allowed = ((c.delay + 3) * kPeriod + ramp) * account.largestPower + account.hidden + driver.hidden();
  return outcome;
}

}  // namespace

TEST_CASE("random closed loops: no torque above a limit, no energy above the guard's bound, no silent failure",
          "[hard]") {
  const int loops = test::count(300, 10000);
  std::array<Outcome, static_cast<std::size_t>(Trouble::count)> worst{};
  std::array<int, static_cast<std::size_t>(Trouble::count)> runs{}, faults{};
  for (int i = 0; i < loops; ++i) {
    Case c(test::seed() * 10000 + static_cast<std::uint64_t>(i));
    const auto kind = static_cast<std::size_t>(c.trouble);
    INFO("ENAMEL_SEED=" << test::seed() << ", loop " << i << ": " << kNames[kind] << ", device " << c.device
                        << ", renderer " << c.renderer << ", delay " << c.delay << ", " << c.force << " N, "
                        << c.stiffness << " N/m");
    const Outcome o = outcomeOf(c);
    CHECK(o.beyond <= o.allowed);
    if (c.renderer == 0) CHECK(o.depth < kDeepest);
    ++runs[kind];
    faults[kind] += o.isFault;
    worst[kind].beyond = std::max(worst[kind].beyond, o.beyond);
    if (c.renderer == 0) worst[kind].depth = std::max(worst[kind].depth, o.depth);
  }
  for (std::size_t k = 0; k < runs.size(); ++k)
    std::cout << kNames[k] << ": " << runs[k] << " loops, " << faults[k] << " stopped, at most "
              << 1e3 * worst[k].beyond << " mJ beyond the budget; position control at most " << 1e3 * worst[k].depth
              << " mm deep\n";
}

}  // namespace enamel::test_closed_loops
