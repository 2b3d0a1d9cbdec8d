// The virtual device and the loop: reference runs, the person, motors, encoders, determinism.
#include "enamel/sim/push.hpp"

#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_push {

TEST_CASE("the reference runs are reproduced to 1 nm at every tick", "[push]") {
  for (const auto& run : test::referenceFile("runs-nominal.json").at("rows")) {
    const bool servo = run.at("controller") == "pc";
    const DeviceModel model = makeModel(test::nominal()),
                      plant = makeModel(servo ? test::nominal() : test::dampedNominal());
    PositionControlRenderer hold = test::positionControl(model, test::asInThePaper());
    ImpedanceRenderer spring(model, {6000.0, 0.0, 4.0});
    const PushSetup setup = test::referenceSetup(run);
    const auto ticks = test::recordPush(plant, servo ? static_cast<Renderer&>(hold) : spring, setup);
    REQUIRE(ticks.size() == run.at("z").size());
    double worst = 0.0;
    Vec6 torque = Vec6::Zero();
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      worst = std::max(worst, std::abs(ticks[i].pose.position.z() - run.at("z")[i].get<double>()));
      torque = torque.cwiseMax(ticks[i].torque.cwiseAbs());
    }
    CHECK(worst < 1e-9);  // measured: 7e-12 m (servo), 2e-10 m (impedance; the reference takes four steps a tick)
    CHECK(test::relativeError(torque, test::vectorFrom<6>(run.at("torque_max"))) < 1e-6);
  }
}

TEST_CASE("the wall's metrics at home are those of the specification", "[push]") {
  const DeviceModel model = makeModel(test::nominal()), damped = makeModel(test::dampedNominal());
  PushSetup setup;
  setup.person.noise = 0.0;
  PositionControlRenderer hold = test::positionControl(model, test::asInThePaper());
  MetricsCollector servo(setup), spring(setup);
  (void)runPush(model, hold, setup, [&](const TickRecord& t) { servo.add(t); });
  ImpedanceRenderer impedance(model, {6000.0, 0.0, 4.0});
  (void)runPush(damped, impedance, setup, [&](const TickRecord& t) { spring.add(t); });
  CHECK(*servo.metrics().firstStiffness == Approx(27e3).epsilon(0.05));
  CHECK(*spring.metrics().firstStiffness == Approx(3.06e3).epsilon(0.01));
  CHECK(spring.metrics().steadyDepth == Approx(12.0 / 6000.0).epsilon(0.01));
  CHECK(servo.metrics().largestDepth < 1e-3);
  CHECK(servo.metrics().drift < 1e-3);
  CHECK(servo.metrics().faults == 0);
}

TEST_CASE("scenario 2: the hand arrives where its force is F_c", "[push]") {
  // Positions and velocities are continuous, and the acceleration is the paper's in every phase.
  const double force = 11.0, a = force / 9.9;
  CHECK(handMotion(force, 0.5).position == 0.0);
  CHECK(handMotion(force, 2.0).position == Approx(-force / 40.0).epsilon(1e-14));
  CHECK(handMotion(force, 3.0).position == Approx(-force / 40.0).epsilon(1e-14));
  CHECK(handMotion(force, 3.0).velocity == 0.0);
  for (const double t : {1.1, 1.3, 1.5, 1.7, 1.95}) {
    const double h = 1e-4;
    const double velocity = (handMotion(force, t + h).position - handMotion(force, t - h).position) / (2 * h);
    const double acceleration = (handMotion(force, t + h).velocity - handMotion(force, t - h).velocity) / (2 * h);
    CHECK(velocity == Approx(handMotion(force, t).velocity).margin(1e-9));
    CHECK(acceleration == Approx(t < 1.45 ? -a : t < 1.55 ? 0.0 : a).margin(1e-9));
  }
  // Against a wall that holds, the spring's force at rest is F_c to within the penetration over 275 mm.
  const DeviceModel model = makeModel(test::nominal());
  PositionControlRenderer hold = test::positionControl(model);
  PushSetup setup;
  setup.person.scenario = 2;
  setup.person.force = force;
  setup.person.noise = 0.0;
  const auto ticks = test::recordPush(model, hold, setup);
  CHECK(-ticks.back().person[2] == Approx(force).epsilon(1e-3));
  CHECK(ticks.back().normalForce == Approx(force).epsilon(1e-2));
  CHECK(ticks[999].person[2] == Approx(0.0).margin(1e-9));
}

