// How the viewer's haptic loop keeps time with nothing drawn beside it, and beside a window under Xvfb. Reported, never
// judged.
#include <chrono>
#include <cstdio>
#include <thread>

#include "runner.hpp"
#include "servo_gain.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

namespace enamel::viewer::test_viewer {

namespace {

const double kSeconds = test::count(4, 10);

void report(const char* beside, bool realtime, double periods, double missed, const double (&us)[5]) {
  std::printf(
      "%-28s %s: missed %.0f of %.0f; wake-up p50 %.0f us, p99.9 %.0f us; compute p50 %.1f us, p99.9 %.1f us, "
      "max %.0f us\n",
      beside, realtime ? "real-time class" : "normal class", missed, periods, us[0], us[1], us[2], us[3], us[4]);
}

}  // namespace

TEST_CASE("missed ticks without and with rendering", "[timing]") {
  {
    const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
    const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml");
    Pose start;
    start.position = scene.start;
    Hand hand;
    hand.position = scene.start;
    hand.target = {0.0, 0.0, -0.02};
    Runner runner(std::make_unique<Experiment>(device, Settings{}, scene, start, hand, RendererSlot::positionControl));
    const PeriodicThread haptics(kPeriod, [&runner] { runner.period(); });
    for (int i = 0; i < 60 * static_cast<int>(kSeconds); ++i) {
      std::this_thread::sleep_for(std::chrono::duration<double>(1.0 / 60.0));
      for (Sample sample; runner.nextSample(sample);) continue;
    }
    const PeriodicTiming& t = haptics.timing();
    report("nothing drawn", t.realtime, static_cast<double>(t.periods), static_cast<double>(t.missed),
           {1e6 * t.wakeUp.quantile(0.5), 1e6 * t.wakeUp.quantile(0.999), 1e6 * t.compute.quantile(0.5),
            1e6 * t.compute.quantile(0.999), 1e6 * t.compute.largest()});
    CHECK(static_cast<double>(t.periods + t.missed) > 0.99 * kSeconds / kPeriod);  // every period is one or the other
    CHECK(runner.frame().record.mode == RenderMode::contact);
  }
  if (!test::haveXvfb()) return test::skipTest("xvfb-run or xauth is missing");
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0 hand 0 0 -20\n" + std::to_string(kSeconds) + " end\n");
  const auto result =
      test::viewer("--script '" + folder / "script.txt' --report '" + folder / "report.json'", test::kXvfb);
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto json = nlohmann::json::parse(test::readFile(folder / "report.json"));
  const auto& h = json.at("haptics");
  report("beside a window, 1280x720", h.at("realtime_class"), h.at("periods"), h.at("missed"),
         {h.at("wake_up_us").at("p50"), h.at("wake_up_us").at("p99.9"), h.at("compute_us").at("p50"),
          h.at("compute_us").at("p99.9"), h.at("compute_us").at("max")});
  std::printf("window: first frame after %.2f s, %.0f frames/s\n", json.at("first_frame_s").get<double>(),
              json.at("frames_per_second").get<double>());
  CHECK(h.at("periods").get<double>() + h.at("missed").get<double>() > 0.99 * kSeconds / kPeriod);
}

}  // namespace enamel::viewer::test_viewer
