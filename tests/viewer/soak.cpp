// A window under Xvfb, driven by a random script whose time advances with the pictures: no crash, no OpenGL error,
// constant memory.
#include <algorithm>
#include <map>
#include <sstream>

#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

namespace enamel::test_soak {

namespace {

constexpr double kFrom = 0.40, kTo = 0.50, kLast = 0.90;  // fractions of the run between which memory is compared

// Mesa's llvmpipe draws in threads. It keeps a slot for every picture that was in progress at the same time, up to 64.
// Each slot keeps buffers of its last size. Its memory therefore varies by tens of MB with the load of the machine.
// With one thread it has one slot, and growth comes from us or VTK.
const std::string kOneThread = "env LP_NUM_THREADS=0 ";

std::string randomScript(std::uint64_t seed, double seconds) {
  test::Random random(seed);
  const char* const actions[] = {"split",
                                 "follow",
                                 "cancel",
                                 "swap",
                                 "push",
                                 "grip",
                                 "home",
                                 "reset",
                                 "next-scene",
                                 "pause",
                                 "step",
                                 "faster",
                                 "slower",
                                 "camera-device",
                                 "camera-side",
                                 "camera-top",
                                 "camera-field",
                                 "next-camera",
                                 "previous-camera",
                                 "help",
                                 "panels",
                                 "timing",
                                 "charts",
                                 "full-screen"};
  struct Setting {
    const char* name;
    int low, high;
  };
  const Setting settings[] = {{"stiffness", 0, 20000}, {"wall-damping", 0, 20}, {"release", 0, 1},
                              {"tool-damping", 0, 20}, {"tremor", 0, 2},        {"delay", 0, 3},
                              {"encoders", 0, 1},      {"rates", 0, 2}};
  std::ostringstream script;
  std::map<std::string, bool> switches;  // switches that differ from the start
  const std::string scene = ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml";
  double time = 0.0;
  const auto pick = [&random](double count) { return static_cast<int>(random.uniform(0.0, count)); };
  // At the middle and at the end the window has the same size, so that memory can be compared.
  const auto measured = [seconds](double t) {
    return (t > kFrom * seconds && t < kTo * seconds) || t > kLast * seconds;
  };
  while (time < seconds) {
    const double before = time;
    time += random.uniform(0.02, 0.3);
    script << time << ' ';
    const double draw = random.uniform(0.0, 1.0);
    if (measured(time) && !measured(before)) {
      // The same state both times: all switches reset, one scene, one wall, one size.
      for (const auto& [name, on] : switches)
        if (on) script << name << '\n' << time << ' ';
      switches.clear();
      script << "slow 1\n" << time << " renderer impedance\n" << time << " scene " << scene << '\n';
      script << time << " camera-device\n" << time << " size 1280x720\n";
      // In the wall, long enough to be drawn. The transparent tool has its own buffers of the last drawn size (15 MB
      // here), and none before it is first drawn.
      script << time << " hand 0 0 -30 over 0.2";
      time += 1.0;
    } else if (draw < 0.45 || measured(time)) {
      const Vec3 hand = random.vector(30.0);
      script << "hand " << hand.x() << ' ' << hand.y() << ' ' << hand.z() << " over " << random.uniform(0.0, 0.5);
    } else if (draw < 0.52) {
      script << "size " << 480 + pick(800.0) << 'x' << 320 + pick(400.0);
    } else if (draw < 0.60) {
      const Setting& setting = settings[pick(8.0)];
      script << "set " << setting.name << ' ' << setting.low + pick(setting.high - setting.low + 1.0);
    } else if (draw < 0.64) {
      script << "slow " << (pick(3.0) == 0 ? 100 : 1);
    } else {
      const std::string action = actions[pick(24.0)];
      script << action;
      if (action == "step")
        switches["pause"] = true;
      else if (action == "pause" || action == "split" || action == "help" || action == "panels" || action == "timing" ||
               action == "charts" || action == "full-screen")
        switches[action] = !switches[action];
    }
    script << '\n';
  }
  // End without pause or slow motion, so that the run visibly continues.
  script << time << " slow 1\n" << time << " home\n" << time + 1.0 << " end\n";
  return script.str();
}

}  // namespace

TEST_CASE("soak", "[viewer]") {
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  const double seconds = test::count(16, 1800);
  const std::uint64_t seed = 701;
  INFO("seed " << seed);
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", randomScript(seed, seconds));
  const auto result =
      test::viewer("--script '" + folder / "script.txt' --report '" + folder / "report.json'" + test::kByPictures,
                   kOneThread + test::kXvfb);
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(result.output.empty());
  const auto report = nlohmann::json::parse(test::readFile(folder / "report.json"));
  CHECK(report.at("opengl_errors") == 0);
  CHECK(report.at("size") == nlohmann::json{1280, 720});            // as measured in the middle
  CHECK(report.at("frames").get<double>() >= 12.0 * seconds);       // until the script's end
  CHECK(report.at("haptics").at("periods") > report.at("frames"));  // the haptic loop does not wait for pictures
  // Constant memory: in the same state, the medians at the end are those in the middle. In nine measurements, some
  // beside a compiler, the heap stayed within 1.1 MB for the same buffers. The freed memory that the C library keeps
  // varied by 54 MB with a constant heap.
  const auto levels = [&report, seconds](const char* key) {
    const auto memory = report.at(key).get<std::vector<double>>();
    REQUIRE(static_cast<double>(memory.size()) > 0.9 * seconds);
    const auto median = [&memory](double from, double to) {
      const auto at = [&](double share) {
        return memory.begin() + std::llround(share * static_cast<double>(memory.size()));
      };
      // Without the first sample, which still has the memory of the state before: a short run has only one or two
      // samples here.
      std::vector<double> part(std::min(at(from) + 1, at(to) - 1), at(to));
      std::sort(part.begin(), part.end());
      return part.at(part.size() / 2);
    };
    return std::make_pair(median(kFrom, kTo) / 1024.0, median(kLast, 1.0) / 1024.0);
  };
  const auto heap = levels("heap_in_use_kB"), resident = levels("resident_kB");
  WARN("heap in use " << heap.first << " MB, then " << heap.second << " MB; resident " << resident.first << " MB, then "
                      << resident.second << " MB; " << report.at("frames_per_second").get<double>()
                      << " frames/s; haptics " << report.at("haptics").dump());
  CHECK(heap.second < heap.first + 14.0);
  CHECK(resident.second < resident.first + 64.0);
}

}  // namespace enamel::test_soak
