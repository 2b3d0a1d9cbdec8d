#include "enamel/runtime/udp_device.hpp"

#include <chrono>
#include <random>
#include <thread>

#include "core/message.hpp"
#include "runtime/system_socket.hpp"
#include "runtime/system_thread.hpp"

namespace enamel {

using system::clockNow;
using system::Endpoint;
using system::UdpSocket;

namespace {

constexpr int kMostDatagrams = 64;  // per tick

std::uint64_t nonce() {
  std::random_device random;
  return static_cast<std::uint64_t>(random()) << 32 | random();
}

Endpoint find(const std::string& host, std::uint16_t port, const LinkOptions& options) {
  const Endpoint found = system::findHost(host, port);
  require(found.isLoopback() || options.key.has_value(),
          "device: " + host + " can be reached from other machines: give a key, or use 127.0.0.1");
  return found;
}

// Receive all waiting datagrams. Datagrams that are too long are cut, and still have a wrong length.
template <typename Use>
void drain(UdpSocket& s, const Use& use) noexcept {
  unsigned char bytes[sizeof(Datagram) + 1];
  for (int i = 0; i < kMostDatagrams; ++i) {
    Endpoint from;
    const std::int64_t size = s.receive(bytes, sizeof(bytes), from);
    if (size < 0) return;
    use(bytes, static_cast<std::size_t>(size), from);
  }
}

}  // namespace

UdpDevice::UdpDevice(const std::string& host, std::uint16_t port, const LinkOptions& options)
    : client_(options, nonce()) {
  const Endpoint server = find(host, port, options);
  socket_ = std::make_unique<UdpSocket>();
  if (!socket_->connect(server)) throw Error("device: cannot reach " + host + ": " + system::lastSocketProblem());
}

UdpDevice::~UdpDevice() = default;

Status UdpDevice::measure(Measurement& measurement) noexcept {
  drain(*socket_, [this](const unsigned char* bytes, std::size_t size, const Endpoint&) {
    client_.receive(bytes, size, clockNow());
  });
  if (const std::size_t size = client_.call(clockNow(), datagram_); size > 0)
    (void)socket_->send(datagram_.data(), size);
  return client_.measure(measurement, clockNow());
}

Status UdpDevice::actuate(const Command& command) noexcept {
  const std::size_t size = client_.command(command.effort, clockNow(), datagram_);
  if (size == 0) return Status::inactive;
  return socket_->send(datagram_.data(), size) ? Status::ok : Status::stale;
}

struct DeviceServer::Server {
  HapticDevice& device;
  double period;
  LinkServer link;
  UdpSocket socket;
  Endpoint client;
  bool isConnected = false;  // whether the socket is connected to the client
  Measurement measurement;
  Command command;
  Datagram datagram{};
  std::atomic<bool> stop{false}, stopped{false};
  std::unique_ptr<PeriodicThread> thread;

  Server(HapticDevice& d, const Mechanism& mechanism, double p, const LinkOptions& options, const Endpoint& own)
      : device(d), period(p), link(options, mechanism, nonce()), socket(own) {}
  ~Server() { thread.reset(); }

  // During a session the system drops datagrams from other addresses. So a flood cannot displace the client's commands.
  void listen() noexcept {
    if (link.hasSession(clockNow()) == isConnected) return;
    const bool isDone = isConnected ? socket.disconnect() : socket.connect(client);
    isConnected = isDone && !isConnected;
  }

  void tick() noexcept {
    const bool stops = stop.load(std::memory_order_relaxed);
    drain(socket, [&](const unsigned char* bytes, std::size_t size, const Endpoint& from) {
      if (!stops && link.receive(bytes, size, clockNow())) client = from;
    });
    listen();
    const Status measured = device.measure(measurement);
    // Commands received before stop() are ended by the watchdog like any others.
    command.effort = link.torque(measurement.q, period, clockNow());
    (void)device.actuate(command);
    if (measured == Status::ok && !stops)
      if (const std::size_t size = link.measurement(measurement, clockNow(), datagram); size > 0)
        (void)socket.send(datagram.data(), size, client);
    if (stops && link.rests()) stopped.store(true, std::memory_order_relaxed);
  }
};

DeviceServer::DeviceServer(HapticDevice& device, const Mechanism& mechanism, const ServeOptions& options) {
  LinkOptions link = options.link;
  link.joints = mechanism.joints();
  const Endpoint own = find(options.address, options.port, link);
  device.open();
  try {
    server_ = std::make_unique<Server>(device, mechanism, options.period, link, own);
    server_->thread = std::make_unique<PeriodicThread>(
        options.period, [s = server_.get()] { s->tick(); }, options.priority);
  } catch (...) {
    device.close();
    throw;
  }
}

DeviceServer::~DeviceServer() {
  server_->stop.store(true, std::memory_order_relaxed);
  while (!server_->stopped.load(std::memory_order_relaxed)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  server_->thread.reset();
  server_->device.close();
}

std::uint16_t DeviceServer::port() const noexcept { return server_->socket.port(); }
const LinkCounts& DeviceServer::counts() const noexcept { return server_->link.counts(); }
const PeriodicTiming& DeviceServer::timing() const noexcept { return server_->thread->timing(); }

}  // namespace enamel
