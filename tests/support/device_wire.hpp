// A device behind a wire that loses, doubles, reorders, delays and forges, on simulated time: what a datagram socket
// does, without sockets and clocks, so that the machine's load changes nothing.
#pragma once

#include <cstring>
#include <functional>
#include <map>
#include <vector>

#include "enamel/device/cartesian/mechanism.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/runtime/device_link.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/simulated_device.hpp"
#include "support/devices.hpp"

namespace enamel::test {

/// CRC-32, bit by bit.
inline std::uint32_t slowCrc(const unsigned char* bytes, std::size_t size) {
  std::uint32_t crc = ~0u;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

/// Writes the right checksum behind changed bytes.
inline void reseal(unsigned char* bytes, std::size_t size) {
  const std::uint32_t crc = slowCrc(bytes, size - 4);
  for (int i = 0; i < 4; ++i) bytes[size - 4 + i] = static_cast<unsigned char>(crc >> (8 * i));
}

struct WireFaults {
  double loss = 0.0, twice = 0.0, swap = 0.0, forged = 0.0;  // probabilities
  double delay = 0.0;                                        // s
};

/// One direction.
class Wire {
 public:
  explicit Wire(std::uint64_t seed) : random_(seed) {}
  WireFaults faults;

  void send(const unsigned char* bytes, std::size_t size, std::int64_t now) {
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

  template <typename Use>
  void deliver(std::int64_t now, const Use& use) {
    while (!under_.empty() && under_.begin()->first <= now) {
      const auto datagram = under_.begin()->second;
      under_.erase(under_.begin());
      use(datagram.data(), datagram.size());
    }
  }

 private:
  std::size_t index(std::size_t size) {
    return std::min(size - 1, static_cast<std::size_t>(random_.uniform(0, 1) * static_cast<double>(size)));
  }

  Random random_;
  std::multimap<std::int64_t, std::vector<unsigned char>> under_;
};

/// A served simulated device, the wire, and the client's end as a HapticDevice. Server and client tick once a ms, the
/// client half a tick later.
class WiredDevice final : public HapticDevice {
 public:
  WiredDevice(const Mechanism& mechanism, HapticDevice& plant, std::optional<LinkKey> key = {})
      : options_(linkOptions(mechanism, key)),
        client(options_, 11),
        server(options_, mechanism, 22),
        up(1),
        down(2),
        plant_(plant) {}

  void open() override {
    for (int i = 0; i < 20; ++i) {
      serve();
      listen();
    }
  }
  Status measure(Measurement& measurement) noexcept override {
    listen();
    return client.measure(measurement, now);
  }
  Status actuate(const Command& command) noexcept override {
    Datagram d{};
    const std::size_t size = client.command(command.torque, now, d);
    up.send(d.data(), size, now);
    return size > 0 ? Status::ok : Status::inactive;
  }

  /// The server's tick, and half a period.
  void serve() {
    if (!plugged) {
      now += 500'000;
      return;
    }
    up.deliver(now, [&](const unsigned char* d, std::size_t size) { (void)server.receive(d, size, now); });
    if (plant_.measure(measured) != Status::ok) throw Error("the plant left its workspace");
    motors.torque = server.torque(measured.q, 1e-3, now);
    (void)plant_.actuate(motors);
    Datagram d{};
    down.send(d.data(), server.measurement(measured, now, d), now);
    now += 500'000;
  }
  void pass() { now += 500'000; }  // the client's half

  bool plugged = true;
  std::int64_t now = 1'000'000'000;
  Measurement measured;
  Command motors;

 private:
  static LinkOptions linkOptions(const Mechanism& mechanism, const std::optional<LinkKey>& key) {
    LinkOptions options;
    options.joints = mechanism.joints();
    options.key = key;
    return options;
  }
  void listen() {
    down.deliver(now, [&](const unsigned char* d, std::size_t size) { client.receive(d, size, now); });
    Datagram d{};
    up.send(d.data(), client.call(now, d), now);
    if (client.counts().accepted == 0) now += 500'000;
  }

  LinkOptions options_;

 public:
  LinkClient client;
  LinkServer server;
  Wire up, down;

 private:
  HapticDevice& plant_;
};

/// A hand that swings through the wall z = 0, once a second.
inline PersonalLoad swingingHand() {
  return [](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    const Vec3 hand(0.0, 0.0, 0.003 - 0.004 * (1.0 - std::cos(2.0 * M_PI * time)));
    wrench.head<3>() = -200.0 * (pose.position - hand) - 5.0 * twist.head<3>();
    return wrench;
  };
}

inline VirtualDeviceSetup swingStart() {
  VirtualDeviceSetup setup;
  setup.start.position.z() = 0.003;
  return setup;
}

}  // namespace enamel::test
