// A window under Xvfb, driven by a random script: no crash, no OpenGL error, memory flat.
#include <algorithm>
#include <sstream>

#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

using namespace enamel;

namespace {

std::string randomScript(std::uint64_t seed, double seconds) {
  test::Random random(seed);
  const char* const actions[] = {
      "swap",   "push",   "grip",        "home",        "reset",      "next-scene",   "pause",       "step",
      "faster", "slower", "camera-user", "camera-side", "camera-top", "camera-close", "next-camera", "previous-camera",
      "help",   "panels", "timing",      "charts",      "full-screen"};
  std::ostringstream script;
  double time = 0.0;
  const auto pick = [&random](double count) { return static_cast<int>(random.uniform(0.0, count)); };
  while (time < seconds) {
    script << time << ' ';
    const double draw = random.uniform(0.0, 1.0);
    if (draw < 0.45) {
      const Vec3 hand = random.vector(30.0);
      script << "hand " << hand.x() << ' ' << hand.y() << ' ' << hand.z() << " over " << random.uniform(0.0, 0.5);
    } else if (draw < 0.52) {
      script << "size " << 480 + pick(800.0) << 'x' << 320 + pick(400.0);
    } else if (draw < 0.56) {
      script << "slow " << (pick(3.0) == 0 ? 100 : 1);
    } else {
      script << actions[pick(21.0)];
    }
    script << '\n';
    time += random.uniform(0.02, 0.3);
  }
  // Leave no pause or slow motion behind, so that the run can be seen to go on.
  script << time << " slow 1\n" << time << " home\n" << time + 1.0 << " end\n";
  return script.str();
}

}  // namespace

TEST_CASE("soak", "[viewer]") {
  if (!test::haveXvfb()) {
    WARN("xvfb-run or xauth is missing: the soak is not run");
    return;
  }
  const double seconds = test::count(120, 1800);
  const std::uint64_t seed = 701;
  INFO("seed " << seed);
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", randomScript(seed, seconds));
  const auto result = test::viewer("--script '" + folder / "script.txt' --report '" + folder / "report.json'",
                                   test::kXvfb, static_cast<int>(seconds) + 120);
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(result.output.empty());
  const auto report = nlohmann::json::parse(test::readFile(folder / "report.json"));
  CHECK(report.at("opengl_errors") == 0);
  CHECK(report.at("frames").get<double>() > 2.0 * seconds);
  CHECK(report.at("haptics").at("periods").get<double>() > 500.0 * seconds);
  // Flat: after a quarter of the run (shaders, fonts, every scene and size seen) the level no longer rises. Medians of
  // the second and the last quarter; 8 MB is less than a picture of the largest window in each of the frame's buffers.
  std::vector<double> memory = report.at("resident_kB").get<std::vector<double>>();
  REQUIRE(memory.size() > 40);
  const auto median = [&memory](std::size_t from, std::size_t to) {
    std::vector<double> part(memory.begin() + static_cast<std::ptrdiff_t>(from),
                             memory.begin() + static_cast<std::ptrdiff_t>(to));
    std::sort(part.begin(), part.end());
    return part[part.size() / 2];
  };
  const std::size_t quarter = memory.size() / 4;
  const double early = median(quarter, 2 * quarter), late = median(3 * quarter, memory.size());
  WARN("resident " << early / 1024 << " MB, then " << late / 1024 << " MB; "
                   << report.at("frames_per_second").get<double>() << " frames/s; haptics "
                   << report.at("haptics").dump());
  CHECK(late < early + 8192.0);
}
