#include <winsock2.h>
// This needs winsock2.h.
#include <ws2tcpip.h>

#include <cstring>
#include <system_error>

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

// Windows needs this call before all others of its sockets.
void startSockets() {
  static const int error = [] {
    WSADATA ignored;
    return WSAStartup(MAKEWORD(2, 2), &ignored);
  }();
  require(error == 0, "device: Windows has no sockets: error " + std::to_string(error));
}

std::string textOf(int error) { return std::system_category().message(error); }

SOCKET openSocket() noexcept {
  const SOCKET opened = socket(AF_INET, SOCK_DGRAM, IPPROTO_UDP);
  u_long on = 1;
  if (opened != INVALID_SOCKET) ioctlsocket(opened, FIONBIO, &on);
  return opened;
}

bool bindTo(SOCKET s, const Endpoint& endpoint) noexcept {
  const sockaddr_in address = toSystem(endpoint);
  return bind(s, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

}  // namespace

Endpoint findHost(const std::string& host, std::uint16_t port) {
  startSockets();
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  require(error == 0 && found != nullptr, "device: cannot find " + host + ": " + textOf(error));
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof(address));
  freeaddrinfo(found);
  return {fromSystem(address).address, port};
}

std::string lastSocketProblem() { return textOf(WSAGetLastError()); }

UdpSocket::UdpSocket(const std::optional<Endpoint>& own) {
  startSockets();
  const SOCKET opened = openSocket();
  require(opened != INVALID_SOCKET, "device: cannot open a socket: " + textOf(WSAGetLastError()));
  socket_ = static_cast<std::intptr_t>(opened);
  if (!own) return;
  sockaddr_in address{};
  int length = sizeof(address);
  if (!bindTo(opened, *own) || getsockname(opened, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    const std::string cause = textOf(WSAGetLastError());
    closesocket(opened);
    throw Error("device: cannot bind to " + own->text() + ": " + cause);
  }
  own_ = fromSystem(address);
}

UdpSocket::~UdpSocket() { closesocket(static_cast<SOCKET>(socket_)); }

bool UdpSocket::connect(const Endpoint& to) noexcept {
  const sockaddr_in address = toSystem(to);
  return ::connect(static_cast<SOCKET>(socket_), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

// A new socket with the same port: systems differ in how they undo connect().
bool UdpSocket::disconnect() noexcept {
  closesocket(static_cast<SOCKET>(socket_));
  const SOCKET opened = openSocket();
  socket_ = static_cast<std::intptr_t>(opened);
  return opened != INVALID_SOCKET && (own_.port == 0 || bindTo(opened, own_));
}

bool UdpSocket::send(const void* bytes, std::size_t size) noexcept {
  return ::send(static_cast<SOCKET>(socket_), static_cast<const char*>(bytes), static_cast<int>(size), 0) ==
         static_cast<int>(size);
}

bool UdpSocket::send(const void* bytes, std::size_t size, const Endpoint& to) noexcept {
  const sockaddr_in address = toSystem(to);
  return sendto(static_cast<SOCKET>(socket_), static_cast<const char*>(bytes), static_cast<int>(size), 0,
                reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == static_cast<int>(size);
}

std::int64_t UdpSocket::receive(void* bytes, std::size_t size, Endpoint& from) noexcept {
  for (int failed = 0; failed < kMostFailed; ++failed) {
    sockaddr_in address{};
    int length = sizeof(address);
    const int received = recvfrom(static_cast<SOCKET>(socket_), static_cast<char*>(bytes), static_cast<int>(size), 0,
                                  reinterpret_cast<sockaddr*>(&address), &length);
    const int error = received < 0 ? WSAGetLastError() : 0;
    if (error == WSAECONNRESET || error == WSAENETRESET) continue;  // an earlier datagram found no receiver
    from = fromSystem(address);
    return error == WSAEMSGSIZE ? static_cast<std::int64_t>(size) : received;
  }
  return -1;
}

}  // namespace enamel::system
