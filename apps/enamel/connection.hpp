// Connections to a device over UDP: the option --connect.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "enamel/runtime/udp_device.hpp"

namespace enamel::app {

/// Return host and port of the text HOST or HOST:PORT. Throws Error if the port is invalid.
std::pair<std::string, std::uint16_t> addressOf(const std::string& text);

/// Wait for the first measurement, so that no recording starts without a server. Throws Error after 1 s.
void awaitServer(UdpDevice& device, const std::string& where);

}  // namespace enamel::app
