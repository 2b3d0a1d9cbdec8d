// The sound of a bur: the tone of its rotation, the noise of cutting, and no clicks.
#include "bur_sound.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "support/catch.hpp"

namespace enamel::viewer::test_bur_sound {

namespace {

constexpr BurLoad kRest, kFree{2000.0, 0.0, 0.0}, kEnamel{2000.0, 2e-9, 3.4e9}, kDentine{2000.0, 1e-8, 0.6e9};

std::vector<double> play(BurSound& sound, const BurLoad& load, int count) {
  std::vector<std::int16_t> samples(static_cast<std::size_t>(count));
  sound.next(load, samples.data(), count);
  return {samples.begin(), samples.end()};
}

// Return one second, after one second for the speed to settle.
std::vector<double> settled(const BurLoad& load) {
  BurSound sound;
  play(sound, load, BurSound::kRate);
  return play(sound, load, BurSound::kRate);
}

double rms(const std::vector<double>& samples) {
  double sum = 0.0;
  for (const double s : samples) sum += s * s;
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

double largestStep(const std::vector<double>& samples) {
  double largest = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) largest = std::max(largest, std::abs(samples[i] - samples[i - 1]));
  return largest;
}

// Return the loudest integer frequency from `low` to `high`, Hz, in one second of samples.
int loudest(const std::vector<double>& samples, int low, int high) {
  int best = low;
  double most = -1.0;
  for (int frequency = low; frequency <= high; ++frequency) {  // Goertzel's recursion
    const double c = 2.0 * std::cos(2.0 * M_PI * frequency / BurSound::kRate);
    double a = 0.0, b = 0.0;
    for (const double s : samples) {
      const double next = s + c * a - b;
      b = a;
      a = next;
    }
    const double power = a * a + b * b - c * a * b;
    if (power > most) most = power, best = frequency;
  }
  return best;
}

}  // namespace

TEST_CASE("the tone is the bur's rotation", "[sound]") {
  for (const double turns : {2000.0, 1600.0})
    for (BurLoad load : {kFree, kEnamel, kDentine}) {
      CAPTURE(turns, load.removal);
      load.turns = turns;
      CHECK(loudest(settled(load), 1500, 2100) == Approx(turns).margin(1.0));
    }
}

TEST_CASE("chatter is heard at its pitch, louder the faster the head moves", "[sound]") {
  double before = rms(settled(kEnamel));
  for (const double speed : {5e-4, 2e-3, 2e-2}) {
    BurLoad load = kEnamel;
    load.chatter = speed;
    load.pitch = 920.0;
    const auto samples = settled(load);
    CHECK(rms(samples) > 1.01 * before);
    before = rms(samples);
    CHECK(loudest(samples, 700, 1500) == Approx(load.pitch).margin(1.0));
  }
}

TEST_CASE("more noise where more is cut, brighter where it is harder, none where nothing is", "[sound]") {
  double before = rms(settled(kFree));
  for (const double removal : {3e-10, 1e-9, 3e-9, 1e-8, 3e-8}) {
    CAPTURE(removal);
    const double now = rms(settled({2000.0, removal, 0.6e9}));
    CHECK(now > 1.01 * before);
    before = now;
  }
  CHECK(before < 0.3 * 32767.0);
  const auto brightness = [](double hardness) {
    const auto samples = settled({2000.0, 2.0 / hardness, hardness});  // the same power
    return largestStep(samples) / rms(samples);
  };
  CHECK(brightness(3.4e9) > brightness(0.1e9));

  BurSound sound;
  CHECK(rms(play(sound, kRest, 1000)) == 0.0);
  CHECK(rms(play(sound, kEnamel, BurSound::kRate)) > 500.0);
  play(sound, kRest, BurSound::kRate);
  CHECK(rms(play(sound, kRest, 1000)) == 0.0);
}

TEST_CASE("blocks of sound join without a jump, whatever happens between them", "[sound]") {
  BurSound sound;
  std::vector<double> all;
  double across = 0.0, within = 0.0;
  const BurLoad loads[] = {kFree, kDentine, kRest, kEnamel, kEnamel, kRest, kRest, kFree, kDentine, kEnamel};
  for (int block = 0; block < 400; ++block) {
    const auto next = play(sound, loads[block * 7 % 10], 512);
    if (!all.empty()) across = std::max(across, std::abs(next.front() - all.back()));
    within = std::max(within, largestStep(next));
    all.insert(all.end(), next.begin(), next.end());
  }
  CHECK(within > 1000.0);
  CHECK(across <= within);

  BurSound whole, parts;
  const auto expected = play(whole, kDentine, 3000);
  std::vector<double> joined;
  for (const int length : {1, 511, 1000, 1488}) {
    const auto part = play(parts, kDentine, length);
    joined.insert(joined.end(), part.begin(), part.end());
  }
  CHECK(joined == expected);
}

}  // namespace enamel::viewer::test_bur_sound
