// The blind test of enamel identify: devices with hidden numbers over all mechanisms. ENAMEL_BLIND=20 draws 20 of each,
// with 30 s of data; ENAMEL_LONG=1 draws 8. Otherwise one of each is drawn, with 8 s: this shows the errors, but not how
// often the intervals are right.
#include "enamel/identify/identify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "enamel/core/error.hpp"
#include "enamel/identify/device_text.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_design.hpp"
#include "support/blind_devices.hpp"
#include "support/catch.hpp"
#include "support/run_length.hpp"

namespace enamel::test_identify_blind {

namespace {

// How often the intervals of one kind of number hold the truth.
struct Coverage {
  int count = 0, covered = 0, seen = 0;
  double error = 0.0;  // largest relative error of a seen number
};

// P(X <= k) for n trials with 95 % each.
double atMost(int k, int n) {
  double sum = 0.0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(0.95) +
                    (n - i) * std::log(0.05));
  return sum;
}

// Binomial test of 95 % on both sides. Numbers that are not seen have the interval of the device file, so that only
// too few are wrong.
double levelOf(const Coverage& c) {
  const double few = atMost(c.covered, c.count), many = 1.0 - (c.covered > 0 ? atMost(c.covered - 1, c.count) : 0.0);
  return c.seen < c.count ? few : std::min(1.0, 2.0 * std::min(few, many));
}

// "Coulomb friction of joint 2" and "gravity[1]" belong to a kind each.
std::string kindOf(const std::string& key) { return key.substr(0, std::min(key.find(" of "), key.find('['))); }

// Largest relative error of the apparent mass at home, in 14 directions.
double inertiaError(const DeviceParameters& estimated, const DeviceParameters& truth) {
  const auto ours = makeMechanism(estimated), real = makeMechanism(truth);
  double error = 0.0;
  for (int i = 0; i < 27; ++i) {
    const Vec3 direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (i == 13) continue;
    const Vec3 n = direction.normalized();
    const double a = effectiveMass(ours->home(), ours->home().pose.position, n);
    const double b = effectiveMass(real->home(), real->home().pose.position, n);
    error = std::max(error, std::abs(a / b - 1.0));
  }
  return error;
}

// Resonance of a rotor on its cable with a fast link, Hz.
double resonanceOf(const test::BlindDevice& device) {
  const double k = device.built.imperfections.cableStiffness;
  const double link = device.built.mechanism->home().inertia.diagonal().minCoeff();
  return std::sqrt(k * (1.0 / device.built.rotorInertia + 1.0 / link)) / (2.0 * M_PI);
}

struct Tally {
  std::map<std::string, Coverage> kinds;
  int devices = 0, uncertain = 0;
  double stiffness = 1e9;  // smallest K_z1 of the controller from the identified file, of that from the truth
  int lost = 0, lostOfTruth = 0;
};

// The file of somebody who knows the device. It has what identified files have.
DeviceParameters truthOf(const test::BlindDevice& device) {
  DeviceParameters truth = device.truth;
  Imperfections e = device.built.imperfections;
  const auto* cartesian = std::get_if<CartesianParameters>(&truth);
  const bool hasFriction = cartesian == nullptr || cartesian->axes == 3;  // else one number for N and N m
  e.coulombFriction = hasFriction ? device.built.coulombFriction.mean() : 0.0;
  e.cogging = hasFriction ? device.built.cogging.mean() : 0.0;
  imperfectionsOf(truth) = e;
  return truth;
}

// Score position control for a file on the device. The driver corrects the encoders' offsets and the torque constants.
WallScore scoreOf(const test::BlindDevice& device, const DeviceParameters& file, Delay delay, const JointVector& offset,
                  const JointVector& ratio) {
  WallDesignSetup setup;
  setup.plant = makeMechanism(device.truth);
  setup.delay = device.delay;
  setup.jitter = device.jitter;
  setup.lostSamples = device.lost;
  setup.runs = 6;
  setup = withinMotors(setup);
  setup.plant = makeMechanism(file);
  ImperfectDevice built = device.built;
  built.offset -= makeMechanism(device.file)->home().q - setup.plant->home().q + offset;
  built.torqueConstant.array() /= ratio.array();
  setup.makePlant = [&built](std::uint32_t) { return std::make_unique<ImperfectPlant>(built); };
  const PositionControlOptions options = positionControlFor(*setup.plant, setup.period, delay.low, delay.high);
  return evaluateWall(
      setup, [&options] { return std::make_unique<PositionControlRenderer>(options); }, 1, availableThreads());
}

// Estimates or true numbers of all joints, or `missing` where there are none.
template <typename ValueOf>
JointVector ofJoints(const ValueOf& valueOf, const std::string& key, const test::BlindDevice& device, double missing) {
  JointVector values = JointVector::Constant(device.built.offset.size(), missing);
  const bool isCartesian = std::holds_alternative<CartesianParameters>(device.file);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string joint = !isCartesian ? "joint " + std::to_string(i + 1)
                                           : std::string(i < 3 ? "axis " : "rotation about ") + "xyz"[i % 3];
    values[i] = valueOf(key + " of " + joint, missing);
  }
  return values;
}

