// The guard in difficult cases: invalid input, walls known to be bad, and ordinary runs, which it must not change.
#include "enamel/render/guard.hpp"

#include <iostream>

#include "enamel/control/device_plant.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/imperfect_plant.hpp"
#include "enamel/study/monte_carlo.hpp"
#include "support/catch.hpp"
#include "support/garbage.hpp"
#include "support/guard_step.hpp"
#include "support/pushes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_guard {

TEST_CASE("garbage into the guard: finite, within the limits and the slew, always", "[hard]") {
  constexpr std::uint64_t seed = 20;
  const int ticks = test::count(200000, 10000000);
  const TauMechanism device(test::nominal());
  GuardOptions options = guardFor(device, 1e-3);
  options.slew *= 0.1;
  options.force = 20.0;
  options.rampIn = 3e-3;
  Guard guard(device, options);
  test::Random random(seed);
  Kinematics k = device.home();
  Measurement m;
  JointVector last;
  double time = 0.0;
  std::array<int, 32> reasons{};
  for (int i = 0; i < ticks; ++i) {
    const double chance = random.uniform(0.0, 1.0);
    if (chance < 0.05) guard.reset();
    // Mostly a tool that moves slowly with small requests, so that every stage is reached; sometimes invalid values.
    k = device.home();
    m.q = k.q + JointVector::Constant(6, 1e-5 * std::sin(1e-2 * i));
    k.q = m.q;
    m.rates = JointVector::Zero(6);
    m.applied.reset();
    if (random.uniform(0.0, 1.0) >= 0.5) m.applied = k.gravity;
    m.time = time += 1e-3;
    m.enabled = random.uniform(0.0, 1.0) < 0.999;
    JointVector requested = k.gravity + JointVector::Constant(6, random.uniform(0.0, 1.0) < 0.9 ? 0.01 : 5.0);
    Vec3 surface = Vec3::Zero();
    Status status = Status::ok;
    if (random.uniform(0.0, 1.0) < 0.03) {
      double* numbers[] = {
          &m.time,          m.q.data(),        m.rates.data(),   k.pose.position.data(),
          k.twist.data(),   k.jacobian.data(), k.gravity.data(), k.inverseTransposed.data(),
          requested.data(), surface.data(),    k.q.data(),       m.applied ? m.applied->data() : nullptr};
      const int sizes[] = {1, 6, 6, 3, 6, 36, 6, 36, 6, 3, 6, m.applied ? 6 : 0};
      for (int blows = static_cast<int>(random.uniform(1.0, 4.0)); blows > 0; --blows) {
        const int field = static_cast<int>(random.uniform(0.0, 12.0));
        if (sizes[field] == 0) continue;
        numbers[field][static_cast<int>(random.uniform(0.0, sizes[field]))] = test::garbage(random);
        if (field == 1 && random.uniform(0.0, 1.0) < 0.5) k.q = m.q;  // the mechanism uses the wrong value
      }
      if (random.uniform(0.0, 1.0) < 0.2) requested.conservativeResize(static_cast<int>(random.uniform(0.0, 8.0)));
      if (random.uniform(0.0, 1.0) < 0.2) m.q.conservativeResize(static_cast<int>(random.uniform(0.0, 8.0)));
      if (random.uniform(0.0, 1.0) < 0.2) status = static_cast<Status>(random.uniform(0.0, kStatuses));
    }
    const test::GuardedCommand c = test::guardStep(guard, m, k, requested, status, surface);
    ++reasons[static_cast<std::size_t>(c.reason)];
    REQUIRE(c.effort.size() == 6);
    REQUIRE(c.effort.allFinite());
    REQUIRE((c.effort.cwiseAbs() - options.torque).maxCoeff() <= 0.0);
    if (i > 0) REQUIRE(((c.effort - last).cwiseAbs() - 1e-3 * options.slew).maxCoeff() <= 1e-12);
    REQUIRE(std::isfinite(guard.tick(0).energy));
    last = c.effort;
  }
  std::cout << ticks << " ticks, seed " << seed << ":";
  for (std::size_t i = 0; i < reasons.size(); ++i)
    if (reasons[i] > 0) std::cout << " " << toString(static_cast<GuardReason>(i)) << " " << reasons[i] << ";";
  std::cout << "\n";
  for (const GuardReason seen : {GuardReason::none, GuardReason::slew, GuardReason::measurement, GuardReason::jump,
                                 GuardReason::clock, GuardReason::renderer, GuardReason::unreachable})
    CHECK(reasons[static_cast<std::size_t>(seen)] > 0);
}

