#include "enamel/runtime/udp_device.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <random>

#include "core/message.hpp"

namespace enamel {
namespace {

constexpr int kMostDatagrams = 64;  // per tick

std::int64_t clockNow() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::uint64_t nonce() {
  std::random_device random;
  return static_cast<std::uint64_t>(random()) << 32 | random();
}

sockaddr_in find(const std::string& host, std::uint16_t port, const LinkOptions& options) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  require(error == 0 && found != nullptr, "device: cannot find " + host + ": " + gai_strerror(error));
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof(address));
  freeaddrinfo(found);
  address.sin_port = htons(port);
  const bool loopback = (ntohl(address.sin_addr.s_addr) >> 24) == 127;
  require(loopback || options.key.has_value(),
          "device: " + host + " can be reached from other machines: give a key, or use 127.0.0.1");
  return address;
}

int openSocket() {
  const int s = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  require(s >= 0, std::string("device: cannot open a socket: ") + std::strerror(errno));
  return s;
}

// Receive all waiting datagrams. Datagrams that are too long are cut, and still have a wrong length.
template <typename Use>
void drain(int s, const Use& use) noexcept {
  unsigned char bytes[sizeof(Datagram) + 1];
  for (int i = 0; i < kMostDatagrams; ++i) {
    sockaddr_in from{};
    socklen_t length = sizeof(from);
    const ssize_t size = recvfrom(s, bytes, sizeof(bytes), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0 && errno == ECONNREFUSED) continue;  // an earlier datagram found no receiver
    if (size < 0) return;
    use(bytes, static_cast<std::size_t>(size), from);
  }
}

}  // namespace

UdpDevice::UdpDevice(const std::string& host, std::uint16_t port, const LinkOptions& options)
    : client_(options, nonce()), socket_(-1) {
  const sockaddr_in server = find(host, port, options);
  socket_ = openSocket();
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&server), sizeof(server)) != 0) {
    const std::string cause = std::strerror(errno);
    ::close(socket_);
    throw Error("device: cannot reach " + host + ": " + cause);
  }
}

UdpDevice::~UdpDevice() { ::close(socket_); }

Status UdpDevice::measure(Measurement& measurement) noexcept {
  drain(socket_, [this](const unsigned char* bytes, std::size_t size, const sockaddr_in&) {
    client_.receive(bytes, size, clockNow());
  });
  if (const std::size_t size = client_.call(clockNow(), datagram_); size > 0)
    (void)!send(socket_, datagram_.data(), size, MSG_NOSIGNAL);
  return client_.measure(measurement, clockNow());
}

Status UdpDevice::actuate(const Command& command) noexcept {
  const std::size_t size = client_.command(command.effort, clockNow(), datagram_);
  if (size == 0) return Status::inactive;
  return send(socket_, datagram_.data(), size, MSG_NOSIGNAL) == static_cast<ssize_t>(size) ? Status::ok : Status::stale;
}

struct DeviceServer::Server {
  HapticDevice& device;
  double period;
  LinkServer link;
  int socket = -1;
  std::uint16_t port = 0;
  sockaddr_in own{}, client{};
  bool isConnected = false;  // whether the socket is connected to the client
  Measurement measurement;
  Command command;
  Datagram datagram{};
  std::atomic<bool> stop{false}, stopped{false};
  std::unique_ptr<PeriodicThread> thread;

  Server(HapticDevice& d, const Mechanism& mechanism, double p, const LinkOptions& options)
      : device(d), period(p), link(options, mechanism, nonce()) {}
  ~Server() {
    thread.reset();
    device.close();
    if (socket >= 0) ::close(socket);
  }

  // During a session the system drops datagrams from other addresses. So a flood cannot displace the client's commands.
  void listen() noexcept {
    if (link.hasSession(clockNow()) == isConnected) return;
    sockaddr_in only = client;
    if (isConnected) only.sin_family = AF_UNSPEC;
    const bool isDone = connect(socket, reinterpret_cast<const sockaddr*>(&only), sizeof(only)) == 0;
    // A port that the system chose is lost with the connection: bind it again.
    if (isConnected) (void)!bind(socket, reinterpret_cast<const sockaddr*>(&own), sizeof(own));
    isConnected = isDone && !isConnected;
  }

  void tick() noexcept {
    const bool stops = stop.load(std::memory_order_relaxed);
    drain(socket, [&](const unsigned char* bytes, std::size_t size, const sockaddr_in& from) {
      if (!stops && link.receive(bytes, size, clockNow())) client = from;
    });
    listen();
    const Status measured = device.measure(measurement);
    // Commands received before stop() are ended by the watchdog like any others.
    command.effort = link.torque(measurement.q, period, clockNow());
    (void)device.actuate(command);
    if (measured == Status::ok && !stops)
      if (const std::size_t size = link.measurement(measurement, clockNow(), datagram); size > 0)
        (void)!sendto(socket, datagram.data(), size, MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&client),
                      sizeof(client));
    if (stops && link.rests()) stopped.store(true, std::memory_order_relaxed);
  }
};

DeviceServer::DeviceServer(HapticDevice& device, const Mechanism& mechanism, const ServeOptions& options) {
  LinkOptions link = options.link;
  link.joints = mechanism.joints();
  sockaddr_in address = find(options.address, options.port, link);
  device.open();
  try {
    server_ = std::make_unique<Server>(device, mechanism, options.period, link);
  } catch (...) {
    device.close();
    throw;
  }
  Server& s = *server_;
  s.socket = openSocket();
  socklen_t length = sizeof(address);
  if (bind(s.socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      getsockname(s.socket, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw Error("device: cannot bind to " + options.address + ":" + std::to_string(options.port) + ": " +
                std::strerror(errno));
  s.own = address;
  s.port = ntohs(address.sin_port);
  s.thread = std::make_unique<PeriodicThread>(
      options.period, [&s] { s.tick(); }, options.priority);
}

DeviceServer::~DeviceServer() {
  server_->stop.store(true, std::memory_order_relaxed);
  while (!server_->stopped.load(std::memory_order_relaxed)) usleep(1000);
}

std::uint16_t DeviceServer::port() const noexcept { return server_->port; }
const LinkCounts& DeviceServer::counts() const noexcept { return server_->link.counts(); }
const PeriodicTiming& DeviceServer::timing() const noexcept { return server_->thread->timing(); }

}  // namespace enamel
