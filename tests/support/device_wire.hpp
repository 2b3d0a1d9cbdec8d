// A device behind a wire that loses, duplicates, reorders, delays and forges datagrams, in simulated time. It behaves
// like a datagram socket, but independently of the machine's load.
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

/// Return the CRC-32, computed bit by bit.
std::uint32_t slowCrc(const unsigned char* bytes, std::size_t size);

/// Write the correct checksum after changed bytes.
void reseal(unsigned char* bytes, std::size_t size);

struct WireFaults {
  double loss = 0.0, twice = 0.0, swap = 0.0, forged = 0.0;  // probabilities
  double delay = 0.0;                                        // s
};

/// One direction of the link.
class Wire {
 public:
  explicit Wire(std::uint64_t seed) : random_(seed) {}
  WireFaults faults;

  void send(const unsigned char* bytes, std::size_t size, std::int64_t now);

  template <typename Use>
  void deliver(std::int64_t now, const Use& use) {
    while (!under_.empty() && under_.begin()->first <= now) {
      const auto datagram = under_.begin()->second;
      under_.erase(under_.begin());
      use(datagram.data(), datagram.size());
    }
  }

 private:
  std::size_t index(std::size_t size);

  Random random_;
  std::multimap<std::int64_t, std::vector<unsigned char>> under_;
};

/// A served simulated device, the wire, and the client's end as a HapticDevice. Server and client tick every 1 ms; the
/// client is half a tick later.
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
    const std::size_t size = client.command(command.effort, now, d);
    up.send(d.data(), size, now);
    return size > 0 ? Status::ok : Status::inactive;
  }

  /// Run the server's tick, and half a period.
  void serve() {
    if (!plugged) {
      now += 500'000;
      return;
    }
    up.deliver(now, [&](const unsigned char* d, std::size_t size) { (void)server.receive(d, size, now); });
    if (plant_.measure(measured) != Status::ok) throw Error("the plant left its workspace");
    motors.effort = server.torque(measured.q, 1e-3, now);
    (void)plant_.actuate(motors);
    Datagram d{};
    down.send(d.data(), server.measurement(measured, now, d), now);
    now += 500'000;
  }
  void pass() { now += 500'000; }  // the client's half period

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

/// Return a hand that swings through the wall z = 0 once per second.
WrenchFunction swingingHand();

VirtualDeviceSetup swingStart();

}  // namespace enamel::test
