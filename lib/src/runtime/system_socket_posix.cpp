#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/message.hpp"
#include "runtime/system_socket.hpp"

namespace enamel::system {
namespace {

constexpr int kMostFailed = 64;  // datagrams without a receiver, between two that arrive

sockaddr_in toSystem(const Endpoint& endpoint) noexcept {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(endpoint.address);
  address.sin_port = htons(endpoint.port);
  return address;
}

Endpoint fromSystem(const sockaddr_in& address) noexcept {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

}  // namespace

Endpoint findHost(const std::string& host, std::uint16_t port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  require(error == 0 && found != nullptr, "device: cannot find " + host + ": " + gai_strerror(error));
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof(address));
  freeaddrinfo(found);
  return {fromSystem(address).address, port};
}

std::string lastSocketProblem() { return std::strerror(errno); }

UdpSocket::UdpSocket(const std::optional<Endpoint>& own)
    : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  require(socket_ >= 0, std::string("device: cannot open a socket: ") + std::strerror(errno));
  if (!own) return;
  sockaddr_in address = toSystem(*own);
  socklen_t length = sizeof(address);
  if (bind(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      getsockname(static_cast<int>(socket_), reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    const std::string cause = std::strerror(errno);
    close(static_cast<int>(socket_));
    throw Error("device: cannot bind to " + own->text() + ": " + cause);
  }
  own_ = fromSystem(address);
}

UdpSocket::~UdpSocket() { close(static_cast<int>(socket_)); }

bool UdpSocket::connect(const Endpoint& to) noexcept {
  const sockaddr_in address = toSystem(to);
  return ::connect(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

bool UdpSocket::disconnect() noexcept {
  sockaddr_in address{};
  address.sin_family = AF_UNSPEC;
  const bool isDone =
      ::connect(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  // A port that the system chose is lost with the connection: bind it again.
  address = toSystem(own_);
  if (own_.port != 0)
    (void)!bind(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  return isDone;
}

bool UdpSocket::send(const void* bytes, std::size_t size) noexcept {
  return ::send(static_cast<int>(socket_), bytes, size, MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

bool UdpSocket::send(const void* bytes, std::size_t size, const Endpoint& to) noexcept {
  const sockaddr_in address = toSystem(to);
  return sendto(static_cast<int>(socket_), bytes, size, MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
                sizeof(address)) == static_cast<ssize_t>(size);
}

std::int64_t UdpSocket::receive(void* bytes, std::size_t size, Endpoint& from) noexcept {
  for (int failed = 0; failed < kMostFailed; ++failed) {
    sockaddr_in address{};
    socklen_t length = sizeof(address);
    const ssize_t received =
        recvfrom(static_cast<int>(socket_), bytes, size, 0, reinterpret_cast<sockaddr*>(&address), &length);
    if (received < 0 && errno == ECONNREFUSED) continue;  // an earlier datagram found no receiver
    from = fromSystem(address);
    return received;
  }
  return -1;
}

}  // namespace enamel::system
