// The viewer's experiment on its haptic thread. Also run with the thread sanitizer (preset tsan).
#include "runner.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "support/catch.hpp"
#include "support/eventually.hpp"
#include "support/experiments.hpp"
#include "support/run_length.hpp"

namespace enamel::viewer::test_runner {

using namespace fixture;

namespace {

// A haptic thread that runs a permitted number of periods, so that both sides stay together even if processors are
// scarce.
class Haptics {
 public:
  explicit Haptics(Runner& runner) : runner_(runner) {}

  /// Permit periods concurrent with the caller's work, after waiting for the ones before.
  void allow(std::uint64_t periods) {
    REQUIRE(test::eventually([this] { return done_ == allowed_; }));
    allowed_ += periods;
  }
  void finish() { allow(0); }

 private:
  void period() {
    if (done_ == allowed_) return;
    runner_.period();
    ++done_;
  }

  Runner& runner_;
  std::atomic<std::uint64_t> allowed_{0}, done_{0};
  const PeriodicThread thread_{kPeriod, [this] { period(); }};
};

}  // namespace

TEST_CASE("the runner: pause, single ticks, slow motion, replacement", "[experiment]") {
  Runner runner(experiment(shipped("flat-wall.toml"), RendererSlot::positionControl));
  const auto periods = [&runner](int count) {
    for (int i = 0; i < count; ++i) runner.period();
    int samples = 0;
    for (Sample sample; runner.nextSample(sample);) ++samples;
    return samples;
  };
  CHECK(periods(100) == 100);
  RunnerCommand command{RunnerCommand::Kind::slowdown};
  command.number = 10;
  runner.send(command);
  CHECK(periods(100) == 10);
  runner.send({RunnerCommand::Kind::pause});
  CHECK(periods(100) == 0);
  CHECK(runner.frame().paused);
  command = {RunnerCommand::Kind::step};
  command.number = 3;
  runner.send(command);
  CHECK(periods(100) == 3);
  command = {RunnerCommand::Kind::slowdown};
  command.number = 1000;
  runner.send(command);
  runner.send({RunnerCommand::Kind::resume});
  CHECK(periods(3000) == 3);
  CHECK(runner.frame().slowdown == 1000);
  command.number = 1;
  runner.send(command);
  runner.replace(experiment(shipped("box.toml"), RendererSlot::impedance));
  CHECK(periods(10) == 10);
  runner.collect();
  CHECK(runner.frame().selected == RendererSlot::impedance);
  CHECK(runner.frame().record.tick == 9);
  // A queue without a reader fills up and reports it; a replacement without room is dropped, not leaked.
  while (runner.send({RunnerCommand::Kind::pause})) continue;
  runner.replace(experiment(shipped("box.toml"), RendererSlot::impedance));
  // Samples without a reader are dropped and counted.
  runner.period();
  runner.send({RunnerCommand::Kind::resume});
  for (int i = 0; i < 10000; ++i) runner.period();
  CHECK(runner.frame().droppedSamples > 0);
}

TEST_CASE("the same commands on simulated time give the same bits", "[experiment]") {
  std::vector<Vec6> runs[2];
  for (auto& run : runs) {
    Settings settings;
    settings.noise = 0.5;
    settings.delay = {0, 3};
    Runner runner(experiment(shipped("corner.toml"), RendererSlot::impedance, settings));
    RunnerCommand command{RunnerCommand::Kind::handTo};
    command.target = {-0.02, 0.0, -0.02};
    runner.send(command);
    for (int i = 0; i < 1000; ++i) {
      runner.period();
      run.push_back(runner.frame().record.twist);
    }
  }
  CHECK(runs[0] == runs[1]);
}

TEST_CASE("beside a haptic thread: random commands, no sample lost or out of order", "[experiment]") {
  Runner runner(experiment(shipped("flat-wall.toml"), RendererSlot::positionControl));
  test::Random random(602 + test::seed());
  std::uint64_t samples = 0, frames = 0;
  {
    Haptics haptics(runner);
    const int rounds = std::max(150, test::count(300, 30000));
    for (int i = 0; i < rounds; ++i) {
      haptics.allow(5);
      RunnerCommand command{RunnerCommand::Kind::handTo};
      switch (static_cast<int>(random.uniform(0.0, 6.0))) {
        case 0: command.target = random.vector(0.03); break;
        case 1:
          command.kind = RunnerCommand::Kind::select;
          command.number = i % 2;
          break;
        case 2: command.kind = i % 2 == 0 ? RunnerCommand::Kind::pause : RunnerCommand::Kind::resume; break;
        case 3:
          command.kind = RunnerCommand::Kind::slowdown;
          command.number = i % 2 == 0 ? 1 : 5;
          break;
        case 4: command.kind = RunnerCommand::Kind::testPush; break;
        default:
          runner.replace(
              experiment(shipped("box.toml"), i % 2 == 0 ? RendererSlot::impedance : RendererSlot::positionControl));
          continue;
      }
      REQUIRE(runner.send(command));
      runner.collect();
      const Frame& frame = runner.frame();
      frames += frame.record.pose.position.allFinite();
      CHECK(frame.plant == Status::ok);
      for (Sample sample; runner.nextSample(sample);) {
        ++samples;
        REQUIRE(sample.torque.cwiseAbs().maxCoeff() <= 2.0);
      }
    }
    haptics.finish();
  }
  CHECK(samples > 50);
  CHECK(frames > 50);
  CHECK(runner.frame().droppedSamples == 0);
}

TEST_CASE("a thread that draws gets every brick that was cut, also over experiments and restores", "[experiment]") {
  const SceneFile file = tooth();
  const auto piece = std::make_shared<DrilledSolids>(file);
  Pose start;
  start.position = file.start;
  const auto next = [&] {
    return std::make_unique<Experiment>(nominal(), Settings{}, file, start, handAt(file.start), RendererSlot::impedance,
                                        piece);
  };
  std::vector<BrickSamples> copy = samplesOf(*file.solids[0]);
  std::uint64_t taken = 0;
  BrickChange change;
  Runner runner(next());
  const auto take = [&] {
    for (; piece->takeChange(0, change); ++taken) copy[static_cast<std::size_t>(change.brick)] = change.samples;
  };
  RemovedVolume before{};
  {
    Haptics haptics(runner);
    for (int i = 0; i < 120; ++i) {
      haptics.allow(5);
      RunnerCommand command{RunnerCommand::Kind::handTo};
      command.target = {1e-3 * std::sin(0.2 * i), 0.0, -6e-3};
      if (i % 20 == 1) command = {RunnerCommand::Kind::spin}, command.number = i % 40 < 20;
      if (i == 90) command = {RunnerCommand::Kind::undo};
      if (i == 70) {
        before = runner.frame().drilled.removed;
        runner.replace(next());
      } else {
        REQUIRE(runner.send(command));
      }
      runner.collect();
      take();
    }
    haptics.finish();
  }
  CHECK(taken > 20);
  CHECK(before[0] > 0.0);
  for (int i = 0; i < 100; ++i) {  // the rest, without a tick
    piece->publish();
    take();
  }
  CHECK(copy == samplesOf(*file.solids[0]));
  runner.send({RunnerCommand::Kind::restore});
  runner.send({RunnerCommand::Kind::pause});
  for (int i = 0; i < 100; ++i) {
    runner.period();
    take();
  }
  CHECK(runner.frame().drilled.removed == RemovedVolume{});
  CHECK(copy == samplesOf(*file.solids[0]));
}

}  // namespace enamel::viewer::test_runner
