// What a bur throws off: a fixed number of chips that fly and vanish.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/collision/solid.hpp"
#include "enamel/sim/random.hpp"

namespace enamel::viewer {

/// Each stands for the volume that was cut, so that twice as much of it is twice as many. They fly ten times slower
/// than they would, to be seen. Nothing is random but by their number: the same cuts give the same chips.
class Chips {
 public:
  static constexpr std::size_t kPool = 512;    // of which the oldest make room
  static constexpr double kLife = 0.3;         // s
  static constexpr double kVolume = 1e-11;     // m^3 a chip
  static constexpr double kGravity = 9.81e-2;  // m/s^2, against y of W

  struct Chip {
    Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  ///< W, m, m/s
    double age = kLife;                                     ///< s; from kLife on it has vanished
    int layer = 0;                                          ///< that it was cut from
  };

  /// `seconds` pass, in which a bur of this radius (m) cuts these volumes by layer (m^3); its chips leave around
  /// `mouth`, across and along `axis`, which points out of the material.
  void advance(double seconds, const RemovedVolume& cut, const Vec3& mouth, const Vec3& axis, double radius) noexcept;

  const std::array<Chip, kPool>& chips() const noexcept { return chips_; }

 private:
  std::array<Chip, kPool> chips_;
  RemovedVolume owed_{};  // less than a chip each
  std::uint64_t count_ = 0;
  RandomStream random_{1, 1};
};

}  // namespace enamel::viewer
