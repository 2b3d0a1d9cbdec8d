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
using test::TrialHand;

namespace {

const std::string kStylus = "cartesian-3.toml", kSixAxes = "cartesian-6.toml";

// Try a simulated device with a delay, ticks.
FirstTouchResult tryOut(const Mistake& mistake, const std::string& file = kStylus, const std::string& recording = "",
                        int confirmations = 1000, int delay = 0) {
  const auto hand = std::make_shared<TrialHand>();
  OpenedDevice opened;
  opened.file = test::deviceFile(file);
  opened.text = readFile(opened.file);
  opened.mechanism = makeMechanism(loadDevice(opened.file));
  VirtualDeviceSetup setup;
  setup.encoders = {true, RateSource::lowPass, 100.0};
  setup.delay = {delay, delay};
  opened.delay = {0, delay};
  opened.device =
      std::make_unique<SimulatedDevice>(*opened.mechanism, setup, [hand](double, const Pose& pose, const Vec6& twist) {
        const double angle = hand->turn.norm();
        const Mat3 target =
            Eigen::AngleAxisd(angle, angle > 0.0 ? Vec3(hand->turn / angle) : Vec3(Vec3::UnitX())).toRotationMatrix();
        const Eigen::AngleAxisd left(Mat3(target * pose.rotation.transpose()));
        Vec6 wrench;
        wrench << hand->stiffness * (hand->place - pose.position) - 4.0 * twist.head<3>(),
            0.2 * left.angle() * left.axis() - 0.02 * twist.tail<3>();
        return wrench;
      });
  const auto hold = [hand](const TrialHand& held) { *hand = held; };
  return test::tryOut(std::move(opened), mistake, hold, recording, confirmations);
}

}  // namespace

TEST_CASE("a good driver passes the first trial, and the recording is kept", "[first_touch]") {
  const test::TemporaryFolder folder;
  const FirstTouchResult result = tryOut({}, kStylus, folder / "first.rec");
  INFO(result.report);
  CHECK(result.surprise.empty());
  CHECK(result.isComplete);
  CHECK(std::filesystem::file_size(folder / "first.rec") > 1000);
  for (const char* step :
       {"rest: 0.0 % of the samples lost", "buttons pressed: none", "moved to the right: 30.", "push of 0.1 N up",
        "push of 2.0 N towards you", "apparent mass 0.04", "a soft wall of 300 N/m: ", "a hard wall: "})
    CHECK_THAT(result.report, ContainsSubstring(step));
  CHECK_THAT(result.report, !ContainsSubstring("wall: 0 ticks in contact"));
}

TEST_CASE("the first trial turns a device with six axes, and pushes it with moments", "[first_touch]") {
  const FirstTouchResult result = tryOut({}, kSixAxes);
  INFO(result.report);
  CHECK(result.surprise.empty());
  CHECK(result.isComplete);
  for (const char* step : {"turned so that its front end goes up: 2", "push of 0.05 N m so that its right side goes up",
                           "apparent inertia"})
    CHECK_THAT(result.report, ContainsSubstring(step));
}

TEST_CASE("each single mistake of a driver stops the first trial, and is named", "[first_touch]") {
  for (const std::string& file : {kStylus, kSixAxes})
    test::forEachMistake(file == kSixAxes, file == kSixAxes, false, [&](const Mistake& mistake) {
      const FirstTouchResult result = tryOut(mistake, file);
      INFO(file << ", " << mistake.what << ", expected: " << mistake.words << "\n" << result.report);
      CHECK(test::names(result.surprise, mistake.words));
      CHECK_FALSE(result.isComplete);
      CHECK_THAT(result.report, ContainsSubstring("SURPRISE: " + result.surprise));
    });
}

TEST_CASE("the first trial measures the delay, and position control uses it", "[first_touch]") {
  for (const int delay : {0, 1, 2, 3}) {
    const FirstTouchResult result = tryOut({}, kStylus, "", 1000, delay);
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
  CHECK_THAT(test::tryOut(std::move(opened), {}, [](const TrialHand&) {}).surprise,
             ContainsSubstring("the position changed by only 0 m: did you move the handle"));
}

TEST_CASE("the person ends the first trial at any step", "[first_touch]") {
  for (const int confirmations : {0, 2, 5, 14}) {
    const FirstTouchResult result = tryOut({}, kStylus, "", confirmations);
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
