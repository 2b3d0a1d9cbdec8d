// A connected device in the viewer: it moves the tool, and the parts of a simulation are refused.
#include <csignal>
#include <filesystem>

#include "viewer/running_viewer.hpp"
#ifdef ENAMEL_HAPLY_SERVICE
#include "support/devices.hpp"
#include "support/haply_service.hpp"
#endif

namespace enamel::test_device {

namespace {

const std::string kNoDisplay = "-u DISPLAY -u WAYLAND_DISPLAY";

// Replay the only recording of a folder. Return 0 if all ticks are equal, bit for bit.
int replayStatus(const test::TemporaryFolder& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(std::string(folder / "")))
    if (entry.path().extension() == ".rec") return test::run("replay '" + entry.path().string() + "'").status;
  return -1;
}

}  // namespace

TEST_CASE("a connected device moves the tool of the viewer", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0 record\n0 push\n0 pause\n0 hand 0 0 5\n0 set delay 2\n3600 end\n");
  // The hand of the simulated device presses towards the wall from the start of the scene.
  test::RunningViewer viewer(folder,
                             test::shippedScene("flat-wall.toml") + " --headless --script '" + folder / "script.txt" +
                                 "' --device virtual:" ENAMEL_SOURCE_DIR
                                 "/data/devices/touch.toml --renderer impedance",
                             kNoDisplay);
  const nlohmann::json report =
      viewer.until("contact", [](const nlohmann::json& now) { return now.at("contact").get<bool>(); });
  CHECK(report.at("shown").at("renderers") == nlohmann::json{"impedance"});
  CHECK(report.at("shown").at("delay [ticks]") == 0);
  CHECK(report.at("paused") == false);
  CHECK(test::RunningViewer::isAmong(report.at("shown").at("notices"), "Not available while a device is connected."));
  CHECK(report.at("opengl_errors") == 0);
  viewer.signal(SIGTERM);
  CHECK(viewer.wait() == 128 + SIGTERM);
  CHECK(replayStatus(folder) == 0);
}

TEST_CASE("a bur cuts on a connected device, and its recording replays", "[viewer]") {
  const test::TemporaryFolder folder;
  std::string script = "0 record\n";
  for (int second = 2; second < 300; second += 3)  // again, if the guard stopped a loop that was late on a busy machine
    script += std::to_string(second) + " reset\n" + std::to_string(second) + ".2 spin on\n";
  test::writeFile(folder / "script.txt", script + "3600 end\n");
  test::RunningViewer viewer(
      folder,
      test::shippedScene("drill.toml") + " --headless --script '" + folder / "script.txt" + "' --device virtual:",
      kNoDisplay);
  (void)viewer.until("a cut of 0.1 mm^3",
                     [](const nlohmann::json& now) { return now.at("removed [m^3]").get<double>() > 1e-10; });
  viewer.signal(SIGTERM);
  CHECK(viewer.wait() == 128 + SIGTERM);
  CHECK(replayStatus(folder) == 0);
}

#ifdef ENAMEL_HAPLY_SERVICE
TEST_CASE("the viewer shows that a device is unplugged in contact, and continues with it", "[viewer]") {
  test::HaplyService service(test::deviceFile("inverse3.toml"), 0.008, -0.003);
  const test::TemporaryFolder folder;
  std::string script;
  for (int second = 2; second < 600; second += 2) script += std::to_string(second) + " reset\n";  // as a person
  test::writeFile(folder / "script.txt", script + "3600 end\n");
  test::RunningViewer viewer(folder,
                             test::shippedScene("flat-wall.toml") + " --headless --script '" + folder / "script.txt" +
                                 "' --device 'haply://" + service.address() + "'",
                             kNoDisplay);
  const auto has = [&viewer](const char* what, const nlohmann::json& value) {
    (void)viewer.until(what, [&](const nlohmann::json& now) { return now.at("device").at(what) == value; });
  };
  const auto touches = [&viewer] {
    (void)viewer.until("contact", [](const nlohmann::json& now) { return now.at("contact").get<bool>(); });
  };
  touches();
  has("buttons", 2);
  service.isUnplugged = true;
  has("lost", true);
  CHECK(service.newestForce().isZero());
  service.isUnplugged = false;
  has("lost", false);
  service.hasNoPower = true;
  has("forces cut", true);
  has("enabled", false);
  service.hasNoPower = false;
  service.isUncalibrated = true;
  has("calibrated", false);
  service.isUncalibrated = false;
  service.isClosing = true;
  REQUIRE(test::eventually([&] { return !service.isClosing; }));  // it has closed the connection
  touches();                                                      // the viewer has connected again
  viewer.signal(SIGTERM);
  CHECK(viewer.wait() == 128 + SIGTERM);
}
#endif

TEST_CASE("connections that the viewer refuses", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0 end\n");
  const auto refuses = [&](const std::string& arguments, const std::string& message) {
    const test::CommandResult result =
        test::viewer("--headless --script '" + folder / "script.txt' " + arguments, "env " + kNoDisplay);
    INFO(result.output);
    CHECK(result.status == 1);
    CHECK(result.output.find(message) != std::string::npos);
  };
  refuses("--device nothing://1", "device URL \"nothing://1\"");
  refuses("--device virtual: --gain servo.json", "--gain is for simulated devices");
  refuses("--max-force 1", "--max-force is for connected devices");
  refuses("--device virtual: --max-force -1", "largest force");
}

}  // namespace enamel::test_device
