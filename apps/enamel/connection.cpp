#include "connection.hpp"

#include <charconv>
#include <chrono>
#include <thread>

#include "enamel/core/error.hpp"

namespace enamel::app {

std::pair<std::string, std::uint16_t> addressOf(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  std::uint16_t port = kDevicePort;
  if (colon != std::string::npos) {
    const char *at = text.data() + colon + 1, *end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(at, end, port);
    if (error != std::errc{} || rest != end || port == 0)
      throw Error("--connect is \"" + text + "\", must be HOST or HOST:PORT with a port in 1 to 65535");
  }
  return {host, port};
}

void awaitServer(UdpDevice& device, const std::string& where) {
  Measurement measurement;
  for (int ms = 0; device.measure(measurement) != Status::ok; ++ms) {
    if (ms == 1000)
      throw Error(where +
                  ": no measurement within 1 s; the server needs the same --key and --device, and no other client");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace enamel::app