TEST_CASE("the guide holds the free directions, without it the impedance wall drifts", "[push]") {
  const DeviceModel model = makeModel(test::nominal()), plant = makeModel(test::dampedNominal());
  double drift[2];
  for (const bool guide : {false, true}) {
    ImpedanceRenderer impedance(model, {6000.0, 0.0, 4.0});
    PushSetup setup;
    setup.person.guide = guide;
    setup.duration = 2.0;
    MetricsCollector collector(setup);
    (void)runPush(plant, impedance, setup, [&](const TickRecord& t) { collector.add(t); });
    drift[guide] = collector.metrics().drift;
  }
  CHECK(drift[1] < 1e-3);
  CHECK(drift[1] < 0.2 * drift[0]);
}

TEST_CASE("motors: constant delays shift, random ones draw from the queue", "[push]") {
  const RandomStream random(3, 0);
  Vec6 initial = Vec6::Constant(-1.0);
  Motors none({0, 0}, initial), three({3, 3}, initial), mixed({0, 3}, initial);
  int seen[4] = {};
  for (std::uint64_t tick = 0; tick < 4000; ++tick) {
    const Vec6 command = Vec6::Constant(static_cast<double>(tick));
    CHECK(none.actuate(tick, command, random) == command);
    CHECK(three.actuate(tick, command, random)[0] == (tick < 3 ? -1.0 : static_cast<double>(tick) - 3.0));
    const double acting = mixed.actuate(tick, command, random)[0];
    if (tick < 3) continue;
    const int delay = static_cast<int>(static_cast<double>(tick) - acting);
    REQUIRE(delay >= 0);
    REQUIRE(delay <= 3);
    ++seen[delay];
  }
  for (const int count : seen) CHECK(count == Approx(1000).margin(140));  // 5 standard deviations of a binomial
}

TEST_CASE("encoders: rounding, differences, and the low pass settles on the rate", "[push]") {
  const double counts = 163840, count = 2.0 * M_PI / counts, period = 1e-3;
  Encoders exact({false, RateSource::exact, 100.0}, counts, period),
      rounded({true, RateSource::difference, 100.0}, counts, period),
      smooth({true, RateSource::lowPass, 50.0}, counts, period);
  const Vec6 rate = (Vec6() << 0.5, -0.3, 1.0, 0.0, -2.0, 0.01).finished();
  for (int tick = 0; tick < 200; ++tick) {
    const Vec6 q = tick * period * rate;
    CHECK(exact.measure(q, rate).q == q);
    const Measurement m = rounded.measure(q, rate);
    CHECK((m.q - q).cwiseAbs().maxCoeff() <= 0.5 * count * (1.0 + 1e-9));
    if (tick > 0) CHECK((m.rates - rate).cwiseAbs().maxCoeff() <= count / period * (1.0 + 1e-9));
    const Measurement s = smooth.measure(q, rate);
    // The low pass at 50 Hz divides the rounding noise of the difference by about 3.
    if (tick > 100) CHECK((s.rates - rate).cwiseAbs().maxCoeff() <= 0.5 * count / period);
  }
}

TEST_CASE("random numbers: the generator's published vector, uniform and normal moments", "[push]") {
  // Philox4x32-10 of a zero counter and key: 6627e8d5 e169c58d bc57ac4c 9b00dbd8 (Random123, kat_vectors).
  const std::uint64_t bits = (std::uint64_t{0x6627e8d5} << 32) | 0xe169c58d;
  CHECK(RandomStream(0, 0).uniform(RandomStream::Purpose::force, 0) == static_cast<double>(bits >> 11) * 0x1p-53);
  const RandomStream stream(9, 4);
  double sum = 0.0, squares = 0.0, uniform = 0.0;
  const int count = 100000;
  for (int i = 0; i < count; ++i) {
    const double x = stream.normal(RandomStream::Purpose::noise, static_cast<std::uint64_t>(i));
    sum += x;
    squares += x * x;
    uniform += stream.uniform(RandomStream::Purpose::test, static_cast<std::uint64_t>(i));
  }
  // Five standard errors each.
  CHECK(std::abs(sum / count) < 5.0 / std::sqrt(count));
  CHECK(std::abs(squares / count - 1.0) < 5.0 * std::sqrt(2.0 / count));
  CHECK(std::abs(uniform / count - 0.5) < 5.0 * std::sqrt(1.0 / 12.0 / count));
}

TEST_CASE("the same seed gives the same bits, another one does not", "[push]") {
  const DeviceModel model = makeModel(test::nominal());
  PushSetup setup;
  setup.duration = 1.2;
  setup.delay = {0, 3};
  setup.encoders = {true, RateSource::lowPass, 100.0};
  const auto record = [&](std::uint64_t seed, std::uint32_t run) {
    setup.seed = seed;
    setup.run = run;
    PositionControlRenderer renderer = test::positionControl(model);
    std::vector<Vec6> all;
    for (const TickRecord& t : test::recordPush(model, renderer, setup)) all.push_back(t.twist);
    return all;
  };
  const auto first = record(5, 0);
  CHECK(first == record(5, 0));
  CHECK(first != record(6, 0));
  CHECK(first != record(5, 1));
}

