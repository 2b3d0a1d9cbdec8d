// The first trial of a device: a good stand-in passes, and each single mistake of a driver is named.
#include "enamel/session/first_touch.hpp"

#include <deque>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_first_touch {

using test::ContainsSubstring;

namespace {

enum class Mistake { none, sign, unit, axis, forceSign, forceUnit, forceAxis, delay, clock, lost };

// A driver with one mistake around a virtual device in simulated time.
class Driver final : public HapticDevice {
 public:
  Driver(std::unique_ptr<HapticDevice> device, Mistake mistake) : device_(std::move(device)), mistake_(mistake) {}
  Status measure(Measurement& m) noexcept override {
    const Status status = device_->measure(m);
    if (mistake_ == Mistake::sign) m.q[0] = -m.q[0], m.rates[0] = -m.rates[0];
    if (mistake_ == Mistake::unit) m.q *= 0.1, m.rates *= 0.1;
    if (mistake_ == Mistake::axis) std::swap(m.q[0], m.q[1]), std::swap(m.rates[0], m.rates[1]);
    if (mistake_ == Mistake::clock) m.time *= 2.0;
    return mistake_ == Mistake::lost && ++calls_ % 4 == 3 ? Status::stale : status;
  }
  Status actuate(const Command& command) noexcept override {
    Command sent = command;
    if (mistake_ == Mistake::forceSign) sent.effort[2] = -sent.effort[2];
    if (mistake_ == Mistake::forceUnit) sent.effort *= 0.1;
    if (mistake_ == Mistake::forceAxis) std::swap(sent.effort[0], sent.effort[2]);
    if (mistake_ == Mistake::delay) {
      late_.push_back(sent);
      if (late_.size() < 6) return device_->actuate({JointVector::Zero(3)});
      sent = late_.front();
      late_.pop_front();
    }
    return device_->actuate(sent);
  }

 private:
  std::unique_ptr<HapticDevice> device_;
  Mistake mistake_;
  int calls_ = 0;
  std::deque<Command> late_;
};

// A person who does as told: moves, holds loosely, and pushes.
FirstTouchResult tryOut(Mistake mistake, const std::string& recording = "", int confirmations = 1000) {
  Vec3 target = Vec3::Zero();
  double grip = 300.0;  // N/m
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  VirtualDeviceSetup setup;
  setup.encoders = {true, RateSource::lowPass, 100.0};
  OpenedDevice opened;
  opened.file = test::deviceFile("cartesian-3.toml");
  opened.text = readFile(opened.file);
  opened.mechanism = mechanism;
  auto device = std::make_unique<SimulatedDevice>(
      *mechanism, setup, [&target, &grip](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = Vec6::Zero();
        wrench.head<3>() = grip * (target - pose.position) - 4.0 * twist.head<3>();
        return wrench;
      });
  opened.device = std::make_unique<Driver>(std::move(device), mistake);
  FirstTouchOptions options;
  options.isSimulated = true;
  options.moveTime = 1.0;
  options.recording = recording;
  return firstTouch(opened, options, [&](const std::string& request) {
    const auto has = [&request](const char* word) { return request.find(word) != std::string::npos; };
    grip = has("loosely") ? 30.0 : 300.0;
    if (has("handle to the right")) target += Vec3(0.03, 0.0, 0.0);
    if (has("handle up")) target += Vec3(0.0, 0.03, 0.0);
    if (has("handle towards you")) target += Vec3(0.0, 0.0, 0.02);
    if (has("loosely") || has("Lay")) target.setZero();
    if (has("against")) target = Vec3(0.0, 0.0, -0.003);
    return confirmations-- > 0;
  });
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
  for (const auto& [mistake, words] :
       {std::pair<Mistake, const char*>{
            Mistake::sign, "the position moved along x by -29.98 mm, expected forwards (to the right): wrong sign"},
        {Mistake::unit, "is its unit m?"},
        {Mistake::axis, "the position moved along y"},
        {Mistake::forceSign, "the handle moved along z"},
        {Mistake::forceUnit, "unit of the forces"},
        {Mistake::forceAxis, "the handle moved along z"},
        {Mistake::delay, "the delay is"},
        {Mistake::clock, "is their unit s?"},
        {Mistake::lost, "of the samples are missing"}}) {
    const FirstTouchResult result = tryOut(mistake);
    INFO(result.report);
    CHECK_THAT(result.surprise, ContainsSubstring(words));
    CHECK_FALSE(result.isComplete);
    CHECK_THAT(result.report, ContainsSubstring("SURPRISE: " + result.surprise));
  }
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
