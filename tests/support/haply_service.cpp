#include "support/haply_service.hpp"

#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/system_thread.hpp"
#include "support/held_device.hpp"

namespace enamel::test {

namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using tcp = net::ip::tcp;
using Lock = std::lock_guard<std::mutex>;

constexpr double kPeriod = 2.5e-4;  // s, of the device
const char* const kId = "049D";
const Vec3 kCentre(0.0, -0.14, 0.18);  // of the workspace, in the service's axes, m

Json jsonOf(const Vec3& v) { return Json{{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

// Between W (x right, y up, z towards the user) and the service's axes (x right, y forward, z up).
Vec3 toService(const Vec3& w) { return {w.x(), -w.z(), w.y()}; }
Vec3 toWorld(const Vec3& s) { return {s.x(), s.z(), -s.y()}; }

}  // namespace

struct HaplyService::Server {
  HaplyService& service;
  double high, low;
  HeldDevice device;
  Clock::time_point begin = Clock::now();
  net::io_context io;
  tcp::acceptor acceptor{io, tcp::endpoint(net::ip::address_v4::loopback(), 0)};
  std::atomic<int> open{-1};  // the socket of the client
  std::atomic<bool> stops{false};
  std::mutex mutex;             // of device, applied and isHeld
  Vec3 applied = Vec3::Zero();  // axes of W, N
  bool isHeld = false;
  double skipped = 0.0;  // s, of the clock
  std::thread thread;    // last: it uses all others

  Server(HaplyService& s, const std::string& file, double from, double to)
      : service(s), high(from), low(to), device(loadDevice(file), kPeriod, from * Vec3::UnitZ()), thread([this] {
          run();
        }) {}
  ~Server() {
    stops = true;
    shutdown(acceptor.native_handle(), SHUT_RDWR);
    if (const int client = open; client >= 0) shutdown(client, SHUT_RDWR);
    thread.join();
  }

  void run() {
    {
      const Lock lock(mutex);
      device.advance(applied, Vec3::Zero());  // a clock that the test advances may not have moved
    }
    (void)system::requestRealtime(70);  // other programs on this machine are not part of the test
    while (!stops) {
      beast::error_code error;
      tcp::socket socket(io);
      acceptor.accept(socket, error);
      if (error) continue;
      socket.set_option(tcp::no_delay(true));
      open = socket.native_handle();
      if (!stops) serve(std::move(socket));
      open = -1;
    }
  }

  void serve(tcp::socket socket) {
    beast::websocket::stream<tcp::socket> stream(std::move(socket));
    beast::error_code error;
    stream.accept(error);
    stream.text(true);
    if (!error) stream.write(net::buffer(stateText(true)), error);
    while (!error) {
      beast::flat_buffer buffer;
      stream.read(buffer, error);
      if (error || service.isClosing.exchange(false)) {  // the motors are off without a client
        const Lock lock(mutex);
        applied.setZero();
        service.force = 0.0;
        return;
      }
      take(Json::parse(beast::buffers_to_string(buffer.data())));
      const int late = service.late_ms + service.lateOnce_ms.exchange(0);
      if (late > 0) std::this_thread::sleep_for(std::chrono::milliseconds(late));
      const std::string text = service.isGarbage ? "{\"inverse3\":[{\"device_id" : stateText(false);
      service.isSlow ? writeSlowly(stream, text, error) : void(stream.write(net::buffer(text), error));
      ++service.messages;
    }
  }

  // Two fragments of one message, and a pause within the second frame.
  static void writeSlowly(beast::websocket::stream<tcp::socket>& stream, const std::string& text,
                          beast::error_code& error) {
    const std::size_t half = text.size() / 2;
    stream.write_some(false, net::buffer(text.data(), half), error);
    std::this_thread::sleep_for(std::chrono::microseconds(300));
    if (!error) stream.write_some(true, net::buffer(text.data() + half, text.size() - half), error);
  }

  void take(const Json& message) {
    const Lock lock(mutex);
    advance();
    if (message.contains("session")) service.hasProfile = true;
    const Json& command = message.at("inverse3").at(0);
    if (command.at("device_id") != kId) return;
    const Json& v = command.at("commands").at("set_cursor_force").at("vector");
    const Vec3 f(v.at("x"), v.at("y"), v.at("z"));
    service.force = f.norm();
    service.largestForce = std::max(service.largestForce.load(), f.norm());
    applied = toWorld(f);
  }

  // Simulate to the present, at most 0.1 s.
  void advance() {
    if (device.isShown()) return;
    const double now = std::chrono::duration<double>(Clock::now() - begin).count() - skipped;
    if (now - device.time() > 0.1) skipped += now - device.time() - 0.1;
    while (device.time() < std::chrono::duration<double>(Clock::now() - begin).count() - skipped) {
      if (!isHeld) device.place.z() = 0.5 * (high + low) + 0.5 * (high - low) * std::cos(2.0 * M_PI * device.time());
      device.advance(applied, Vec3::Zero());
    }
  }

  std::string stateText(bool isFirst) {
    const Lock lock(mutex);
    advance();
    const Json state{{"cursor_position", jsonOf(toService(Vec3(device.sample().q)) + kCentre)},
                     {"cursor_velocity", jsonOf(toService(Vec3(device.sample().rates)))},
                     {"current_cursor_force", jsonOf(toService(applied))},
                     {"control_mode", "force"}};
    Json entry{{"device_id", kId}};
    if (isFirst) {
      const Json rotation{{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}},
          half{{"w", 0.0}, {"x", 0.0}, {"y", 0.0}, {"z", 1.0}};
      entry["config"] = {{"type", "inverse3"},
                         {"preset", "defaults"},
                         {"extended_firmware_version", "8C20"},
                         {"mount",
                          {{"position", jsonOf(Vec3(0.1, 0.0, 0.0))},
                           {"rotation", service.isTurned ? half : rotation},
                           {"scale", jsonOf(Vec3::Ones())}}},
                         {"basis", {{"permutation", service.isPermuted ? "XZY" : "XYZ"}}}};
    }
    entry["status"] = {{"calibrated", !service.isUncalibrated}, {"power_supply", !service.hasNoPower}};
    entry["state"] = state;
    Json grip{{"device_id", "0012"}, {"state", {{"buttons", {{"a", false}, {"b", true}, {"c", false}}}}}};
    Json message{{"session_id", 7}, {"inverse3", Json::array()}, {"wireless_verse_grip", Json::array({grip})}};
    if (!service.isUnplugged || isFirst) message["inverse3"].push_back(entry);
    if (service.isShuffled && !isFirst && !service.isUnplugged) {
      Json mixed{{"state",
                  {{"angular_velocity", {{"a0", -1.5e-3}}},
                   {"cursor_velocity",
                    {{"z", state["cursor_velocity"]["z"]}, {"x", 0.0}, {"y", state["cursor_velocity"]["y"]}}},
                   {"notes", {nullptr, "a \"quoted\" \\ text", {{"deep", {1, 2.5e-7, {true, false}}}}}},
                   {"cursor_position", state["cursor_position"]}}},
                 {"device_id", kId}};
      mixed["state"]["cursor_velocity"]["x"] = state["cursor_velocity"]["x"];
      message = {{"wireless_verse_grip", message["wireless_verse_grip"]}, {"inverse3", {mixed}}, {"session_id", 7}};
    }
    return message.dump();
  }
};

HaplyService::HaplyService(const std::string& deviceFile, double high, double low)
    : server_(std::make_unique<Server>(*this, deviceFile, high, low)) {}
HaplyService::~HaplyService() = default;
void HaplyService::hold(const Vec3& place, double stiffness, double damping) {
  const Lock lock(server_->mutex);
  server_->isHeld = true;
  server_->device.place = place;
  server_->device.stiffness = stiffness;
  server_->device.damping = damping;
}
void HaplyService::show(const Measurement& sample) {
  const Lock lock(server_->mutex);
  server_->device.show(sample);
}
Vec3 HaplyService::newestForce() const {
  const Lock lock(server_->mutex);
  return server_->applied;
}
std::string HaplyService::address() const {
  return "127.0.0.1:" + std::to_string(server_->acceptor.local_endpoint().port());
}

}  // namespace enamel::test
