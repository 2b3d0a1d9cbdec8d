#include "support/guard_faults.hpp"

#include "enamel/device/tau/mechanism.hpp"

namespace enamel::test {

std::vector<Fault> guardFaults() {
  const double nan = std::nan("");
  std::vector<Fault> faults = {
      {"NaN", GuardReason::measurement, 1, [nan](int, Measurement& m) { m.q[2] = nan; }},
      {"one NaN", GuardReason::measurement, 1,
       [nan](int t, Measurement& m) {
         if (t == 0) m.q[2] = nan;
       }},
      {"infinite rate", GuardReason::measurement, 1, [](int, Measurement& m) { m.rates[0] = HUGE_VAL; }},
      {"too few joints", GuardReason::measurement, 1, [](int, Measurement& m) { m.q.conservativeResize(4); }},
      {"jump", GuardReason::jump, 1, [](int, Measurement& m) { m.q[1] += 0.3; }},
      {"jump back", GuardReason::jump, 1,
       [](int t, Measurement& m) {
         if (t == 0) m.q[4] -= 0.3;
       }},
      {"switched sign", GuardReason::jump, 1, [](int, Measurement& m) { m.q[0] = -m.q[0]; }},
      {"time stands still", GuardReason::clock, 5, [](int t, Measurement& m) { m.time -= 1e-3 * (t + 1); }},
      {"time runs backwards", GuardReason::clock, 1, [](int t, Measurement& m) { m.time -= 2e-3 * (t + 1); }},
      {"time jumps back", GuardReason::clock, 1, [](int, Measurement& m) { m.time -= 0.2; }},
      {"5 ms late", GuardReason::late, 1, {}, {}, 5},
      {"50 ms late", GuardReason::late, 1, {}, {}, 50},
      {"500 ms late", GuardReason::late, 1, {}, {}, 500},
      {"answers an error", GuardReason::renderer, 1, {}, [](int, TickOutput&) { return Status::notConverged; }},
      {"answers NaN",
       GuardReason::renderer,
       1,
       {},
       [nan](int, TickOutput& out) {
         out.torque[1] = nan;
         return Status::ok;
       }},
      {"answers 1e308",
       GuardReason::renderer,
       1,
       {},
       [](int, TickOutput& out) {
         out.torque.setConstant(1e308);
         return Status::ok;
       }},
      {"answers -1e308",
       GuardReason::renderer,
       1,
       {},
       [](int, TickOutput& out) {
         out.torque.setConstant(-1e308);
         return Status::ok;
       }},
      {"oscillates at 300 Hz",
       GuardReason::oscillation,
       100,
       {},
       [](int t, TickOutput& out) {
         out.torque.array() += 2.0 * std::sin(0.6 * M_PI * t);
         return Status::ok;
       },
       0,
       GuardReason::energy},
  };
  return faults;
}

void requireGuarded(Renderer& renderer, const Fault& fault, bool echo) {
  const TauMechanism device(nominal());
  const Scene wall = flatWall();
  VirtualDeviceSetup setup;
  setup.start.position.z() = 1e-4;
  setup.encoders = {true, RateSource::difference, 100.0};
  VirtualDevice plant(device, setup);
  Spoiled spoiled(renderer, kFaultAt, fault.answer);
  HapticTick tick(device, wall, Tool(), spoiled, 1e-3, setup.start);
  const RandomStream random(1, 0);
  double push = 0.0;
  const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
    Vec6 wrench;
    wrench.head<3>() = -400.0 * pose.position - 12.0 * twist.head<3>() - push * Vec3::UnitZ();
    wrench.tail<3>() = holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
    return wrench;
  };
  const GuardOptions& limits = tick.guard().options();
  const int ramp = static_cast<int>(std::lround(limits.rampOut / limits.period));
  Measurement m;
  Command command;
  JointVector last;
  int seen = -1, contacts = 0;
  INFO(fault.name << (echo ? ", echo" : ""));
  for (int i = 0; i < kFaultAt + 300; ++i) {
    if (i == kFaultAt)
      for (int missed = 0; missed < fault.missed; ++missed)
        if (plant.measure(m) != Status::ok || plant.advance(hand) != Status::ok) break;
    REQUIRE(plant.measure(m) == Status::ok);
    const JointVector gravity = plant.kinematics().gravity;
    if (!echo) m.applied.reset();
    if (i >= kFaultAt && fault.measure) fault.measure(i - kFaultAt, m);
    const Status status = tick(m, command);
    contacts += tick.frame().output.mode == RenderMode::contact;
    const JointVector& torque = command.effort;
    REQUIRE(torque.size() == 6);
    REQUIRE(torque.allFinite());
    REQUIRE((torque.cwiseAbs() - limits.torque).maxCoeff() <= 0.0);
    if (i > 0) REQUIRE(((torque - last).cwiseAbs() - 1e-3 * limits.slew).maxCoeff() <= 1e-12);
    last = torque;
    if (i < kFaultAt) {
      REQUIRE(status == Status::ok);
      REQUIRE(tick.frame().reason == GuardReason::none);
      REQUIRE(torque == tick.frame().output.torque);
    } else if (seen < 0 && isFault(tick.frame().reason)) {
      seen = i;
    }
    if (seen >= 0) {
      REQUIRE(status != Status::ok);
      REQUIRE((tick.frame().reason == fault.reason || tick.frame().reason == fault.other));
      REQUIRE(tick.guard().fault() == tick.frame().reason);
    }
    if (seen >= 0 && i >= seen + 2 * ramp) {  // 2 ramps: the configuration may become unknown during the first
      const bool known = fault.reason != GuardReason::measurement && fault.reason != GuardReason::jump &&
                         fault.reason != GuardReason::frozen;
      // Encoder counts change gravity's torque by about 1e-5 N m.
      if (known)
        REQUIRE((torque - gravity).cwiseAbs().maxCoeff() < 1e-3);
      else
        REQUIRE(torque == JointVector::Zero(6));
    }
    push = 6.0 + 0.5 * random.normal(RandomStream::Purpose::noise, static_cast<std::uint64_t>(i));
    REQUIRE(plant.actuate(command) == Status::ok);
    REQUIRE(plant.advance(hand) == Status::ok);
  }
  REQUIRE(contacts > kFaultAt / 2);
  REQUIRE(seen >= kFaultAt);
  REQUIRE(seen < kFaultAt + fault.within);
  // The guard keeps the last ticks and their reasons.
  REQUIRE(tick.guard().kept() >= static_cast<std::size_t>(kFaultAt));
  REQUIRE(tick.guard().kept() < static_cast<std::size_t>(kFaultAt + 300));
  REQUIRE(tick.guard().tick(0).reason == tick.guard().fault());
  REQUIRE(tick.guard().tick(tick.guard().kept() - 1).reason == GuardReason::none);
  // Only reset() clears the fault. Then the torque starts at gravity's and ramps in.
  tick.reset();
  REQUIRE(tick.guard().fault() == GuardReason::none);
  REQUIRE_FALSE(tick.guard().engaged());
}

}  // namespace enamel::test