TEST_CASE("walls that are known to be bad are stopped by their energy", "[hard]") {
  const auto device = std::make_shared<TauMechanism>(test::nominal());
  const GuardOptions options = guardFor(*device, 1e-3);
  for (const double force : {2.0, 12.0})
    for (const bool hold : {false, true}) {
      HoldRenderer paper = test::holdRenderer(test::asInThePaper());
      ImpedanceRenderer spring({20e3, 0.0});
      PushSetup setup;
      setup.delay = hold ? Delay{2, 2} : Delay{3, 3};
      setup.hand.force = force;
      setup.encoders = {true, RateSource::difference, 100.0};
      const auto ticks = [&] {
        std::vector<TickRecord> all;
        const PushResult result = runPush(*device, hold ? static_cast<Renderer&>(paper) : spring, setup,
                                          [&all](const TickRecord& t) { all.push_back(t); });
        CHECK(result.status == Status::stopped);
        CHECK(result.guard == GuardReason::energy);
        return all;
      }();
      // Energy of the tool that the person did not give: kinetic only, because the device has no springs.
      Kinematics k;
      const TickRecord& end = ticks.back();
      REQUIRE(device->reach(end.pose, end.twist, true, k) == Status::ok);
      double given = 0.0, way = 0.0;
      for (const TickRecord& t : ticks) {
        given += 1e-3 * t.handWrench.dot(t.twist);
        way = std::max(way, (t.pose.position - setup.start.position).norm());
      }
      const double motion = 0.5 * k.rates.dot(k.inertia * k.rates);
      std::cout << (hold ? "hold, delay 2" : "spring of 20 kN/m, delay 3") << ", " << force << " N: stopped at "
                << end.time << " s, moved " << 1e3 * way << " mm, " << 1e3 * motion << " mJ of motion, of these "
                << 1e3 * (motion - given) << " mJ not from the person, budget " << 1e3 * options.energy << " mJ\n";
      // A tick's work above the budget: 60 N over 0.5 mm. Rounding to counts hides the same amount again.
      CHECK(motion - given < options.energy + 0.03);
      CHECK((way < 2e-3 || motion - given < 0.05));
    }
}

namespace {

// A push of 8 to 15 N that begins at a random instant.
PushSetup hardPush(int delay, std::uint32_t run) {
  PushSetup setup;
  setup.delay = {delay, delay};
  setup.encoders = {true, RateSource::difference, 100.0};
  setup.duration = 1.2;
  setup.run = run;
  setup.hand.preload = 1.0;
  setup.hand.force = 8.0 + 0.5 * (run % 15);
  setup.hand.instant = randomInstant(setup.seed, run);
  return setup;
}

// Position control for `device` passes hard pushes. A spring without damping is stopped. push(renderer, delay, run).
template <typename Push>
void checkOnlySpringStops(const Mechanism& device, const Push& push) {
  for (const int delay : {0, 1, 2})
    for (int run = 0; run < test::count(10, 200); ++run) {
      PositionControlRenderer servo(positionControlFor(device, 1e-3, delay, delay));
      INFO("delay " << delay << ", run " << run);
      CHECK(push(servo, delay, static_cast<std::uint32_t>(run)).status == Status::ok);
    }
  ImpedanceRenderer spring({20e3, 0.0});
  const PushResult result = push(spring, 3, 0);
  CHECK(result.status == Status::stopped);
  CHECK(result.guard == GuardReason::energy);
}

}  // namespace

// Cables of 300 N m/rad: one tick of the largest torque gives a rotor 24 mJ, but little of it reaches the tool.
TEST_CASE("behind soft cables position control is left alone, and a spring that gives energy is stopped", "[hard]") {
  DeviceParameters file = loadDevice(test::deviceFile("tau-detailed.toml"));
  std::get<TauParameters>(file).imperfections.cableStiffness = 300.0;
  const std::shared_ptr<const Mechanism> model = makeMechanism(file);
  const auto push = [&](Renderer& renderer, int delay, std::uint32_t run) {
    const PushSetup setup = hardPush(delay, run);
    return runPush(std::make_unique<ImperfectPlant>(makeImperfectDevice(file, setup.seed, run)), *model, renderer,
                   setup, [](const TickRecord&, const VirtualLoop&) {});
  };
  checkOnlySpringStops(*model, push);
}

namespace {

// A spring that states a stiffness of the cables as if it had learnt it.
class Stating final : public Renderer {
 public:
  explicit Stating(double cables) : cables_(cables) {}

