// A wall behind passivity control gives no energy that it did not take, and is the same wall where it takes enough.
#include "enamel/render/passivity.hpp"

#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_passivity {

namespace {

struct Outcome {
  Status status = Status::ok;
  double given = 0.0;  // largest energy that the motors had put into the tool beyond what they took out, J
  double farthest = 0.0;
  PushMetrics metrics;
};

Outcome push(const Mechanism& device, Renderer& renderer, int delay, bool encoders) {
  PushSetup setup;
  setup.delay = {delay, delay};
  setup.guarded = false;
  setup.person.noise = 0.0;
  setup.person.force = 12.0;
  if (encoders) setup.encoders = {true, RateSource::difference, 100.0};
  MetricsCollector collector(setup, 0.0, device.limits().torque);
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

PassivityRenderer controlled(double stiffness) {
  return PassivityRenderer(std::make_unique<ImpedanceRenderer>(ImpedanceOptions{stiffness, 0.0}));
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
        PassivityRenderer passive = controlled(stiffness);
        const Outcome without = push(device, bare, delay, encoders), with = push(device, passive, delay, encoders);
        // Eq. 16 asks for more damping than there is: it bounces higher and higher.
        CHECK(without.status != Status::ok);
        REQUIRE(with.status == Status::ok);
        CHECK(with.metrics.verdict == FirstImpactVerdict::measured);
        // Without delay none. What one tick of delay hides is the wall's force over what a tick moves: 60 N over 0.1
        // mm.
        CHECK(with.given <= (delay == 0 ? 1e-6 : 6e-3));
        CHECK(with.farthest < 5e-3);
        // The way in is untouched.
        if (!without.metrics.firstStiffness) continue;
        CHECK(*with.metrics.firstStiffness == Approx(*without.metrics.firstStiffness).epsilon(1e-9));
        ++compared;
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
    TickInput input = test::inputAt(device, pose, 1e-3 * i, twist);
    input.applied.resize(0);
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

TEST_CASE("a wall behind passivity control goes on from a copied state") {
  const TauMechanism device(test::nominal());
  PassivityRenderer passive = controlled(6e3), copy = controlled(6e3);
  passive.activate(1e-3);
  copy.activate(1e-3);
  const auto step = [&device](PassivityRenderer& renderer, int i) {
    Pose pose;
    pose.position.z() = -1e-3 * std::sin(0.03 * i);
    TickOutput output;
    REQUIRE(renderer.step(test::inputAt(device, pose, 1e-3 * i), output) == Status::ok);
    return output.torque;
  };
  for (int i = 1; i < 40; ++i) (void)step(passive, i);
  REQUIRE(passive.stateSize() == copy.stateSize());
  std::vector<unsigned char> state(passive.stateSize());
  passive.saveState(state.data());
  copy.loadState(state.data());
  for (int i = 40; i < 200; ++i) REQUIRE(step(passive, i) == step(copy, i));
  // NaN in the wall's last number only, then throughout.
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
    CHECK(std::equal(fresh.begin() + sizeof(double), fresh.end(), state.begin() + sizeof(double)));  // all but the time
  }
  passive.reset();
  CHECK(step(copy, 1) == step(passive, 1));
  CHECK_THROWS_WITH(PassivityRenderer(nullptr), "passivity: there is no wall");
}

}  // namespace enamel::test_passivity