// The controller of the identified file beside that of the truth.
void compareControllers(const test::BlindDevice& device, const Identification& result, Tally& tally) {
  const auto known = [&](const std::string& key, double missing) {
    const auto at = device.value.find(key);
    return at != device.value.end() ? at->second : missing;
  };
  const auto estimated = [&](const std::string& key, double missing) {
    for (const Estimate& e : result.estimates)
      if (e.key == key) return e.value;
    return missing;
  };
  const auto score = [&](const auto& valueOf, const DeviceParameters& file, Delay delay) {
    return scoreOf(device, file, delay, ofJoints(valueOf, "encoder offset", device, 0.0),
                   ofJoints(valueOf, "torque ratio", device, 1.0));
  };
  const WallScore best = score(known, truthOf(device), device.delay);
  const WallScore ours = score(estimated, result.device, {result.delay.low, result.delay.high});
  CAPTURE(best.stiffness, ours.stiffness);
  CHECK(ours.stiffness > 0.9 * best.stiffness);
  CHECK(ours.lost <= best.lost);
  tally.stiffness = std::min(tally.stiffness, ours.stiffness / best.stiffness);
  tally.lost += ours.lost;
  tally.lostOfTruth += best.lost;
}

void count(const test::BlindDevice& device, const Identification& result, Tally& tally) {
  for (const Estimate& e : result.estimates) {
    const auto truth = device.value.find(e.key);
    if (truth == device.value.end()) continue;
    Coverage& c = tally.kinds[kindOf(e.key)];
    ++c.count;
    if (truth->second >= e.low && truth->second <= e.high) ++c.covered;
    if (!e.isSeen) continue;
    ++c.seen;
    c.error = std::max(c.error, std::abs(e.value / truth->second - 1.0));
  }
}

void check(const test::BlindDevice& device, const Identification& result, Tally& tally) {
  ++tally.devices;
  if (!result.delay.isCertain) ++tally.uncertain;
  CHECK(result.delay.low == device.delay.low);
  CHECK(result.delay.high == device.delay.high);
  CHECK(inertiaError(result.device, device.truth) < 0.03);
  if (device.delay.low == device.delay.high) CHECK(result.explained.minCoeff() > 0.97);  // else commands act at random
  for (const Estimate& e : result.estimates) {
    INFO(e.key);
    const auto truth = device.value.find(e.key);
    if (kindOf(e.key) == "Coulomb friction") CHECK(e.value == Approx(truth->second).epsilon(0.15));
    if (e.key == "imperfections.cable_stiffness" && resonanceOf(device) < 500.0)
      CHECK(e.value == Approx(truth->second).epsilon(0.1));
  }
  count(device, result, tally);
}