 private:
  void prepare(double period) override { spring_.activate(period); }
  Status render(const TickFrame& frame, TickOutput& output) noexcept override {
    const Status status = spring_.step(frame, output);
    output.cables = cables_;
    return status;
  }
  void resetState() noexcept override { spring_.reset(); }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  ImpedanceRenderer spring_{{3e3, 30.0}};
  double cables_;
};

}  // namespace

TEST_CASE("the guard counts with the stiffness of the cables that the renderer has learnt", "[hard]") {
  const double factor = std::exp(0.3);  // three steps of its models
  const DeviceParameters device = loadDevice(test::deviceFile("tau-detailed.toml"));
  const PushSetup setup = hardPush(0, 3);
  const auto energies = [&](double file, double stated) {
    DeviceParameters model = device;
    imperfectionsOf(model).cableStiffness *= file;
    const std::shared_ptr<const Mechanism> mechanism = makeMechanism(model);
    Stating renderer(stated);
    std::vector<double> all;
    const auto note = [&](const TickRecord&, const VirtualLoop& loop) { all.push_back(loop.guard().tick(0).energy); };
    CHECK(runPush(std::make_unique<ImperfectPlant>(makeImperfectDevice(device, setup.seed, 3)), *mechanism, renderer,
                  setup, note)
              .status == Status::ok);
    return all;
  };
  const std::vector<double> right = energies(1.0, 0.0), learnt = energies(factor, -0.301),
                            wrong = energies(factor, 0.0), refused = energies(1.0, std::nan("")),
                            limited = energies(1.0, 100.0), most = energies(1.0, 0.501);
  REQUIRE(right.size() == learnt.size());
  double error = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < right.size(); ++i) {
    error = std::max(error, std::abs(learnt[i] - right[i]));
    largest = std::max(largest, std::abs(wrong[i] - right[i]));
  }
  CHECK(error < 1e-9);
  CHECK(largest > 1e-6);
  CHECK(refused == right);
  CHECK(limited == most);
}

TEST_CASE("where the device lacks the cables of its file, the guard counts as with a rigid transmission", "[hard]") {
  const DeviceParameters file = loadDevice(test::deviceFile("tau-detailed.toml"));
  const std::shared_ptr<const Mechanism> model = makeMechanism(file), rigid = makeMechanism(idealOf(file));
  const auto push = [&](Renderer& renderer, int delay, std::uint32_t run) {
    const PushSetup setup = hardPush(delay, run);
    return runPush(std::make_unique<ClosedFormPlant>(*rigid), *model, renderer, setup,
                   [](const TickRecord&, const VirtualLoop&) {});
  };
  checkOnlySpringStops(*rigid, push);
}

TEST_CASE("ordinary study runs pass untouched", "[hard]") {
  const auto device = std::make_shared<TauMechanism>(test::nominal());
  const auto damped = std::make_shared<TauMechanism>(test::dampedNominal());
  int runs = 0, ticks = 0, unstable = 0;
  for (int delay = 0; delay <= 4; ++delay) {  // 4: random
    StudyPlan plan;
    plan.setup.delay = delay < 4 ? Delay{delay, delay} : Delay{0, 3};
    const PositionControlOptions servo = positionControlFor(*device, 1e-3, plan.setup.delay.low, plan.setup.delay.high);
    plan.columns.push_back(
        {"servo", device, [&](std::size_t) { return std::make_unique<PositionControlRenderer>(servo); }});
    if (delay == 0) {
      plan.columns.push_back({"hold", device, [](std::size_t) {
                                return std::make_unique<HoldRenderer>(test::referenceGain(), 1e-3,
                                                                      test::asInThePaper());
                              }});
      plan.columns.push_back(
          {"spring", damped, [](std::size_t) { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{}); }});
    }
    plan.setup.encoders = {true, RateSource::difference, 100.0};
    plan.setup.hand.preload = 1.0;
    plan.insideTick = true;
    plan.runs = 6;
    plan.setup.seed = 4;
    checkStudy(plan);
    const std::size_t wanted = static_cast<std::size_t>(test::count(30, delay == 0 ? 4000 : 1500));
    const std::size_t step = std::max<std::size_t>(1, plan.size() / wanted);
    for (std::size_t i = delay; i < plan.size(); i += step) {
      const StudyResult result = performRun(plan, runAt(plan, i), [&](const TickRecord& t) {
        ++ticks;
        REQUIRE(t.guard == GuardReason::none);
        REQUIRE(t.command == t.requested);
      });
      REQUIRE(result.status == Status::ok);
      INFO(plan.columns[result.run.column].name << ", scenario " << result.run.scenario << ", delay " << delay);
      // Under random delay one run in a thousand oscillates (lib/docs/limits.md).
      unstable += result.metrics.verdict == FirstImpactVerdict::unstable;
      REQUIRE(unstable <= (delay < 4 ? 0 : 5));
      ++runs;
    }
  }
  std::cout << runs << " runs, " << ticks << " ticks, none touched; " << unstable << " unstable, of random delay\n";
}

