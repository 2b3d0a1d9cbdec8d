#include "support/device_wire.hpp"

namespace enamel::test {

std::uint32_t slowCrc(const unsigned char* bytes, std::size_t size) {
  std::uint32_t crc = ~0u;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

void reseal(unsigned char* bytes, std::size_t size) {
  const std::uint32_t crc = slowCrc(bytes, size - 4);
  for (int i = 0; i < 4; ++i) bytes[size - 4 + i] = static_cast<unsigned char>(crc >> (8 * i));
}

void Wire::send(const unsigned char* bytes, std::size_t size, std::int64_t now) {
  if (size == 0) return;
  const std::vector<unsigned char> datagram(bytes, bytes + size);
  const auto at = now + static_cast<std::int64_t>(1e9 * faults.delay) + 20'000;
  if (random_.uniform(0, 1) < faults.forged) {
    std::vector<unsigned char> forged = datagram;
    for (int i = 0; i < 3; ++i) forged[index(forged.size())] ^= static_cast<unsigned char>(1 + index(255));
    if (random_.uniform(0, 1) < 0.5) reseal(forged.data(), forged.size());
    if (random_.uniform(0, 1) < 0.2) forged.resize(index(forged.size() + 1));
    under_.emplace(at - 10'000, forged);
  }
  if (random_.uniform(0, 1) < faults.loss) return;
  const auto late = random_.uniform(0, 1) < faults.swap ? 1'500'000 : 0;
  under_.emplace(at + late, datagram);
  if (random_.uniform(0, 1) < faults.twice) under_.emplace(at + 700'000, datagram);
}

std::size_t Wire::index(std::size_t size) {
  return std::min(size - 1, static_cast<std::size_t>(random_.uniform(0, 1) * static_cast<double>(size)));
}

WrenchFunction swingingHand() {
  return [](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    const Vec3 hand(0.0, 0.0, 0.003 - 0.004 * (1.0 - std::cos(2.0 * M_PI * time)));
    wrench.head<3>() = -200.0 * (pose.position - hand) - 5.0 * twist.head<3>();
    return wrench;
  };
}

VirtualDeviceSetup swingStart() {
  VirtualDeviceSetup setup;
  setup.start.position.z() = 0.003;
  return setup;
}

}  // namespace enamel::test
