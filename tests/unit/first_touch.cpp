// The first trial of a device: a good stand-in passes, and each single mistake of a driver is named.
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/first_touch_trial.hpp"

namespace enamel::test_first_touch {

using test::ContainsSubstring;
using test::Mistake;

namespace {

// Try a simulated stylus with a delay, ticks.
FirstTouchResult tryOut(Mistake mistake, const std::string& recording = "", int confirmations = 1000, int delay = 0) {
  struct Hand {
    Vec3 place = Vec3::Zero();
    double stiffness = 300.0;  // N/m
  };
  const auto hand = std::make_shared<Hand>();
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  VirtualDeviceSetup setup;
  setup.encoders = {true, RateSource::lowPass, 100.0};
  setup.delay = {delay, delay};
  OpenedDevice opened;
  opened.file = test::deviceFile("cartesian-3.toml");
  opened.text = readFile(opened.file);
  opened.mechanism = mechanism;
  opened.delay = {0, delay};
  opened.device =
      std::make_unique<SimulatedDevice>(*mechanism, setup, [hand](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = Vec6::Zero();
        wrench.head<3>() = hand->stiffness * (hand->place - pose.position) - 4.0 * twist.head<3>();
        return wrench;
      });
  const auto hold = [hand](const Vec3& place, double stiffness) { *hand = {place, stiffness}; };
  return test::tryOut(std::move(opened), mistake, hold, recording, confirmations);
}

}  // namespace

TEST_CASE("a good driver passes the first trial, and the recording is kept", "[first_touch]") {
  const test::TemporaryFolder folder;
  const FirstTouchResult result = tryOut(Mistake::none, folder / "first.rec");
  INFO(result.report);
  CHECK(result.surprise.empty());
  CHECK(result.isComplete);
  CHECK(std::filesystem::file_size(folder / "first.rec") > 1000);
  for (const char* step :
       {"rest: 0.0 % of the samples lost", "moved to the right: 30.", "push of 0.1 N up", "push of 2.0 N towards you",
        "apparent mass 0.04", "a soft wall of 300 N/m: ", "a hard wall: "})
    CHECK_THAT(result.report, ContainsSubstring(step));
  CHECK_THAT(result.report, !ContainsSubstring("wall: 0 ticks in contact"));
}

TEST_CASE("each single mistake of a driver stops the first trial, and is named", "[first_touch]") {
  for (const auto& [mistake, words] : test::kMistakes) {
    const FirstTouchResult result = tryOut(mistake);
    INFO(result.report);
    CHECK_THAT(result.surprise, ContainsSubstring(words));
    CHECK_FALSE(result.isComplete);
    CHECK_THAT(result.report, ContainsSubstring("SURPRISE: " + result.surprise));
  }
}

TEST_CASE("the first trial measures the delay, and position control uses it", "[first_touch]") {
  for (const int delay : {0, 1, 2, 3}) {
    const FirstTouchResult result = tryOut(Mistake::none, "", 1000, delay);
    INFO(result.report);
    CHECK(result.isComplete);
    CHECK_THAT(result.report, ContainsSubstring("add the option delay=" + std::to_string(delay) + " to the URL"));
  }
}

TEST_CASE("the first trial asks whether the person moved a handle at rest", "[first_touch]") {
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  OpenedDevice opened;
  opened.mechanism = mechanism;
  opened.device = std::make_unique<SimulatedDevice>(
      *mechanism, VirtualDeviceSetup(), [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); });
  CHECK_THAT(test::tryOut(std::move(opened), Mistake::none, [](const Vec3&, double) {}).surprise,
             ContainsSubstring("the position did not change: did you move the handle"));
}

TEST_CASE("the person ends the first trial at any step", "[first_touch]") {
  for (const int confirmations : {0, 2, 5, 14}) {
    const FirstTouchResult result = tryOut(Mistake::none, "", confirmations);
    CHECK_FALSE(result.isComplete);
    CHECK(result.surprise.empty());
    CHECK_THAT(result.report, ContainsSubstring("ended by the person before: "));
  }
  OpenedDevice none;
  FirstTouchOptions options;
  options.largestForce = 20.0;
  CHECK_THROWS_WITH(firstTouch(none, options, [](const std::string&) { return false; }),
                    ContainsSubstring("the largest force is 20 N, must be in 0.5 to 10 N"));
}

}  // namespace enamel::test_first_touch
