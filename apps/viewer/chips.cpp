#include "chips.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace enamel::viewer {
namespace {

constexpr double kSlowest = 0.006, kFastest = 0.03;  // m/s

void fly(Chips::Chip& chip, double seconds) noexcept {
  const Vec3 fall(0.0, -Chips::kGravity * seconds, 0.0);
  chip.position += (chip.velocity + 0.5 * fall) * seconds;
  chip.velocity += fall;
  chip.age += seconds;
}

}  // namespace

void Chips::advance(double seconds, const RemovedVolume& cut, const Vec3& mouth, const Vec3& axis,
                    double radius) noexcept {
  for (Chip& chip : chips_)
    if (chip.age < kLife) fly(chip, seconds);
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  for (std::size_t layer = 0; layer < cut.size(); ++layer) {
    owed_[layer] = std::fmin(owed_[layer] + cut[layer], kPool * kVolume);
    for (; owed_[layer] >= kVolume; owed_[layer] -= kVolume, ++count_) {
      const auto share = [&](std::uint64_t i) { return random_.uniform(RandomStream::Purpose::noise, 4 * count_ + i); };
      const double angle = 6.283185307179586 * share(0), rise = share(1);
      const Vec3 out = std::cos(angle) * u + std::sin(angle) * v, along = axis.cross(out);  // as the bur turns
      Chip& chip = chips_[count_ % kPool];
      chip.position = mouth + radius * out;
      chip.velocity = (kSlowest + (kFastest - kSlowest) * share(2)) * (0.5 * out + along + rise * axis).normalized();
      chip.age = 0.0;
      chip.layer = static_cast<int>(layer);
      fly(chip, seconds * share(3));  // it left some time within `seconds`
    }
  }
}

}  // namespace enamel::viewer
