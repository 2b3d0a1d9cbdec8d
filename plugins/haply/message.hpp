// Messages of the Haply Inverse service, without allocation: https://docs.haply.co/inverseSDK/service/realtime (3.5).
// The service's axes: x right, y forward, z up; m, m/s, N.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace enamel::haply {

using Numbers = std::array<double, 3>;  // x, y, z

inline constexpr std::size_t kIdBytes = 32, kMessageBytes = 512;

/// One device of a message of the service.
struct DeviceState {
  // Only in the first message; otherwise empty:
  std::string_view type, basis, preset, firmware;
  bool isTurned = false;  // mount or workspace turn or scale the positions
  // In each message:
  std::string_view id;
  Numbers position{}, velocity{};  // of the cursor
  bool hasPosition = false;        // all numbers of both are there
  bool isCalibrated = true, hasPower = true;
};

/// The devices of a message. Texts refer to the message.
struct Message {
  std::array<DeviceState, 8> devices;
  std::size_t count = 0;      // at most 8; further ones are ignored
  std::uint32_t buttons = 0;  // of the first grip: a, b, c are bits 0, 1, 2; the only one of a wired grip is bit 0
  bool isValid = false;       // the text is JSON as expected
};

/// Read a message. Members may have any order; unknown ones are skipped. Realtime: yes.
Message readMessage(std::string_view text) noexcept;

/// Format of commands: 3.1 names the vector of a force "values", 3.5 "vector".
enum class Format : std::uint8_t { v31, v35 };

/// Write a command of a force, N. `isFirst`: with the name of this program, which the service shows. Return the number
/// of characters; 0 if the id is longer than kIdBytes. Realtime: yes.
std::size_t writeForce(std::string_view id, const Numbers& force, Format format, bool isFirst,
                       std::array<char, kMessageBytes>& text) noexcept;

}  // namespace enamel::haply
