// Errors of the HD API, with what to do. Names and values: its header hdDefines.h.
#pragma once

#include <cstdio>
#include <string>

namespace enamel::openhaptics {

/// An entry of the error stack, as hdGetError() returns it.
struct HdError {
  unsigned code;    ///< 0: no error
  int internal;     ///< of the device
  unsigned handle;  ///< of the device
};

/// Return whether a device cut its force by itself in this frame, and continues.
constexpr bool isCut(unsigned code) noexcept { return (code & 0xFF00U) == 0x0200U; }

/// Return name, value, and what to do.
inline std::string textOf(const HdError& error) {
  struct Row {
    unsigned code;
    const char *name, *advice;
  };
  constexpr Row kRows[] = {
      {0x0104, "HD_BAD_HANDLE", "the device was closed: connect again"},
      {0x0200, "HD_WARM_MOTORS", "the motors are too warm: wait some minutes"},
      {0x0201, "HD_EXCEEDED_MAX_FORCE", "the force is above that of the device"},
      {0x0202, "HD_EXCEEDED_MAX_FORCE_IMPULSE", "the force changes too fast"},
      {0x0203, "HD_EXCEEDED_MAX_VELOCITY", "the stylus moves too fast"},
      {0x0204, "HD_FORCE_ERROR", "the device refuses forces: switch it off and on"},
      {0x0300, "HD_DEVICE_FAULT",
       "check the name in the vendor's setup program, the cables and the rights of the port"},
      {0x0301, "HD_DEVICE_ALREADY_INITIATED", "another part of this program uses it: close that first"},
      {0x0302, "HD_COMM_ERROR", "check power and cable, and start again"},
      {0x0303, "HD_COMM_CONFIG_ERROR", "the port changed: run the vendor's setup program"},
      {0x0304, "HD_TIMER_ERROR", "the scheduler has no timer: restart the program"},
      {0x0501, "HD_SCHEDULER_FULL", "too many callbacks in this program"},
      {0x0600, "HD_INVALID_LICENSE", "install the licence of OpenHaptics"},
  };
  const char *name = "an error", *advice = "see hdDefines.h of OpenHaptics";
  for (const Row& row : kRows)
    if (row.code == error.code) name = row.name, advice = row.advice;
  char text[200];
  std::snprintf(text, sizeof text, "%s (0x%04X, internal %d): %s", name, error.code, error.internal, advice);
  return text;
}

}  // namespace enamel::openhaptics
