// Timing of the viewer's haptic loop without drawing, and beside a window under Xvfb. Long runs also measure it while
// it drills, and beside a loop that does nothing. Reported only.
#include <chrono>
#include <cstdio>
#include <thread>

#include "runner.hpp"
#include "servoed_device.hpp"
#include "support/devices.hpp"
#include "support/eventually.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

namespace enamel::viewer::test_viewer {

namespace {

const double kSeconds = test::count(4, 10);

void report(const std::string& beside, bool realtime, double periods, double missed, const double (&us)[5]) {
  std::printf(
      "%-32s %s: missed %.0f of %.0f; wake-up p50 %.0f us, p99.9 %.0f us; compute p50 %.1f us, p99.9 %.1f us, "
      "max %.0f us\n",
      beside.c_str(), realtime ? "real-time class" : "normal class", missed, periods, us[0], us[1], us[2], us[3],
      us[4]);
  CHECK(periods > 0.0);
}

void report(const std::string& beside, const PeriodicTiming& t) {
  report(beside, t.realtime, static_cast<double>(t.periods), static_cast<double>(t.missed),
         {1e6 * t.wakeUp.quantile(0.5), 1e6 * t.wakeUp.quantile(0.999), 1e6 * t.compute.quantile(0.5),
          1e6 * t.compute.quantile(0.999), 1e6 * t.compute.largest()});
}

void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

// Press the tool into the scene, with a spinning bur if it has one: without pictures, and in a window.
void measure(const std::string& name) {
  const std::string file = ENAMEL_SOURCE_DIR "/data/scenes/" + name + ".toml";
  {
    const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
    const SceneFile scene = loadScene(file);
    Pose start;
    start.position = scene.start;
    Hand hand;
    hand.position = scene.start;
    hand.target = {0.0, 0.0, -0.02};
    Runner runner(std::make_unique<Experiment>(device, Settings{}, scene, start, hand, RendererSlot::positionControl));
    RunnerCommand spin{RunnerCommand::Kind::spin};
    spin.number = 1;
    runner.send(spin);
    const PeriodicThread haptics(kPeriod, [&runner] { runner.period(); });
    for (int i = 0; i < 60 * static_cast<int>(kSeconds); ++i) {
      pause(1.0 / 60.0);
      for (Sample sample; runner.nextSample(sample);) continue;
    }
    report(name + ", nothing drawn", haptics.timing());
    CHECK(test::eventually([&] { return runner.frame().record.mode == RenderMode::contact; }));
  }
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", std::string(name == "drill" ? "0 spin on\n" : "") + "0 hand 0 0 -20\n" +
                                             std::to_string(kSeconds) + " end\n");
  const auto result = test::viewer(
      "'" + file + "' --script '" + folder / "script.txt' --report '" + folder / "report.json'", test::kXvfb);
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto json = nlohmann::json::parse(test::readFile(folder / "report.json"));
  const auto& h = json.at("haptics");
  report(name + ", window of 1280x720", h.at("realtime_class"), h.at("periods"), h.at("missed"),
         {h.at("wake_up_us").at("p50"), h.at("wake_up_us").at("p99.9"), h.at("compute_us").at("p50"),
          h.at("compute_us").at("p99.9"), h.at("compute_us").at("max")});
  std::printf("window: first frame after %.2f s, %.0f frames/s\n", json.at("first_frame_s").get<double>(),
              json.at("frames_per_second").get<double>());
}

}  // namespace

TEST_CASE("missed ticks without and with rendering", "[timing]") {
  if (test::longRun()) {  // the machine's own missed deadlines
    const PeriodicThread nothing(kPeriod, [] {});
    pause(kSeconds);
    report("an empty tick", nothing.timing());
  }
  measure("flat-wall");
  if (test::longRun()) measure("drill");
}

}  // namespace enamel::viewer::test_viewer
