// The driver of the Haply Inverse3 through the Haply Inverse service: a WebSocket on port 10001 with JSON messages. The
// service answers each message with one state, so each tick sends one force, and the next tick reads the state that
// answers it. lib/docs/haply.md has the page. Not yet tried on hardware.
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "../driver_functions.hpp"
#include "message.hpp"
#include "web_socket.hpp"

namespace enamel::haply {
namespace {

constexpr int kJoints = 3;
constexpr double kMaxForce = 6.0;           // N, of each axis, as in the device file
constexpr std::size_t kMostUnanswered = 8;  // messages; more means that the service hangs
constexpr std::chrono::seconds kFirstMessage{1};
constexpr const char* kAddress = "localhost:10001";
constexpr const char* kNoDevice = "the service has no Inverse3: check its cable and power, and the vendor's Haply Hub";

const char* const kDeviceFile =
#include <inverse3_device.inl>
    ;

const EnamelParameter kOptions[] = {
    {"id", "first", "device_id of the Inverse3, as the service shows it"},
    {"centre", "0,-0.14,0.18", "middle of the workspace in the axes of the service (x right, y forward, z up), m"},
    {"format", "3.5", "version of the service's messages: 3.1 or 3.5"},
};
const EnamelDescription kDescription = {"haply", "0.2.0", "Haply Inverse3 through the Haply Inverse service", kOptions,
                                        sizeof kOptions / sizeof kOptions[0]};

// W has x right, y up, z towards the user; the service x right, y forward, z up.
void toWorld(const Numbers& service, double* world) noexcept {
  world[0] = service[0];
  world[1] = service[2];
  world[2] = -service[1];
}
Numbers toService(const double* world) noexcept { return {world[0], -world[2], world[1]}; }

struct Address {
  std::string host, port;
};

Address addressOf(const std::string& text) {
  const std::string whole = text.empty() ? kAddress : text;
  const std::size_t colon = whole.rfind(':');
  int port = 0;
  const char* const end = whole.data() + whole.size();
  const bool isPort = colon != std::string::npos && colon > 0 &&
                      std::from_chars(whole.data() + colon + 1, end, port).ptr == end && port > 0 && port < 65536;
  if (!isPort) throw std::runtime_error("the address \"" + whole + "\" must be HOST:PORT, such as " + kAddress);
  return {whole.substr(0, colon), whole.substr(colon + 1)};
}

// Wait for the message with which the service begins: all devices.
std::string_view firstMessage(WebSocket& socket) {
  std::size_t count = 0;
  for (const auto begin = std::chrono::steady_clock::now(); std::chrono::steady_clock::now() - begin < kFirstMessage;) {
    if (const std::string_view text = socket.receive(count); !text.empty()) return text;
    if (socket.isLost()) throw std::runtime_error("the service closed the connection");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throw std::runtime_error("the service sent no message within 1 s");
}

class Inverse3 {
 public:
  Inverse3(const Address& address, std::string id, const Numbers& centre, Format format)
      : address_(address), wanted_(std::move(id)), centre_(centre), format_(format) {
    connect();
  }

  const std::string& facts() const noexcept { return facts_; }

  void open() {
    if (!socket_ || socket_->isLost()) connect();
    isOpen_ = true;
    isFirst_ = true;
    (void)send({});  // the service answers messages only
  }

  void close() noexcept {
    (void)send({});
    isOpen_ = false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    std::size_t ignored = 0;
    (void)socket_->receive(ignored);
    answered_ = sent_;
  }

  std::int32_t measure(EnamelMeasurement& m) noexcept {
    if (!isOpen_) return ENAMEL_INACTIVE;
    std::size_t answers = 0;
    const std::string_view text = socket_->receive(answers);
    if (socket_->isLost()) return ENAMEL_INACTIVE;
    if (text.empty()) return ENAMEL_STALE;
    answered_ = std::min(sent_, answered_ + answers);
    const Message message = readMessage(text);
    if (!message.isValid) return ENAMEL_STALE;
    const auto* const end = message.devices.data() + message.count;
    const auto* const device =
        std::find_if(message.devices.data(), end, [this](const DeviceState& d) { return d.id == id_; });
    if (device == end || !device->hasPosition) return ENAMEL_STALE;  // unplugged: the guard ramps out
    // The state is that of the moment at which the service read the message that it answers.
    const double time = sentAt_[(answered_ + kMostUnanswered - 1) % kMostUnanswered];
    if (!(time > time_)) return ENAMEL_STALE;
    std::memset(&m, 0, sizeof m);
    m.size = sizeof m;
    m.time = time_ = time;
    m.enabled = device->hasPower ? 1 : 0;
    m.buttons = message.buttons;
    m.conditions = (device->isCalibrated ? 0U : std::uint32_t{ENAMEL_UNCALIBRATED}) |
                   (device->hasPower ? 0U : std::uint32_t{ENAMEL_FORCES_CUT});
    const Numbers& p = device->position;
    toWorld({p[0] - centre_[0], p[1] - centre_[1], p[2] - centre_[2]}, m.q);
    toWorld(device->velocity, m.rates);
    return ENAMEL_OK;
  }

  std::int32_t actuate(const double* effort, std::int32_t joints) noexcept {
    if (!isOpen_) return ENAMEL_INACTIVE;
    if (const std::int32_t checked = checkEfforts(effort, joints, kJoints); checked != ENAMEL_OK) return checked;
    std::array<double, kJoints> force{};
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = std::clamp(effort[i], -kMaxForce, kMaxForce);
    if (socket_->isLost()) return ENAMEL_INACTIVE;
    return send(toService(force.data())) ? ENAMEL_OK : ENAMEL_STALE;
  }

 private:
  void connect() {
    socket_ = std::make_unique<WebSocket>(address_.host, address_.port);
    const Message message = readMessage(firstMessage(*socket_));
    if (!message.isValid) throw std::runtime_error("the first message of the service is not understood");
    std::string found;
    const DeviceState* device = nullptr;
    for (std::size_t i = 0; i < message.count; ++i) {
      found += (i > 0 ? ", " : "") + std::string(message.devices[i].id);
      if (device == nullptr && (wanted_ == "first" || message.devices[i].id == wanted_)) device = &message.devices[i];
    }
    if (device == nullptr)
      throw std::runtime_error(found.empty() ? kNoDevice
                                             : "the service has no Inverse3 \"" + wanted_ + "\", only " + found);
    if (device->id.size() > kIdBytes) throw std::runtime_error("the device_id is longer than 32 characters");
    if (!device->basis.empty() && device->basis != "XYZ")
      throw std::runtime_error("the service permutes its axes (basis " + std::string(device->basis) +
                               "): set the basis XYZ");
    if (device->isTurned)
      throw std::runtime_error("the service turns or scales its positions (preset \"" + std::string(device->preset) +
                               "\", mount or workspace): set the preset defaults");
    if (!device->isCalibrated)
      throw std::runtime_error("the Inverse3 " + std::string(device->id) + " is not calibrated");
    id_ = device->id;
    facts_ = std::string(device->type) + " " + id_ + ", firmware " + std::string(device->firmware) + ", preset " +
             std::string(device->preset);
    sent_ = answered_ = 0;
  }

  bool send(const Numbers& force) noexcept {
    if (sent_ - answered_ >= kMostUnanswered) return false;
    const std::size_t size = writeForce(id_, force, format_, isFirst_, text_);
    if (size == 0 || !socket_->send({text_.data(), size})) return false;
    isFirst_ = false;
    sentAt_[sent_++ % kMostUnanswered] = driverClock();
    return true;
  }

  Address address_;
  std::string wanted_, id_, facts_;
  Numbers centre_;
  Format format_;
  std::unique_ptr<WebSocket> socket_;
  std::array<char, kMessageBytes> text_{};
  std::array<double, kMostUnanswered> sentAt_{};  // s, of the last messages
  std::size_t sent_ = 0, answered_ = 0;           // messages
  double time_ = 0.0;                             // of the last sample, s
  bool isOpen_ = false, isFirst_ = true;
};

Numbers numbersOf(const std::string& text) {
  Numbers numbers{};
  const char *at = text.data(), *const end = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [rest, error] = std::from_chars(at, end, numbers[i]);
    const bool isLast = i + 1 == numbers.size();
    if (error != std::errc{} || !(std::abs(numbers[i]) < 1.0) || (isLast ? rest != end : rest == end || *rest != ','))
      throw std::runtime_error("centre is \"" + text + "\", must be X,Y,Z in m, within 1 m");
    at = isLast ? rest : rest + 1;
  }
  return numbers;
}

std::int32_t list(EnamelMessage devices, EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const Address address = addressOf("");
    WebSocket socket(address.host, address.port);
    const Message first = readMessage(firstMessage(socket));
    std::string lines;
    for (std::size_t i = 0; i < first.count; ++i)
      lines += std::string(kAddress) + "?id=" + std::string(first.devices[i].id) + "\t" +
               std::string(first.devices[i].type) + "\n";
    if (lines.empty()) throw std::runtime_error(kNoDevice);
    std::snprintf(devices.text, devices.size, "%s", lines.c_str());
  });
}

std::int32_t connect(const char* address, const EnamelParameter* options, std::size_t count, EnamelConnected* connected,
                     EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const auto option = [&](std::size_t i) { return optionOf(kOptions[i], options, count); };
    const std::string format = option(2);
    if (format != "3.1" && format != "3.5")
      throw std::runtime_error("format is \"" + format + "\", must be 3.1 or 3.5");
    auto device = std::make_unique<Inverse3>(addressOf(address), option(0), numbersOf(option(1)),
                                             format == "3.5" ? Format::v35 : Format::v31);
    connected->joints = kJoints;
    connected->device_file = kDeviceFile;
    connected->delay_low = connected->delay_high = 1;  // a state answers the message of the tick before
    connected->has_own_clock = 0;
    std::snprintf(message.text, message.size, "%s", device->facts().c_str());
    connected->device = deviceTable(device.release());
  });
}

}  // namespace
}  // namespace enamel::haply

extern "C" const EnamelDriver* enamel_driver(void) {
  using namespace enamel::haply;
  static const EnamelDriver table = enamel::driverTable<Inverse3>([] { return &kDescription; }, list, connect);
  return &table;
}
