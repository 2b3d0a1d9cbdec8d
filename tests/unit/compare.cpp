// The comparison of the split screen: presses and depths, with both tools under one hand.
#include "compare.hpp"

#include <cstring>

#include "enamel/collision/scene_file.hpp"
#include "runner.hpp"
#include "servoed_device.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "tour.hpp"

namespace enamel::viewer::test_compare {

namespace {

PairSample pairAt(double leftDepth, double leftForce, double rightDepth, double rightForce) {
  return {{{{leftDepth, leftForce}, {rightDepth, rightForce}}}};
}

void addFor(Comparison& both, const PairSample& sample, int ticks) {
  for (int i = 0; i < ticks; ++i) both.add(sample);
}

const PairSample kOut = pairAt(-1e-3, 0.0, -1e-3, 0.0);

// Return a runner with two tools on the flat wall.
std::unique_ptr<Runner> pairRunner(RendererSlot left, RendererSlot right, const Settings& settings = {}) {
  static const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
  const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml");
  Pose start;
  start.position = scene.start;
  Hand hand;
  hand.target = hand.position = scene.start;
  const auto make = [&](RendererSlot slot) {
    return std::make_unique<Experiment>(device, settings, scene, start, hand, slot);
  };
  auto runner = std::make_unique<Runner>(make(left));
  runner->replace(make(left), make(right));
  return runner;
}

void send(Runner& runner, RunnerCommand::Kind kind, const Vec3& target = Vec3::Zero()) {
  RunnerCommand command{kind};
  command.target = target;
  REQUIRE(runner.send(command));
}

bool isSame(const Hand& a, const Hand& b) {
  return a.target == b.target && a.position == b.position && a.velocity == b.velocity &&
         a.grip.stiffness == b.grip.stiffness;
}

}  // namespace

TEST_CASE("the deepest points are those of one press, and kept until the next one", "[compare]") {
  Comparison both;
  addFor(both, kOut, 500);
  CHECK(both.deepest(1) == 0.0);
  addFor(both, pairAt(1e-5, 5.0, 1e-3, 4.0), 10);
  addFor(both, pairAt(4e-5, 8.0, 2e-3, 12.0), 10);
  addFor(both, pairAt(1e-5, 5.0, 1e-3, 4.0), 10);
  CHECK(both.deepest(0) == 4e-5);
  CHECK(both.deepest(1) == 2e-3);
  CHECK(both.strongest(0) == 8.0);
  CHECK(both.strongest(1) == 12.0);
  // It bounces out and in again: still the same press.
  addFor(both, kOut, Comparison::kApart - 1);
  addFor(both, pairAt(5e-5, 8.0, 1e-3, 4.0), 10);
  CHECK(both.deepest(0) == 5e-5);
  CHECK(both.deepest(1) == 2e-3);
  // Out for long, the press is kept. The next touch begins a new one.
  addFor(both, kOut, 5 * Comparison::kApart);
  CHECK(both.deepest(1) == 2e-3);
  addFor(both, pairAt(3e-3, 8.0, 1e-3, 4.0), 2);
  CHECK(both.deepest(0) == 3e-3);
  CHECK(both.deepest(1) == 1e-3);
  CHECK(both.curve(0).size() == 2);
}

TEST_CASE("a ratio needs two measured pushes; a depth below the least gives a bound", "[compare]") {
  TestPush left, right;
  left.made = right.made = true;
  left.verdict = FirstImpactVerdict::measured;
  left.deepest = 4e-5;
  right.deepest = 2e-3;
  CHECK_FALSE(ratioOf(left, right));
  right.verdict = FirstImpactVerdict::measured;
  REQUIRE(ratioOf(left, right));
  CHECK(ratioOf(left, right)->deeper == 1);
  CHECK(ratioOf(right, left)->deeper == 0);
  CHECK(ratioOf(left, right)->times == Approx(50.0));
  CHECK_FALSE(ratioOf(left, right)->atLeast);
  left.deepest = 1e-7;
  CHECK(ratioOf(left, right)->atLeast);
  CHECK(ratioOf(left, right)->times == Approx(2e-3 / DepthRatio::kLeast));
  left.made = false;
  CHECK_FALSE(ratioOf(left, right));
}

TEST_CASE("curves keep a long press whole in a bounded number of points", "[compare]") {
  Comparison both;
  constexpr int ticks = 60'000;
  for (int i = 1; i <= ticks; ++i) {
    const double share = static_cast<double>(i) / ticks;
    both.add(pairAt(1e-4 * share, 10.0 * share, 2e-3 * share, 12.0 * share));
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& curve = both.curve(side);
    CHECK(curve.size() <= static_cast<std::size_t>(Comparison::kCurve));
    CHECK(curve.size() >= static_cast<std::size_t>(Comparison::kCurve) / 2);
    // Even steps from near the beginning to near the end.
    const double step = 1.0 / static_cast<double>(curve.size()), end = side == 0 ? 1e-4 : 2e-3;
    CHECK(curve.front().depth < 2.0 * step * end);
    CHECK(curve.back().depth > (1.0 - 2.0 * step) * end);
    for (std::size_t i = 1; i < curve.size(); ++i) CHECK(curve[i].depth > curve[i - 1].depth);
  }
  // The last bin is complete and has the newest depths.
  CHECK(both.depth(1, Comparison::History::kBins - 1).high == Approx(2e-3).epsilon(1e-3));
  CHECK(both.depth(1, 0).high < both.depth(1, Comparison::History::kBins - 1).low);
}

TEST_CASE("two tools are under one hand, tick for tick, and each has the force of its own depth", "[compare]") {
  const auto runner = pairRunner(RendererSlot::positionControl, RendererSlot::impedance);
  Comparison both;
  test::Random random(711);
  for (int move = 0; move < 8; ++move) {
    Vec3 target(0.0, 0.0, -0.02);
    if (move < 7)
      for (int axis = 0; axis < 3; ++axis) target[axis] = random.uniform(axis < 2 ? -0.01 : -0.06, 0.01);
    send(*runner, RunnerCommand::Kind::handTo, target);
    for (int i = 0; i < 1500; ++i) {
      runner->period();
      const Frame& left = runner->frame();
      REQUIRE(runner->secondFrame() != nullptr);
      const Frame& right = *runner->secondFrame();
      REQUIRE(left.record.tick == right.record.tick);
      REQUIRE(isSame(left.hand, right.hand));
      // Both tools are within reach of the hand, except for their motion in a tick.
      for (const Frame* frame : {&left, &right}) {
        const Vec3 stretch = frame->hand.target - frame->record.pose.position;
        REQUIRE(stiffnessOf(frame->hand.grip).cwiseProduct(stretch).norm() < kLargestHandForce + 1.5);
      }
      for (PairSample sample; runner->nextPair(sample);) both.add(sample);
    }
  }
  const Frame &left = runner->frame(), &right = *runner->secondFrame();
  // At rest: 20 mm of the hand at 400 N/m against a rigid wall, and against one of 6 kN/m.
  const double sunk = 0.02 * 400.0 / (400.0 + 6000.0);
  CHECK(-right.record.nearest.gap == Approx(sunk).epsilon(0.02));
  CHECK(std::abs(left.record.nearest.gap) < 2e-5);
  // The servo reacts to encoder counts: its mean force is the hand's.
  std::array<double, 2> mean{};
  constexpr int kTicks = 500;
  for (int i = 0; i < kTicks; ++i) {
    runner->period();
    const PairSample now = pairOf(runner->frame().record, runner->secondFrame()->record);
    for (std::size_t side = 0; side < 2; ++side) mean[side] += now.side[side].force / kTicks;
  }
  CHECK(mean[0] == Approx(8.0).epsilon(0.03));
  CHECK(mean[1] == Approx(6000.0 * sunk).epsilon(0.03));
  CHECK(both.deepest(1) > 10.0 * both.deepest(0));
}

TEST_CASE("the left tool of a pair moves as it does alone where the other one does not hold the hand back",
          "[compare]") {
  const auto pair = pairRunner(RendererSlot::impedance, RendererSlot::positionControl);
  const auto alone = pairRunner(RendererSlot::impedance, RendererSlot::impedance);
  for (Runner* runner : {pair.get(), alone.get()}) send(*runner, RunnerCommand::Kind::handTo, {0.004, 0.002, -0.015});
  for (int i = 0; i < 1500; ++i) {
    pair->period();
    alone->period();
    REQUIRE(pair->frame().record.pose.position == alone->frame().record.pose.position);
  }
  // Two equal tools move equally.
  CHECK(alone->frame().record.pose.position == alone->secondFrame()->record.pose.position);
}

TEST_CASE("a test push steps on both in the same tick, also where one needs longer to come to rest", "[compare]") {
  const auto runner = pairRunner(RendererSlot::positionControl, RendererSlot::impedance);
  send(*runner, RunnerCommand::Kind::testPush);
  int jumped[2] = {-1, -1};
  for (int i = 0; i < 6000; ++i) {
    runner->period();
    const Frame* const frames[] = {&runner->frame(), runner->secondFrame()};
    for (int side = 0; side < 2; ++side)
      if (jumped[side] < 0 && frames[side]->testing && -frames[side]->record.handWrench.z() > 10.0) jumped[side] = i;
    if (i > 10 && !frames[0]->testing && !frames[1]->testing) break;
  }
  CHECK(jumped[0] > 0);
  CHECK(jumped[0] == jumped[1]);
  const TestPush left = runner->frame().tests[indexOf(RendererSlot::positionControl)],
                 right = runner->secondFrame()->tests[indexOf(RendererSlot::impedance)];
  CHECK(left.verdict == FirstImpactVerdict::measured);
  CHECK(right.verdict == FirstImpactVerdict::measured);
  CHECK(left.stiffness > 20.0 * right.stiffness);
  CHECK(right.deepest >= right.depth);  // below the surface, not below the rest under the preload
  REQUIRE(ratioOf(left, right));
  CHECK(ratioOf(left, right)->deeper == 1);
  CHECK(ratioOf(left, right)->times > 50.0);
  // Then one hand moves both again.
  send(*runner, RunnerCommand::Kind::handBy, {0.001, 0.0, 0.0});
  runner->period();
  const Frame& one = runner->frame();
  CHECK(isSame(one.hand, runner->secondFrame()->hand));
  CHECK_FALSE(runner->secondFrame()->testing);
}

TEST_CASE("the tour ends where it begins, at a hand's speed, and shows what it says", "[compare]") {
  const auto runner = pairRunner(RendererSlot::positionControl, RendererSlot::impedance);
  const Frame first = runner->frame();
  const Vec3 start = first.record.pose.position;
  const Tour tour(start, first.record.nearest, kFirmGrip);
  CHECK(tour.hand(0.0) == start);
  CHECK(tour.hand(-1.0) == start);
  CHECK(tour.hand(Tour::kLength) == start);
  CHECK(tour.hand(2.0 * Tour::kLength) == start);
  CHECK(Tour::part(0.0) == 0);
  CHECK(Tour::part(Tour::kLength) == Tour::kParts - 1);
  Comparison both;
  std::array<Vec3, Tour::kParts> low, high;  // positions of contact
  low.fill(Vec3::Constant(1.0));
  high.fill(Vec3::Constant(-1.0));
  std::array<double, Tour::kParts> deepest{};
  for (int i = 0; i < static_cast<int>(Tour::kLength / kPeriod); ++i) {
    const double time = i * kPeriod;
    REQUIRE((tour.hand(time + kPeriod) - tour.hand(time)).norm() < 0.5 * kPeriod);  // m/s
    send(*runner, RunnerCommand::Kind::handTo, tour.hand(time));
    runner->period();
    const Frame& left = runner->frame();
    REQUIRE(left.plant == Status::ok);
    REQUIRE(left.record.guard == GuardReason::none);
    REQUIRE(runner->secondFrame()->record.guard == GuardReason::none);
    const std::size_t part = Tour::part(time);
    deepest[part] = std::max(deepest[part], -runner->secondFrame()->record.nearest.gap);
    if (left.record.mode == RenderMode::contact) {
      low[part] = low[part].cwiseMin(left.record.pose.position);
      high[part] = high[part].cwiseMax(left.record.pose.position);
    }
    for (PairSample sample; runner->nextPair(sample);) both.add(sample);
  }
  // The test push is in the first part. The hand presses in the others, and slides in the second one.
  CHECK(deepest[0] < 1e-6);
  CHECK(deepest[1] > 1e-3);
  CHECK(deepest[2] > 1e-3);
  CHECK(high[1].x() - low[1].x() > 0.015);
  CHECK(runner->frame().record.nearest.gap > 1e-3);
}

TEST_CASE("a pair is replaced by one, and one by a pair; the right renderer is chosen by its own command",
          "[compare]") {
  const auto runner = pairRunner(RendererSlot::positionControl, RendererSlot::impedance);
  runner->period();
  RunnerCommand command{RunnerCommand::Kind::selectRight};
  command.number = static_cast<int>(indexOf(RendererSlot::hold));
  REQUIRE(runner->send(command));
  runner->period();
  CHECK(runner->frame().selected == RendererSlot::positionControl);
  CHECK(runner->secondFrame()->selected == RendererSlot::hold);
  const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml");
  Pose start;
  start.position = scene.start;
  runner->replace(std::make_unique<Experiment>(loadServoedDevice(test::deviceFile("tau-nominal.toml")), Settings{},
                                               scene, start, runner->frame().hand, RendererSlot::impedance));
  runner->period();
  runner->frame();
  CHECK(runner->secondFrame() == nullptr);
  REQUIRE(runner->send(command));  // the right tool has gone
  runner->period();
  CHECK(runner->frame().selected == RendererSlot::impedance);
}

}  // namespace enamel::viewer::test_compare