void report(const char* mechanism, const Tally& tally) {
  std::printf("%s: %d devices, %d delays not certain; K_z1 at least %.3f of the truth's, %d runs lost, %d of it\n",
              mechanism, tally.devices, tally.uncertain, tally.stiffness, tally.lost, tally.lostOfTruth);
  for (const auto& [kind, c] : tally.kinds)
    std::printf("  %-32s %4d of %4d covered, level %.3f, %4d seen, largest error %.2g %%\n", kind.c_str(), c.covered,
                c.count, levelOf(c), c.seen, 100.0 * c.error);
}

// 0: one device of each mechanism, with little data.
int devicesOfEach() {
  const char* text = std::getenv("ENAMEL_BLIND");
  return text != nullptr ? std::atoi(text) : test::longRun() ? 8 : 0;
}

// Record a device. The last fifth of the data, which tests the result, is another recording.
std::vector<RecordedMotion> recordingsOf(const test::BlindDevice& device, double duration, std::uint64_t seed) {
  const int joints = device.built.mechanism->joints();
  std::vector<RecordedMotion> motions = motionsOf(test::recordBlind(device, duration, seed + 1), 1e-3, joints);
  std::vector<RecordedTick> second = test::recordBlind(device, std::max(5.0, duration / 4.0), seed + 2);
  second.resize(static_cast<std::size_t>(std::max(3.0, duration / 4.0) / 1e-3));
  for (RecordedMotion& motion : motionsOf(second, 1e-3, joints)) motions.push_back(std::move(motion));
  return motions;
}

// Identify devices, and compare the results with the hidden numbers. A loop that is not ideal has random delays and
// loses 5 % of the samples.
void identifyBlindly(test::BlindKind kind, const char* mechanism, bool isIdeal = true) {
  const int devices = std::max(1, devicesOfEach());
  const double duration = devicesOfEach() > 0 ? 30.0 : 8.0;
  Tally tally;
  for (int i = 0; i < devices; ++i) {
    const std::uint64_t seed = 1000 * test::seed() + static_cast<std::uint64_t>(i);
    INFO(mechanism << ", seed " << seed);
    test::BlindDevice device = test::makeBlindDevice(kind, seed);
    if (!isIdeal) {
      device.delay.high += 1 + i % 3;
      device.lost = 0.05;
    }
    try {
      const Identification result = identifyDevice(recordingsOf(device, duration, seed), device.file);
      INFO(tableOf(result));
      CHECK(result.isUsable());
      if (!result.isUsable()) continue;
      check(device, result, tally);
      if (!isIdeal) CHECK(result.lostSamples == Approx(0.05).margin(0.01));  // 4 deviations of 8000 ticks
      compareControllers(device, result, tally);
    } catch (const Error& error) {
      FAIL_CHECK(error.what());
    }
  }
  report(mechanism, tally);
  if (devicesOfEach() == 0) return;
  for (const auto& [kind_, c] : tally.kinds) {
    INFO(mechanism << ": " << kind_ << ", " << c.covered << " of " << c.count);
    CHECK(levelOf(c) > 0.01);
  }
}

}  // namespace

TEST_CASE("blind Cartesian devices with 3 axes", "[identify]") {
  identifyBlindly(test::BlindKind::cartesian3, "Cartesian, 3 axes");
}

TEST_CASE("blind Cartesian devices with 6 axes", "[identify]") {
  identifyBlindly(test::BlindKind::cartesian6, "Cartesian, 6 axes");
}

TEST_CASE("blind deltas", "[identify]") { identifyBlindly(test::BlindKind::delta, "delta"); }

TEST_CASE("blind TAU devices", "[identify]") { identifyBlindly(test::BlindKind::tau, "TAU"); }

TEST_CASE("blind devices with random delays and lost samples", "[identify]") {
  identifyBlindly(test::BlindKind::cartesian3, "Cartesian, 3 axes, random delays", false);
  if (devicesOfEach() == 0) return;
  identifyBlindly(test::BlindKind::cartesian6, "Cartesian, 6 axes, random delays", false);
  identifyBlindly(test::BlindKind::delta, "delta, random delays", false);
  identifyBlindly(test::BlindKind::tau, "TAU, random delays", false);
}

}  // namespace enamel::test_identify_blind
