// Chips of a bur: a fixed number of particles that fly and vanish.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/collision/solid.hpp"
#include "enamel/sim/random.hpp"

namespace enamel::viewer {

/// Each chip represents a fixed cut volume, so that twice the volume gives twice the chips. They fly ten times slower
/// than real ones, to be visible. Random values depend only on the chip's number: the same cuts give the same chips.
class Chips {
 public:
  static constexpr std::size_t kPool = 512;    // new chips replace the oldest ones
  static constexpr double kLife = 0.3;         // s
  static constexpr double kVolume = 1e-11;     // m^3 per chip
  static constexpr double kGravity = 9.81e-2;  // m/s^2, along -y of W

  struct Chip {
    Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  ///< W, m, m/s
    double age = kLife;                                     ///< s; the chip has vanished from kLife on
    int layer = 0;                                          ///< layer from which it was cut
  };

  /// Advance by `seconds`, in which a bur of this radius (m) cuts these volumes of the layers (m^3). New chips leave
  /// around `mouth`, across and along `axis`, which points out of the material.
  void advance(double seconds, const RemovedVolume& cut, const Vec3& mouth, const Vec3& axis, double radius) noexcept;

  const std::array<Chip, kPool>& chips() const noexcept { return chips_; }

 private:
  std::array<Chip, kPool> chips_;
  RemovedVolume owed_{};  // remainders smaller than one chip
  std::uint64_t count_ = 0;
  RandomStream random_{1, 1};
};

}  // namespace enamel::viewer
