// A wall with passivity control gives no energy that it did not receive, and is the same wall while it receives enough.
#include "enamel/render/passivity.hpp"

#include <numeric>

#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_passivity {

namespace {

struct Outcome {
  Status status = Status::ok;
  double given = 0.0;  // largest net energy that the motors had put into the tool, J
  double farthest = 0.0;
  PushMetrics metrics;
};

Outcome push(const Mechanism& device, Renderer& renderer, int delay, bool encoders) {
  PushSetup setup;
  setup.delay = {delay, delay};
  setup.guarded = false;
  setup.hand.noise = 0.0;
  setup.hand.force = 12.0;
  if (encoders) setup.encoders = {true, RateSource::difference, 100.0};
  MetricsCollector collector(setup, 0.0, device.limits().effort);
  Outcome outcome;
  double given = 0.0;
  outcome.status = runPush(device, renderer, setup, [&](const TickRecord& t) {
                     collector.add(t);
                     given += setup.period * t.rendered.dot(t.twist);
                     outcome.given = std::max(outcome.given, given);
                     outcome.farthest = std::max(outcome.farthest, t.nearest.gap);
                   }).status;
  outcome.metrics = collector.metrics();
  return outcome;
}

PassivityRenderer controlled(double stiffness, PassivityBound bound = PassivityBound::energy) {
  return PassivityRenderer(std::make_unique<ImpedanceRenderer>(ImpedanceOptions{stiffness, 0.0}), bound);
}

}  // namespace

TEST_CASE("a spring on a device without damping is made stable, and stays as stiff") {
  const TauMechanism device(test::nominal());
  int compared = 0;
  for (const double stiffness : {3e3, 6e3, 20e3})
    for (const int delay : {0, 1})
      for (const bool encoders : {false, true}) {
        INFO(stiffness << " N/m, delay " << delay << ", encoders " << encoders);
        ImpedanceRenderer bare({stiffness, 0.0});
        const Outcome without = push(device, bare, delay, encoders);
        // Eq. 16 requires more damping than available: it bounces higher and higher.
        CHECK(without.status != Status::ok);
        for (const PassivityBound bound : {PassivityBound::energy, PassivityBound::memory}) {
          INFO("bound " << static_cast<int>(bound));
          PassivityRenderer passive = controlled(stiffness, bound);
          const Outcome with = push(device, passive, delay, encoders);
          REQUIRE(with.status == Status::ok);
          CHECK(with.metrics.verdict == FirstImpactVerdict::measured);
          // Zero without delay. One tick of delay hides the wall's force times the motion in a tick: 60 N over 0.1 mm.
          CHECK(with.given <= (delay == 0 ? 1e-6 : 6e-3));
          CHECK(with.farthest < 5e-3);
          // The motion inwards is unchanged.
          if (!without.metrics.firstStiffness) continue;
          CHECK(*with.metrics.firstStiffness == Approx(*without.metrics.firstStiffness).epsilon(1e-9));
          ++compared;
        }
      }
  CHECK(compared > 0);
}

TEST_CASE("passivity control makes a force smaller, never larger, and turns none") {
  const TauMechanism device(test::nominal());
  ImpedanceRenderer bare({6e3, 0.0});
  PassivityRenderer passive = controlled(6e3);
  bare.activate(1e-3);
  passive.activate(1e-3);
  test::Random random(90);
  int cut = 0, whole = 0, none = 0;
  double energy = 0.0;  // by this test's own account
  JointVector before, angles;
  for (int i = 0; i < 2000; ++i) {
    Pose pose;
    pose.position.z() = -2e-3 + 4e-3 * std::sin(0.05 * i) + 1e-4 * random.uniform(-1.0, 1.0);
    Vec6 twist = Vec6::Zero();
    twist[2] = 0.2 * std::cos(0.05 * i);
    TickFrame input = test::frameAt(device, pose, 1e-3 * i, twist);
    input.applied.reset();
    TickOutput one, other;
    REQUIRE(bare.step(input, one) == Status::ok);
    REQUIRE(passive.step(input, other) == Status::ok);
    const JointVector& gravity = input.kinematics.gravity;
    const JointVector asked = one.torque - gravity, given = other.torque - gravity;
    const double share = asked.norm() > 0.0 ? given.norm() / asked.norm() : 1.0;
    REQUIRE(share <= 1.0 + 1e-12);
    REQUIRE((given - share * asked).norm() <= 1e-12 * asked.norm());
    CHECK(other.normalForce == Approx(share * one.normalForce).margin(1e-12));
    if (i > 0) energy -= before.dot(input.kinematics.q - angles);
    if (one.mode != RenderMode::contact) energy = std::min(energy, 0.0);
    REQUIRE(passive.energy() == Approx(energy).margin(1e-12));
    if (asked.norm() > 0.0) ++(share < 1e-12 ? none : share < 1.0 - 1e-9 ? cut : whole);
    before = given;
    angles = input.kinematics.q;
  }
  CHECK(whole > 500);
  CHECK(cut + none > 20);
}

