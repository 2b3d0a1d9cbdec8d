// The viewer's haptic side does not allocate: ticks of every renderer, test pushes, grips, commands, dropped samples.
#include "experiment.hpp"

#include "runner.hpp"
#include "servoed_device.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::viewer::test_experiment {

TEST_CASE("a tick of the viewer's experiment, or of two under one hand, allocates nothing", "[realtime]") {
  const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
  for (const auto& [name, pair] : {std::pair{"flat-wall.toml", false},
                                   {"oblique-wall.toml", false},
                                   {"corner.toml", false},
                                   {"box.toml", false},
                                   {"molar.toml", false},
                                   {"jaw.toml", false},
                                   {"flat-wall.toml", true},
                                   {"jaw.toml", true}}) {
    const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/" + std::string(name));
    Pose start;
    start.position = scene.start;
    Hand hand;
    hand.target = hand.position = scene.start;
    Settings settings;
    settings.delay = {0, 1};
    settings.encoders = {true, RateSource::lowPass, 100.0};
    settings.noise = 0.2;
    const auto make = [&] {
      return std::make_unique<Experiment>(device, settings, scene, start, hand, RendererSlot::impedance);
    };
    Runner runner(make());
    if (pair) {
      runner.replace(make(), make());
      runner.period();
    }
    test::Random random(82);
    int contact = 0, tested = 0;
    Sample sample;
    const long before = test::allocationCount();
    constexpr int kPush = 4600;  // ticks: longer than an approach and a push
    bool made = false;
    for (int i = 0; i < 8000; ++i) {
      RunnerCommand command{RunnerCommand::Kind::handTo};
      if (i % 200 == 0) {
        command.target = {random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), random.uniform(-0.025, 0.005)};
        runner.send(command);
      }
      if (i % 700 == 0 && i > kPush) {
        command.kind = RunnerCommand::Kind::select;
        command.number = i / 700 % static_cast<int>(kLinkedRenderers);
        runner.send(command);
        command.kind = RunnerCommand::Kind::selectRight;
        command.number = (i / 700 + 1) % static_cast<int>(kLinkedRenderers);
        runner.send(command);
      }
      if (i % 1500 == 0) {
        command.kind = RunnerCommand::Kind::grip;
        command.grip = i % 3000 == 0 ? kPaperGrip : kFirmGrip;
        runner.send(command);
      }
      if (i == 0) runner.send({RunnerCommand::Kind::testPush});  // until its end
      runner.period();
      const Frame& frame = runner.frame();
      contact += frame.record.mode == RenderMode::contact;
      tested += frame.testing;
      made = made || (i == kPush && !frame.testing && frame.tests[indexOf(frame.selected)].made);
      if (i < 3000) runner.nextSample(sample);
    }
    const long allocated = test::allocationCount() - before;
    INFO(name << (pair ? ", two" : ""));
    CHECK(allocated == 0);
    CHECK(contact > 500);
    CHECK(tested > 100);
    CHECK(made);
    CHECK(runner.frame().plant == Status::ok);
    CHECK((runner.secondFrame() != nullptr) == pair);
  }
}

}  // namespace enamel::viewer::test_experiment
