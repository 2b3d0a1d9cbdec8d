// A haptic loop over UDP during an attack on real sockets. A proxy loses, duplicates, delays, changes and replays
// datagrams, and another address floods both ends. Usage: attack_udp SECONDS SEED.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <iostream>
#include <thread>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/udp_device.hpp"
#include "support/device_wire.hpp"
#include "support/devices.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

constexpr double kFlood = 1e5;  // datagrams per second
std::atomic<bool> ends{false};

int socketAt(std::uint16_t& port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  const int s = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  require(s >= 0 && bind(s, reinterpret_cast<sockaddr*>(&address), length) == 0 &&
              getsockname(s, reinterpret_cast<sockaddr*>(&address), &length) == 0,
          "a socket can be had");
  port = ntohs(address.sin_port);
  return s;
}

void sendTo(int s, std::uint16_t port, const std::string& bytes) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(port);
  (void)!sendto(s, bytes.data(), bytes.size(), MSG_NOSIGNAL, reinterpret_cast<sockaddr*>(&to), sizeof(to));
}

// Between client and server, without the key. It loses 5 % of the datagrams, delays 5 %, and adds forged ones.
class Proxy {
 public:
  Proxy(std::uint16_t server, std::uint64_t seed) : server_(server), random_(seed), socket_(socketAt(port)) {}
  ~Proxy() { close(socket_); }
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  void run() {
    while (!ends) {
      char bytes[512];
      sockaddr_in from{};
      socklen_t length = sizeof(from);
      const ssize_t size = recvfrom(socket_, bytes, sizeof(bytes), 0, reinterpret_cast<sockaddr*>(&from), &length);
      if (size < 0) {
        usleep(100);
        continue;
      }
      const std::uint16_t sender = ntohs(from.sin_port);
      if (client == 0) client = sender;
      pass(std::string(bytes, static_cast<std::size_t>(size)), sender == server_ ? client.load() : server_);
    }
  }

  std::uint16_t port = 0;
  std::atomic<std::uint16_t> client{0};  // the client's port, known after its first datagram

 private:
  void pass(const std::string& datagram, std::uint16_t to) {
    if (seen_.size() < 500) seen_.emplace_back();
    seen_[index(seen_.size())] = datagram;
    if (seen_.back().empty()) seen_.back() = datagram;
    const double chance = random_.uniform(0.0, 1.0);
    if (chance > 0.1) sendTo(socket_, to, datagram);
    if (chance > 0.05 && chance < 0.1) late_ = datagram;
    if (chance > 0.9 && !late_.empty()) sendTo(socket_, to, late_);
    if (chance > 0.8) sendTo(socket_, to, seen_[index(seen_.size())]);
    if (chance > 0.5 && chance < 0.7) {
      std::string forged = seen_[index(seen_.size())];
      for (int i = 0; i < 3; ++i) forged[index(forged.size())] = static_cast<char>(static_cast<int>(index(256)) - 128);
      test::reseal(reinterpret_cast<unsigned char*>(forged.data()), forged.size());
      sendTo(socket_, to, forged);
    }
  }
  std::size_t index(std::size_t size) {
    return std::min(size - 1, static_cast<std::size_t>(random_.uniform(0.0, static_cast<double>(size))));
  }

  std::uint16_t server_;
  test::Random random_;
  std::vector<std::string> seen_;
  std::string late_;
  int socket_;
};

// Flood both ends from another address.
std::uint64_t flood(std::uint16_t server, const std::atomic<std::uint16_t>& client, std::uint64_t seed) {
  test::Random random(seed);
  std::uint16_t own = 0;
  const int s = socketAt(own);
  std::uint64_t sent = 0;
  const auto begin = std::chrono::steady_clock::now();
  while (!ends) {
    std::string bytes(kCommandBytes, '\0');
    for (char& c : bytes) c = static_cast<char>(random.uniform(-128.0, 128.0));
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    for (; static_cast<double>(sent) < kFlood * passed.count() && !ends; ++sent)
      sendTo(s, sent % 2 == 0 ? server : client.load(), bytes);
    usleep(1000);
  }
  close(s);
  return sent;
}

// The motors: commands must be within the limits.
class Motors final : public HapticDevice {
 public:
  Motors(HapticDevice& plant, const Mechanism& mechanism) : plant_(plant), mechanism_(mechanism) {}
  Status measure(Measurement& m) noexcept override { return plant_.measure(m); }
  Status actuate(const Command& command) noexcept override {
    requireWithin(command.effort, mechanism_.limits().effort);
    return plant_.actuate(command);
  }

 private:
  HapticDevice& plant_;
  const Mechanism& mechanism_;
};

int attack(double seconds, std::uint64_t seed) {
  const std::shared_ptr<const Mechanism> device = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  SimulatedDevice plant(*device, test::swingStart(), test::swingingHand());
  Motors motors(plant, *device);
  ServeOptions options;
  options.port = 0;
  options.link.key = LinkKey{1, 2, 3};
  const DeviceServer server(motors, *device, options);
  Proxy proxy(server.port(), seed);
  LinkOptions link;
  link.joints = 3;
  link.key = options.link.key;
  UdpDevice client("127.0.0.1", proxy.port, link);
  const Scene scene = flatWall();
  ImpedanceRenderer wall({400.0, 0.0});
  HapticTick haptics(*device, scene, Tool(), wall, 1e-3);
  std::uint64_t sent = 0, resets = 0;
  std::thread between([&] { proxy.run(); });
  std::thread elsewhere([&] { sent = flood(server.port(), proxy.client, seed + 1); });
  {
    HapticLoopOptions loopOptions;
    loopOptions.firstMeasurement = 60.0;
    HapticLoop loop(client, haptics, loopOptions);
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < seconds) {
      usleep(20000);
      if (!loop.refresh()) continue;
      if (isFault(loop.latest().reason)) resets += loop.reset();
    }
  }
  ends = true;
  between.join();
  elsewhere.join();
  std::cout << sent << " datagrams of the flood; the device took " << server.counts().accepted << " commands";
  for (int i = 0; i < kDropReasons; ++i)
    if (const std::uint64_t number = server.counts().dropped[static_cast<std::size_t>(i)]; number > 0)
      std::cout << ", " << number << " dropped: " << toString(static_cast<DropReason>(i));
  std::cout << "; " << resets << " faults were reset\n";
  require(server.counts().accepted > 0 && client.counts().accepted > 0, "commands and measurements get through");
  return 0;
}

}  // namespace

}  // namespace enamel::attack

int main(int count, char** arguments) {
  if (count != 3) return std::fprintf(stderr, "attack_udp SECONDS SEED\n"), 2;
  return enamel::attack::attack(std::atof(arguments[1]), std::strtoull(arguments[2], nullptr, 10));
}
