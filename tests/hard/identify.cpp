// The blind test of enamel identify: devices with hidden numbers over all mechanisms. ENAMEL_BLIND=20 draws 20 of each,
// with 30 s of data. Without it, only one Cartesian device is drawn, because not all bounds hold yet
// (lib/docs/identify.md, "Blind test").
#include "enamel/identify/identify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "enamel/core/error.hpp"
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
};

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
  CHECK(result.explained.minCoeff() > 0.97);
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
  std::printf("%s: %d devices, %d delays not certain\n", mechanism, tally.devices, tally.uncertain);
  for (const auto& [kind, c] : tally.kinds)
    std::printf("  %-32s %4d of %4d covered, level %.3f, %4d seen, largest error %.2g %%\n", kind.c_str(), c.covered,
                c.count, levelOf(c), c.seen, 100.0 * c.error);
}

int devicesOfEach() {
  const char* text = std::getenv("ENAMEL_BLIND");
  return text == nullptr ? 0 : std::atoi(text);
}

// Record a device. The last fifth of the data, which tests the result, is another recording.
std::vector<RecordedMotion> recordingsOf(const test::BlindDevice& device, double duration, std::uint64_t seed) {
  const int joints = device.built.mechanism->joints();
  std::vector<RecordedMotion> motions = motionsOf(test::recordBlind(device, duration, seed + 1), 1e-3, joints);
  std::vector<RecordedTick> second = test::recordBlind(device, std::max(5.0, duration / 4.0), seed + 2);
  second.resize(static_cast<std::size_t>(duration / 4.0 / 1e-3));
  for (RecordedMotion& motion : motionsOf(second, 1e-3, joints)) motions.push_back(std::move(motion));
  return motions;
}

// Identify devices, and compare the results with the hidden numbers.
void identifyBlindly(test::BlindKind kind, const char* mechanism) {
  const int devices = std::max(1, devicesOfEach());
  const double duration = devicesOfEach() > 0 ? 30.0 : 8.0;
  Tally tally;
  for (int i = 0; i < devices; ++i) {
    const std::uint64_t seed = 1000 * test::seed() + static_cast<std::uint64_t>(i);
    INFO(mechanism << ", seed " << seed);
    const test::BlindDevice device = test::makeBlindDevice(kind, seed);
    try {
      const Identification result = identifyDevice(recordingsOf(device, duration, seed), device.file);
      CHECK(result.isUsable());
      if (result.isUsable()) check(device, result, tally);
    } catch (const Error& error) {
      FAIL_CHECK(error.what());
    }
  }
  report(mechanism, tally);
  if (devicesOfEach() == 0) return;  // one device and 8 s show the errors, but not how often the intervals are right
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
  if (devicesOfEach() > 0) identifyBlindly(test::BlindKind::cartesian6, "Cartesian, 6 axes");
}

TEST_CASE("blind deltas", "[identify]") {
  if (devicesOfEach() > 0) identifyBlindly(test::BlindKind::delta, "delta");
}

TEST_CASE("blind TAU devices", "[identify]") {
  if (devicesOfEach() > 0) identifyBlindly(test::BlindKind::tau, "TAU");
}

}  // namespace enamel::test_identify_blind
