// A device behind UDP: a driver in another process, language or machine. The protocol: device_link.hpp and
// lib/docs/device.md. IPv4.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "enamel/runtime/device_link.hpp"
#include "enamel/runtime/periodic_thread.hpp"

namespace enamel {

inline constexpr std::uint16_t kDevicePort = 46464;

/// The end of the loop: a HapticDevice whose motors and encoders are elsewhere. measure() takes what has come and never
/// waits; actuate() sends. Whatever the wire does ends up as a status, so that the loop's guard ramps out.
class UdpDevice final : public HapticDevice {
 public:
  /// Sends nothing yet. Throws Error: as LinkClient; `host` cannot be found; it is not this machine and there is no
  /// key; no socket. Realtime: no.
  UdpDevice(const std::string& host, std::uint16_t port, const LinkOptions& options);
  ~UdpDevice() override;
  UdpDevice(const UdpDevice&) = delete;
  UdpDevice& operator=(const UdpDevice&) = delete;

  /// stale: nothing new, or the commands do not arrive. Realtime: yes (a system call a datagram, at most 64).
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;

  /// inactive: no session with the server; stale: the datagram could not be sent. Realtime: yes (a system call).
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// Any thread. Realtime: yes.
  const LinkCounts& counts() const noexcept { return client_.counts(); }

 private:
  LinkClient client_;
  int socket_;
  Datagram datagram_{};
};

struct ServeOptions {
  std::string address = "127.0.0.1";  ///< to bind to; others than 127.x.x.x need a key
  std::uint16_t port = kDevicePort;   ///< 0: any that is free
  double period = 1e-3;               ///< of the device's ticks, s
  int priority = 80;
  LinkOptions link;  ///< the number of joints is the mechanism's
};

/// Serves a device to one client at a time from a thread of its own, from construction to destruction: a tick takes
/// what has come, measures, actuates and sends the measurement. A command thus acts a tick after its measurement. While
/// a session lasts, only datagrams of its client's address are received.
class DeviceServer {
 public:
  /// Opens the device. `mechanism` (for limits and gravity) and `device` must outlive it. Throws Error: as LinkServer,
  /// PeriodicThread and HapticDevice::open(); the address cannot be bound, or needs a key. Realtime: no.
  DeviceServer(HapticDevice& device, const Mechanism& mechanism, const ServeOptions& options = {});

  /// The torque ramps out before the device is closed.
  ~DeviceServer();
  DeviceServer(const DeviceServer&) = delete;
  DeviceServer& operator=(const DeviceServer&) = delete;

  std::uint16_t port() const noexcept;

  /// Any thread. Realtime: yes.
  const LinkCounts& counts() const noexcept;
  const PeriodicTiming& timing() const noexcept;

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace enamel
