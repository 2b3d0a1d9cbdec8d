// The sound of a bur: a turbine that sings, slower under load, and the noise of what it cuts.
#pragma once

#include <cstdint>

namespace enamel::viewer {

/// What one hears of a bur.
struct BurLoad {
  double turns = 0.0;     ///< a second, where nothing is cut; 0: at rest
  double removal = 0.0;   ///< that it cuts, m^3/s
  double hardness = 0.0;  ///< of what it cuts, Pa
};

/// Turns a second under a load, which takes hardness times removal (W). The torque of a turbine falls linearly with its
/// speed (Dyson and Darvell, "Torque, power and efficiency characterization of dental air turbine handpieces", 1999);
/// it gives 20 W at most, at half its free speed. What is simulated does not slow down.
double turnsUnder(const BurLoad& load) noexcept;

/// Samples of mono sound: harmonics of the rotation and of the blades, and noise that is louder where more is cut and
/// brighter where it is harder. They follow a change of load within some tens of ms, so that blocks join without a
/// jump; a bur that has come to rest is silent.
class BurSound {
 public:
  static constexpr int kRate = 44100;  // samples a second

  /// The next `count` samples.
  void next(const BurLoad& load, std::int16_t* samples, int count) noexcept;

 private:
  double turns_ = 0.0, removal_ = 0.0, brightness_ = 1.0;  // brightness: share of a new sample in the noise
  double phase_ = 0.0;                                     // of the rotation, rad
  double noise_ = 0.0;
  std::uint32_t random_ = 1;
};

}  // namespace enamel::viewer
