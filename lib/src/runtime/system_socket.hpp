// A UDP socket of IPv4 that never waits: system_socket_posix.cpp, system_socket_windows.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace enamel::system {

struct Endpoint {
  std::uint32_t address = 0;  // 127.0.0.1: 0x7f000001
  std::uint16_t port = 0;

  bool isLoopback() const noexcept { return (address >> 24) == 127; }
  std::string text() const {
    const auto byte = [this](int shift) { return std::to_string(address >> shift & 255); };
    return byte(24) + "." + byte(16) + "." + byte(8) + "." + byte(0) + ":" + std::to_string(port);
  }
};

// Throws Error: the host is unknown.
Endpoint findHost(const std::string& host, std::uint16_t port);

// Return why the last call of a socket in this thread failed.
std::string lastSocketProblem();

class UdpSocket {
 public:
  // Throws Error. Without `own`: any free port.
  explicit UdpSocket(const std::optional<Endpoint>& own = {});
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  // Exchange datagrams with one endpoint only, or with all again. They return whether the system did so.
  bool connect(const Endpoint& to) noexcept;
  bool disconnect() noexcept;

  std::uint16_t port() const noexcept { return own_.port; }
  bool send(const void* bytes, std::size_t size) noexcept;  // to the connected endpoint
  bool send(const void* bytes, std::size_t size, const Endpoint& to) noexcept;
  // Return the size of a datagram, cut to `size`; -1 if none waits.
  std::int64_t receive(void* bytes, std::size_t size, Endpoint& from) noexcept;

 private:
  std::intptr_t socket_ = -1;
  Endpoint own_;  // where the socket is bound; port 0: nowhere yet
};

}  // namespace enamel::system