TEST_CASE("with memory no depth gives more than it has taken, whatever the wall") {
  // Pushes out with three times the force of the way in, as a wall that generates energy does.
  class Thrower final : public Renderer {
    void prepare(double) override {}
    Status render(const TickFrame& input, TickOutput& output) noexcept override {
      const double gap = input.contacts.count > 0 ? input.contacts.contacts[0].gap : 0.0;
      Vec6 wrench = Vec6::Zero();
      wrench[2] = std::max(0.0, -gap) * (input.kinematics.twist[2] > 0.0 ? 9e3 : 3e3);
      output.torque = staticTorque(input.kinematics, wrench);
      output.mode = gap < 0.0 ? RenderMode::contact : RenderMode::free;
      return Status::ok;
    }
    void resetState() noexcept override {}
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  };
  const TauMechanism device(test::nominal());
  constexpr double kSlice = 0.1e-3;  // m
  for (const PassivityBound bound : {PassivityBound::energy, PassivityBound::memory}) {
    PassivityRenderer passive(std::make_unique<Thrower>(), bound);
    passive.activate(1e-3);
    // Move in to 2 mm and out again, evenly; slowly in and fast out; and in again half way.
    double z = 0.0, force = 0.0, worst = 0.0;
    std::array<double, 30> taken{};  // by slices of depth, J
    const auto move = [&](double to, double step, int& tick) {
      while (std::abs(to - z) > 0.5 * step) {
        const double next = z + std::copysign(step, to - z), low = std::min(-z, -next), high = std::max(-z, -next);
        for (std::size_t i = 0; i < taken.size(); ++i) {  // since the last tick
          const double from = std::max(low, kSlice * static_cast<double>(i));
          const double way = std::min(high, kSlice * static_cast<double>(i + 1)) - from;
          if (way > 0.0) taken[i] += force * std::copysign(way, z - next);
        }
        const double speed = (next - z) / 1e-3;
        z = next;
        worst = std::min(worst, *std::min_element(taken.begin(), taken.end()));
        Pose pose;
        pose.position.z() = z;
        Vec6 twist = Vec6::Zero();
        twist[2] = speed;
        TickFrame input = test::frameAt(device, pose, 1e-3 * ++tick, twist);
        input.applied.reset();
        TickOutput output;
        REQUIRE(passive.step(input, output) == Status::ok);
        force = output.normalForce =
            (input.kinematics.inverseTransposed * (output.torque - input.kinematics.gravity))[2];
      }
    };
    int tick = 0;
    move(-2e-3, 20e-6, tick);
    const double pressed = std::accumulate(taken.begin(), taken.end(), 0.0);
    CHECK(pressed == Approx(0.5 * 3e3 * 4e-6).epsilon(0.05));
    move(-1e-3, 50e-6, tick);
    move(-1.6e-3, 20e-6, tick);
    move(1e-4, 50e-6, tick);
    const double kept = std::accumulate(taken.begin(), taken.end(), 0.0);
    // At a reversal, the force of one tick belonged to the other direction: 6 N over 50 um.
    CHECK(kept > -3e-4);
    if (bound == PassivityBound::memory)
      CHECK(worst > -3.5e-4);
    else
      CHECK(worst < -1e-3);  // energy received at one depth was returned at another
  }
}

TEST_CASE("a wall behind passivity control goes on from a copied state") {
  const TauMechanism device(test::nominal());
  PassivityRenderer passive = controlled(6e3, PassivityBound::memory), copy = controlled(6e3, PassivityBound::memory);
  passive.activate(1e-3);
  copy.activate(1e-3);
  const auto step = [&device](PassivityRenderer& renderer, int i) {
    Pose pose;
    pose.position.z() = -1e-3 * std::sin(0.03 * i);
    TickOutput output;
    REQUIRE(renderer.step(test::frameAt(device, pose, 1e-3 * i), output) == Status::ok);
    return output.torque;
  };
  for (int i = 1; i < 40; ++i) (void)step(passive, i);
  REQUIRE(passive.stateSize() == copy.stateSize());
  std::vector<unsigned char> state(passive.stateSize());
  passive.saveState(state.data());
  copy.loadState(state.data());
  for (int i = 40; i < 200; ++i) REQUIRE(step(passive, i) == step(copy, i));
  // NaN in the wall's last number only, then everywhere.
  const std::vector<unsigned char> good = state;
  for (const std::size_t bytes : {sizeof(double), state.size()}) {
    state = good;
    std::fill(state.end() - static_cast<std::ptrdiff_t>(bytes), state.end(), 0xff);
    copy.loadState(state.data());
    CHECK(copy.energy() == 0.0);
    passive.reset();
    std::vector<unsigned char> fresh(state.size());
    passive.saveState(fresh.data());
    copy.saveState(state.data());
    CHECK(std::equal(fresh.begin() + sizeof(double), fresh.end(), state.begin() + sizeof(double)));  // except the time
  }
  passive.reset();
  CHECK(step(copy, 1) == step(passive, 1));
  CHECK_THROWS_WITH(PassivityRenderer(nullptr), "passivity: the wall's renderer is missing");
}

}  // namespace enamel::test_passivity
