// The two ends of a UDP link, and an attacker between them that loses, delays, repeats, changes and forges datagrams.
// The attacker does not have the key.
#include <algorithm>
#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/runtime/device_link.hpp"
#include "support/device_wire.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

const Mechanism& device() {
  static const std::shared_ptr<const Mechanism> made = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  return *made;
}

constexpr double kCommand = 1.0;  // N, the client's only command

class Ends {
 public:
  explicit Ends(bool isKeyed)
      : isKeyed_(isKeyed), options_(options(isKeyed)), client_(options_, 5), server_(options_, device(), 6) {
    measurement_.q = measurement_.rates = device().home().q;
  }

  void act(Numbers& numbers) {
    switch (numbers.pick(9)) {
      case 0: now_ += 100'000 * numbers.next<unsigned char>(); break;
      case 1: send(client_.call(now_, datagram_), true, numbers.pick(2) == 0); break;
      case 2: send(server_.measurement(measurement_, now_, datagram_), false, numbers.pick(2) == 0); break;
      case 3: command(numbers.pick(2) == 0); break;
      case 4: deliver(kept(numbers), numbers.pick(2) == 0); break;
      case 5: change(numbers); break;
      case 6: deliver(std::string(numbers.text(255)), numbers.pick(2) == 0); break;
      case 7: answer(); break;
      default: measure(); break;
    }
  }

 private:
  static LinkOptions options(bool isKeyed) {
    LinkOptions made;
    made.joints = 3;
    if (isKeyed) made.key = LinkKey{1, 2, 3};
    return made;
  }
  void send(std::size_t size, bool isToServer, bool arrives) {
    if (size == 0) return;
    sent_.emplace_back(reinterpret_cast<const char*>(datagram_.data()), size);
    if (arrives) deliver(sent_.back(), isToServer);
  }
  void command(bool arrives) {
    measurement_.time += 1e-3;
    send(client_.command(JointVector::Constant(3, kCommand), now_, datagram_), true, arrives);
  }
  std::string kept(Numbers& numbers) const {
    return sent_.empty() ? std::string() : sent_[numbers.next<unsigned char>() % sent_.size()];
  }
  void change(Numbers& numbers) {
    std::string bytes = kept(numbers);
    if (bytes.size() < 4) return;
    for (int changes = 1 + numbers.pick(8); changes > 0; --changes)
      bytes[numbers.next<unsigned char>() % bytes.size()] = numbers.next<char>();
    if (numbers.pick(4) != 0) test::reseal(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size());
    deliver(bytes, numbers.pick(2) == 0);
  }
  void deliver(const std::string& bytes, bool isToServer) {
    const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
    if (isToServer)
      (void)server_.receive(data, bytes.size(), now_);
    else
      client_.receive(data, bytes.size(), now_);
  }
  void answer() {
    const JointVector torque = server_.torque(measurement_.q, 1e-3, now_), gravity = device().home().gravity;
    requireWithin(torque, device().limits().effort);
    if (!isKeyed_) return;
    const JointVector rendered = torque - gravity;
    require(rendered.minCoeff() >= -1e-12 - gravity.cwiseAbs().maxCoeff() && torque.maxCoeff() <= kCommand + 1e-12,
            "with a key, only what the client sent acts");
  }
  void measure() {
    Measurement m;
    if (client_.measure(m, now_) != Status::ok) return;
    require(m.q.size() == 3 && m.q.allFinite() && m.rates.allFinite(), "measurements are finite");
    if (isKeyed_) require(m.q == measurement_.q && m.time <= measurement_.time, "with a key, only the device measures");
  }

  bool isKeyed_;
  LinkOptions options_;
  LinkClient client_;
  LinkServer server_;
  std::int64_t now_ = 1'000'000'000;
  Measurement measurement_;
  Datagram datagram_{};
  std::vector<std::string> sent_;
};

void attackLink(std::string_view bytes) {
  Numbers numbers(bytes);
  Ends ends(numbers.pick(2) == 0);
  while (!numbers.empty()) ends.act(numbers);
}

const Registration kLink{"link", attackLink};

}  // namespace

}  // namespace enamel::attack
