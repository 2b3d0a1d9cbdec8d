// The blind test of enamel identify: devices with hidden numbers over all mechanisms. ENAMEL_BLIND=20 draws 20 of each,
// with 30 s of data; ENAMEL_LONG=1 draws 8. Otherwise one of each is drawn, with 8 s: this shows the errors, but not
// how often the intervals are right.
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
#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_trials.hpp"
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

// Controllers from identified files beside those from the truth.
struct Controllers {
  double first = 1e9, depth = 1e9;  // smallest K_z1 and K_d, of the truth's
  int measured = 0;                 // devices with K_z1
  int lost = 0, lostOfTruth = 0;    // runs
};

struct Tally {
  std::map<std::string, Coverage> kinds;
  int devices = 0, uncertain = 0;
  Controllers controllers;
};

// The file of somebody who knows the device. It has what identified files have.
DeviceParameters truthOf(const test::BlindDevice& device) {
  DeviceParameters truth = device.truth;
  Imperfections e = device.built.imperfections;
  auto* const cartesian = std::get_if<CartesianParameters>(&truth);
  if (cartesian != nullptr) cartesian->halfWidths = std::get<CartesianParameters>(device.file).halfWidths;
  const bool hasFriction = cartesian == nullptr || cartesian->axes == 3;  // else one number for N and N m
  e.coulombFriction = hasFriction ? device.built.coulombFriction.mean() : 0.0;
  e.cogging = hasFriction ? device.built.cogging.mean() : 0.0;
  imperfectionsOf(truth) = e;
  return truth;
}

// Position control for a file, on the device. The driver corrects the encoders' offsets and the torque constants.
StudyColumn columnOf(const test::BlindDevice& device, const DeviceParameters& file, Delay delay,
                     const JointVector& offset, const JointVector& ratio) {
  StudyColumn column;
  column.plant = makeMechanism(device.truth);
  column.model = makeMechanism(file);
  ImperfectDevice built = device.built;
  built.offset -= makeMechanism(device.file)->home().q - column.model->home().q + offset;
  built.torqueConstant.array() /= ratio.array();
  column.makePlant = [built](std::uint32_t) { return std::make_unique<ImperfectPlant>(built); };
  const PositionControlOptions options = positionControlFor(*column.model, 1e-3, delay.low, delay.high);
  column.make = [options](std::size_t) { return std::make_unique<PositionControlRenderer>(options); };
  return column;
}

// Numbers of all joints; `missing` for those that the device does not have.
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
  const auto column = [&](const auto& valueOf, const DeviceParameters& file, Delay delay) {
    return columnOf(device, file, delay, ofJoints(valueOf, "encoder offset", device, 0.0),
                    ofJoints(valueOf, "torque ratio", device, 1.0));
  };
  StudyPlan plan;
  plan.columns = {column(known, truthOf(device), device.delay),
                  column(estimated, result.device, {result.delay.low, result.delay.high})};
  plan.scenarios = {1};
  plan.grid = 1;
  plan.runs = 48;  // the mean of 12 varies by 20 %
  plan.insideTick = true;
  const double share = forceShare(*plan.columns[0].plant);
  plan.lowestForce *= share;
  plan.highestForce *= share;
  plan.setup.hand.preload = share;
  plan.setup.hand.noise *= share;
  plan.setup.delay = device.delay;
  plan.setup.jitter = device.jitter;
  plan.setup.lostSamples = device.lost;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.duration = 1.2;
  std::vector<StudyResult> runs(plan.size());
  parallelFor(runs.size(), availableThreads(), [&](std::size_t i) { runs[i] = performRun(plan, runAt(plan, i)); });
  // Means over the runs in which both have the figure; all runs have K_d.
  Controllers& c = tally.controllers;
  double first[2] = {}, depth[2] = {};
  int lost[2] = {};
  const auto count = static_cast<std::size_t>(plan.runs);
  for (std::size_t i = 0; i < count; ++i) {
    const PushMetrics* const both[] = {&runs[i].metrics, &runs[count + i].metrics};
    for (std::size_t k = 0; k < 2; ++k) {
      lost[k] += isLost(runs[k * count + i]);
      if (both[0]->firstStiffness && both[1]->firstStiffness) first[k] += *both[k]->firstStiffness;
      if (both[0]->depthStiffness && both[1]->depthStiffness) depth[k] += *both[k]->depthStiffness;
    }
  }
  CAPTURE(first[0], first[1], depth[0], depth[1]);
  CHECK(first[1] >= 0.9 * first[0]);
  CHECK(depth[1] >= 0.9 * depth[0]);
  CHECK(lost[1] <= lost[0]);
  if (first[0] > 0.0) {
    ++c.measured;
    c.first = std::min(c.first, first[1] / first[0]);
  }
  c.depth = std::min(c.depth, depth[1] / depth[0]);
  c.lost += lost[1];
  c.lostOfTruth += lost[0];
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
  const Controllers& c = tally.controllers;
  std::printf("%s: %d devices, %d delays not certain\n", mechanism, tally.devices, tally.uncertain);
  std::printf(
      "  controllers: K_z1 at least %.3f of the truth's (%d devices), K_d %.3f, %d runs lost, %d of the truth\n",
      c.first, c.measured, c.depth, c.lost, c.lostOfTruth);
  for (const auto& [kind, n] : tally.kinds)
    std::printf("  %-32s %4d of %4d covered, level %.3f, %4d seen, largest error %.2g %%\n", kind.c_str(), n.covered,
                n.count, levelOf(n), n.seen, 100.0 * n.error);
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
