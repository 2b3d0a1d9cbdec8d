// A WebSocket client for a tick: it never waits and, once connected, never allocates.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace enamel::haply {

class WebSocket {
 public:
  /// Connect and upgrade, within 2 s. Throws std::runtime_error with the cause.
  WebSocket(const std::string& host, const std::string& port);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Receive what has arrived. Return the newest whole message; empty: none is new. It is valid until the next call of
  /// receive() or send(). `count` grows by the number of messages. Realtime: yes.
  std::string_view receive(std::size_t& count) noexcept;

  /// Send a message of at most 512 characters. Return false if the one before is still on its way, or the connection is
  /// lost. Realtime: yes.
  bool send(std::string_view text) noexcept;

  /// Return whether the other end has closed the connection or broken the protocol.
  bool isLost() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::haply
