// Devices with hidden numbers, and recordings of them: the blind test of enamel identify.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "enamel/identify/excitation.hpp"
#include "enamel/runtime/recording.hpp"
#include "enamel/sim/imperfect_plant.hpp"

namespace enamel::test {

/// A device whose file has wrong numbers.
struct BlindDevice {
  DeviceParameters file;   ///< what its owner believes
  DeviceParameters truth;  ///< with the drawn numbers; `built` is made of it
  ImperfectDevice built;
  Delay delay;  ///< ticks
  double jitter = 0.0, lost = 0.0;
  bool isRounded = true;                ///< by the encoders
  double saturation = 1e9;              ///< largest torque that the first motor really gives, N m or N
  std::map<std::string, double> value;  ///< the truth, by the keys of Estimate
};

enum class BlindKind { cartesian3, delta, tau, cartesian6 };

/// Draw a device.
BlindDevice makeBlindDevice(BlindKind kind, std::uint64_t seed);

/// Record the excitation that is designed for the device's file. If the guard stops it, a weaker one follows. `load`
/// acts on the platform. Throws Error with the guard's reason if it also stops the weakest.
std::vector<RecordedTick> recordBlind(const BlindDevice& device, double duration, std::uint64_t seed,
                                      const ExternalWrench* load = nullptr);

}  // namespace enamel::test