TEST_CASE("a loop that is unstable and stays inside is called unstable", "[hard]") {
  // Without the guard, the paper's gain with a tick of delay and rates from encoders oscillates at a motor's limit.
  const TauMechanism device(test::nominal());
  for (const int scenario : {1, 2}) {
    HoldRenderer paper = test::holdRenderer(test::asInThePaper());
    PushSetup setup;
    setup.guarded = false;
    setup.delay = {1, 1};
    setup.encoders = {true, RateSource::difference, 100.0};
    setup.hand.scenario = scenario;
    MetricsCollector collector(setup, 0.0, device.limits().effort);
    CHECK(runPush(device, paper, setup, [&](const TickRecord& t) { collector.add(t); }).status == Status::ok);
    const PushMetrics m = collector.metrics();
    CHECK(m.chatter > 0.5);
    CHECK(m.verdict == FirstImpactVerdict::unstable);
    CHECK_FALSE(m.firstStiffness.has_value());
  }
}

TEST_CASE("hold goes with a wall that moves, and back to the surface in small steps", "[hard]") {
  const TauMechanism device(test::nominal());
  const auto hand = [](double z) { return test::handAt(z, 200.0, 8.0); };
  // A first touch 20 mm deep causes no kick.
  HoldRenderer hold = test::holdRenderer();
  LoopSetup setup;
  setup.guarded = false;
  setup.start.position.z() = -0.02;
  VirtualLoop loop(device, hold, setup);
  TickRecord record;
  double fastest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    REQUIRE(loop.tick(hand(-0.03), record) == Status::ok);
    fastest = std::max(fastest, record.twist.head<3>().norm());
  }
  std::cout << "touch at 20 mm: " << fastest << " m/s, then at " << 1e3 * record.pose.position.z() << " mm\n";
  CHECK(fastest < 0.15);
  CHECK(std::abs(record.pose.position.z()) < 1e-3);

  // A wall that approaches at 20 mm/s pushes the tool along.
  Scene moving = flatWall();
  HoldRenderer carried = test::holdRenderer();
  VirtualDeviceSetup start;
  VirtualDevice plant(device, start);
  HapticTick tick(device, moving, Tool(), carried, 1e-3);
  Measurement m;
  Command command;
  double deepest = 0.0, fast = 0.0;
  for (int i = 0; i < 1000; ++i) {
    Pose pose;
    pose.position.z() = i < 200 ? 0.0 : 2e-5 * (i - 200);
    moving.move(0, pose, i < 200 ? Vec6(Vec6::Zero()) : Vec6(0.02 * Vec6::Unit(2)));
    REQUIRE(plant.measure(m) == Status::ok);
    REQUIRE(tick(m, command) == Status::ok);
    REQUIRE(plant.actuate(command) == Status::ok);
    REQUIRE(plant.advance(hand(-0.02)) == Status::ok);
    deepest = std::max(deepest, pose.position.z() - plant.state().position.z());
    fast = std::max(fast, plant.state().twist.head<3>().norm());
  }
  std::cout << "wall at 20 mm/s: " << 1e3 * deepest << " mm deep, " << fast << " m/s\n";
  CHECK(deepest < 1e-3);
  CHECK(fast < 0.1);
}

TEST_CASE("the virtual device ends where its model does", "[hard]") {
  const TauMechanism device(test::nominal());
  VirtualDevice plant(device, VirtualDeviceSetup{});
  Measurement m;
  const auto blow = [](double, const Pose&, const Vec6&) { return Vec6(1e6 * Vec6::Unit(3)); };
  REQUIRE(plant.measure(m) == Status::ok);
  const DeviceState before = plant.state();
  CHECK(plant.advance(blow) != Status::ok);
  CHECK(plant.state().position == before.position);
  CHECK(plant.state().twist == before.twist);
  CHECK(plant.tick() == 0);
}

}  // namespace enamel::test_guard
