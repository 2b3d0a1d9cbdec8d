// The sound of a bur: its rotation, and the noise of cutting.
#pragma once

#include <cstdint>

namespace enamel::viewer {

/// State of a bur that determines its sound.
struct BurLoad {
  double turns = 0.0;     ///< per second; 0: at rest
  double removal = 0.0;   ///< rate of removed volume, m^3/s
  double hardness = 0.0;  ///< of the removed material, Pa
  double chatter = 0.0;   ///< largest speed of the head while it chatters, m/s
  double pitch = 0.0;     ///< of the chatter, Hz
};

/// Generates samples of mono sound: harmonics of the rotation and of the blades, chatter, and noise. The noise is
/// louder for larger removal and brighter for harder material. Both follow a change of load within some tens of ms, so
/// that blocks join without a jump. A bur at rest becomes silent.
class BurSound {
 public:
  static constexpr int kRate = 44100;  // samples per second

  /// Compute the next `count` samples.
  void next(const BurLoad& load, std::int16_t* samples, int count) noexcept;

 private:
  double turns_ = 0.0, removal_ = 0.0, brightness_ = 1.0;  // brightness: weight of a new sample in the noise
  double phase_ = 0.0, wave_ = 0.0;                        // of rotation and chatter, rad
  double chatter_ = 0.0;                                   // m/s
  double noise_ = 0.0;
  std::uint32_t random_ = 1;
};

}  // namespace enamel::viewer
