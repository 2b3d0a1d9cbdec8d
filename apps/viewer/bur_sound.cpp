#include "bur_sound.hpp"

#include <algorithm>
#include <cmath>

namespace enamel::viewer {
namespace {

constexpr double kRotor = 0.08, kGrain = 0.02;                             // s, time constants of speed and noise
constexpr double kFullTurns = 1000.0;                                      // per second; full volume from this speed on
constexpr double kHalfRemoval = 1e-8;                                      // m^3/s
constexpr double kHalfChatter = 1e-3;                                      // m/s
constexpr double kTone = 0.12, kNoise = 0.12, kChatter = 0.12;             // relative to full scale
constexpr double kDullest = 100.0, kBrightest = 8e3, kBrightness = 2.5e3;  // Hz; kBrightness: for 1 GPa
struct Partial {
  double multiple, strength;
};
constexpr Partial kPartials[] = {{1, 0.5}, {2, 0.3}, {3, 0.1}, {8, 0.15}, {16, 0.05}};  // of 8 blades

}  // namespace

void BurSound::next(const BurLoad& load, std::int16_t* samples, int count) noexcept {
  constexpr double step = 1.0 / kRate, pi = 3.14159265358979323846;
  const double rotor = step / kRotor, grain = step / kGrain;
  const double corner = std::clamp(kBrightness * std::sqrt(1e-9 * load.hardness), kDullest, kBrightest);
  const double brightness = 1.0 - std::exp(-2.0 * pi * corner * step);
  for (int i = 0; i < count; ++i) {
    turns_ += rotor * (load.turns - turns_);
    removal_ += grain * (std::max(0.0, load.removal) - removal_);
    brightness_ += grain * (brightness - brightness_);
    phase_ = std::fmod(phase_ + 2.0 * pi * turns_ * step, 2.0 * pi);
    double tone = 0.0;
    for (const Partial& partial : kPartials) {  // fade out partials near the Nyquist frequency, which would alias
      const double heard = std::clamp(20.0 * (0.45 - partial.multiple * turns_ * step), 0.0, 1.0);
      tone += heard * partial.strength * std::sin(partial.multiple * phase_);
    }
    chatter_ += grain * (load.chatter - chatter_);
    wave_ = std::fmod(wave_ + 2.0 * pi * load.pitch * step, 2.0 * pi);
    const double whine = chatter_ / (chatter_ + kHalfChatter) * std::sin(wave_);
    random_ ^= random_ << 13;  // Marsaglia, "Xorshift RNGs", 2003
    random_ ^= random_ >> 17;
    random_ ^= random_ << 5;
    const double white = 2.0 * random_ / 4294967296.0 - 1.0;
    noise_ += brightness_ * (white - noise_);
    const double level = std::sqrt(removal_ / (removal_ + kHalfRemoval) * 3.0 * (2.0 - brightness_) / brightness_);
    const double rough = level * noise_ * (1.0 + 0.5 * std::sin(phase_));
    const double sum = std::min(1.0, turns_ / kFullTurns) * (kTone * tone + kNoise * rough) + kChatter * whine;
    samples[i] = static_cast<std::int16_t>(std::lround(32767.0 * std::clamp(sum, -1.0, 1.0)));
  }
}

}  // namespace enamel::viewer