TEST_CASE("a default-length run allows the default integration step", "[push]") {
  // One Runge-Kutta step a tick against eight: the plant is slow between ticks.
  const DeviceModel model = makeModel(test::nominal());
  std::vector<TickRecord> runs[2];
  for (const int substeps : {1, 8}) {
    PushSetup setup;
    setup.substeps = substeps;
    setup.duration = 1.5;
    PositionControlRenderer renderer = test::positionControl(model);
    runs[substeps == 8] = test::recordPush(model, renderer, setup);
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < runs[0].size(); ++i)
    worst = std::max(worst, (runs[0][i].pose.position - runs[1][i].pose.position).norm());
  CHECK(worst < 1e-9);
}

TEST_CASE("metrics of a hand-made record", "[push]") {
  PushSetup setup;
  setup.duration = 3.0;
  setup.person.force = 10.0;
  MetricsCollector collector(setup);
  for (std::uint64_t i = 0; i < 3000; ++i) {
    TickRecord t{};
    t.tick = i;
    t.time = 1e-3 * static_cast<double>(i);
    t.person[2] = i >= 1000 ? -10.0 : 0.0;
    // Goes in for 10 ticks to 1 mm, comes out to 0.5 mm and stays.
    const double depth = i < 1000 ? 0.0 : i < 1010 ? 1e-4 * static_cast<double>(i - 1000) : i == 1010 ? 1e-3 : 0.5e-3;
    t.nearest.gap = -depth;
    t.pose.position = {3e-4, 4e-4, -depth};
    t.twist[2] = i >= 1000 && i < 1010 ? -0.1 : 0.0;
    t.torque[4] = i % 2 == 0 ? 0.1 : -0.1;
    t.rendered << 0.3, 0.4, 10.0, 0.0, 0.0, 0.0;
    t.saturated = i % 10 == 0;
    t.status = i == 7 ? Status::stale : Status::ok;
    collector.add(t);
  }
  const PushMetrics m = collector.metrics();
  CHECK(*m.firstDepth == 1e-3);
  CHECK(*m.firstStiffness == Approx(10.0 / 1e-3));
  CHECK(m.steadyDepth == Approx(0.5e-3).epsilon(0.01));
  CHECK(m.steadyCompliance == Approx(m.steadyDepth / 10.0));
  CHECK(m.depth95 == 0.5e-3);
  CHECK(m.largestDepth == 1e-3);
  CHECK(m.chatter == Approx(0.1));
  CHECK(m.saturatedShare == Approx(0.1));
  CHECK(m.tangentialForce == Approx(0.5));
  CHECK(m.work == Approx(-10.0 * 0.1 * 0.01));
  CHECK(m.drift == Approx(5e-4));
  CHECK(m.faults == 1);

  setup.person.scenario = 2;
  MetricsCollector hand(setup);
  hand.add(TickRecord{});
  CHECK_FALSE(hand.metrics().firstDepth.has_value());
}

TEST_CASE("bad setups are refused before anything runs", "[push]") {
  const DeviceModel model = makeModel(test::nominal());
  PositionControlRenderer renderer = test::positionControl(model);
  const auto refuse = [&](auto change, const std::string& message) {
    PushSetup setup;
    change(setup);
    int ticks = 0;
    CHECK_THROWS_WITH(runPush(model, renderer, setup, [&](const TickRecord&) { ++ticks; }), message);
    CHECK(ticks == 0);
  };
  refuse([](PushSetup& s) { s.person.scenario = 3; }, "scenario is 3, must be 1 or 2");
  refuse([](PushSetup& s) { s.person.force = -1; }, "force is -1, must be in 0 to 1000 N");
  refuse([](PushSetup& s) { s.person.noise = std::nan(""); }, "noise is nan, must be in 0 to 1000 N");
  refuse([](PushSetup& s) { s.duration = 1e9; }, "duration is 1e+09, must be in 0 to 3600 s");
  refuse([](PushSetup& s) { s.substeps = 0; }, "substeps is 0, must be in 1 to 1000");
  refuse([](PushSetup& s) { s.delay = {2, 1}; }, "delay is 2..1, must be in 0 to 63 ticks, low first");
  refuse([](PushSetup& s) { s.period = 0.0; }, "period is 0, must be in (0, 0.1] s");
  refuse([](PushSetup& s) { s.encoders.cutoff = 0.0; }, "cutoff of the rate filter is 0, must be greater than 0 Hz");
  refuse([](PushSetup& s) { s.start.position.x() = 1.0; }, "the start pose is unreachable");
}

}  // namespace enamel::test_push
