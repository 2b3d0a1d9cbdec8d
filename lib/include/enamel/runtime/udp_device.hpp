// A device over UDP (IPv4): the driver runs in another process, language or machine. Protocol: device_link.hpp and
// lib/docs/device.md.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "enamel/runtime/device_link.hpp"
#include "enamel/runtime/periodic_thread.hpp"

namespace enamel {

namespace system {
class UdpSocket;
}

inline constexpr std::uint16_t kDevicePort = 46464;

/// The loop's end: a HapticDevice with remote motors and encoders. measure() takes the datagrams that have arrived and
/// never waits. actuate() sends. Each failure of the wire becomes a status, and the loop's guard then ramps out.
class UdpDevice final : public HapticDevice {
 public:
  /// Create the socket; send nothing yet. Throws Error as LinkClient, and if `host` cannot be found or no socket is
  /// available. Throws Error also if `host` is another machine and the key is missing. Realtime: no.
  UdpDevice(const std::string& host, std::uint16_t port, const LinkOptions& options);
  ~UdpDevice() override;
  UdpDevice(const UdpDevice&) = delete;
  UdpDevice& operator=(const UdpDevice&) = delete;

  /// Measure. Status stale: nothing new arrived, or the commands do not reach the server. Realtime: yes (one system
  /// call per datagram, at most 64).
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;

  /// Send a command. Status inactive: the server has not answered yet, or the session has ended. Status stale: the
  /// datagram could not be sent. Realtime: yes (one system call).
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// Return the counters of the link. Threads: any. Realtime: yes.
  const LinkCounts& counts() const noexcept { return client_.counts(); }

 private:
  LinkClient client_;
  std::unique_ptr<system::UdpSocket> socket_;
  Datagram datagram_{};
};

struct ServeOptions {
  std::string address = "127.0.0.1";  ///< address to bind to; others than 127.x.x.x require a key
  std::uint16_t port = kDevicePort;   ///< 0: any free port
  double period = 1e-3;               ///< of the device's ticks, s
  int priority = 80;
  LinkOptions link;  ///< its number of joints is the mechanism's
};

/// Serve a device to one client at a time from a separate thread, from construction to destruction. Each tick receives,
/// measures, actuates and sends the measurement. A command therefore acts one tick after its measurement. During a
/// session only datagrams from its client's address are received.
class DeviceServer {
 public:
  /// Open the device. `mechanism` (for limits and gravity) and `device` must outlive this object. Throws Error as
  /// LinkServer, PeriodicThread and HapticDevice::open(), and if the address cannot be bound or requires a key.
  /// Realtime: no.
  DeviceServer(HapticDevice& device, const Mechanism& mechanism, const ServeOptions& options = {});

  /// Ramp the torque out and close the device.
  ~DeviceServer();
  DeviceServer(const DeviceServer&) = delete;
  DeviceServer& operator=(const DeviceServer&) = delete;

  std::uint16_t port() const noexcept;

  /// Return counters and timing. Threads: any. Realtime: yes.
  const LinkCounts& counts() const noexcept;
  const PeriodicTiming& timing() const noexcept;

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace enamel
