/* The interface between a host and a driver plugin: C11 and C++17, plain data, no exceptions, no C++ types.
 *
 * A driver is a shared library that exports one function, enamel_driver(). A URL selects it: scheme://ADDRESS?options
 * has the name of the driver as scheme. Life of a device:
 *
 *   connect -> open -> measure, actuate, measure, ... -> close -> open ... close -> disconnect
 *
 * Threads: "setup" functions may allocate, lock and wait. "Tick" functions run in the host's real-time thread; they
 * must not, except for the calls of the system or the vendor that exchange data with the device. Two functions of one
 * device never run at the same time.
 *
 * All numbers are SI. The world frame W has x to the right, y up and z towards the user; the origin is the centre of
 * the device's workspace. Units and axes of the vendor are converted by the driver.
 */
#ifndef ENAMEL_PLUGIN_DRIVER_H
#define ENAMEL_PLUGIN_DRIVER_H

#include "enamel/plugin/abi.h"

/* NOLINTBEGIN(modernize-deprecated-headers, modernize-use-using, readability-identifier-naming): this is C. */
#ifdef __cplusplus
extern "C" {
#endif

/* Interface version. It increases when a struct or the meaning of a function changes. */
#define ENAMEL_DRIVER_ABI_VERSION 1u

/* Name of the exported function. */
#define ENAMEL_DRIVER_SYMBOL "enamel_driver"

/* Reports of a device about itself: bits of EnamelMeasurement.conditions. */
enum EnamelCondition {
  ENAMEL_FORCES_CUT = 1,  /* it has cut its forces by itself, for example because a motor is hot */
  ENAMEL_UNCALIBRATED = 2 /* its positions may be wrong */
};

/* One measurement of a device. */
typedef struct EnamelMeasurement {
  uint32_t size;
  int32_t age;                       /* periods since the last sample; above 0: q, rates and applied are ignored */
  double time;                       /* s, strictly increasing */
  double q[ENAMEL_MAX_JOINTS];       /* rad or m */
  double rates[ENAMEL_MAX_JOINTS];   /* rad/s or m/s */
  double applied[ENAMEL_MAX_JOINTS]; /* torque that acted since the last measurement, N m or N */
  double gripper;                    /* opening angle, rad; see has_gripper */
  double heat;                       /* of the hottest motor: share of its limit; 0 if the device does not report it */
  int32_t applied_known;             /* 0: the device does not report it */
  int32_t has_gripper;
  int32_t enabled;     /* the user's enable; 1 if the device has none */
  int32_t failed;      /* 1: the driver cannot continue */
  uint32_t buttons;    /* bit i: button i is pressed */
  uint32_t conditions; /* EnamelCondition */
} EnamelMeasurement;

/* A device of a driver, or of a program in C. The functions return an EnamelResult. All but measure and actuate may be
 * NULL.
 *
 * open: setup. Make the device ready; the motors are off or balance gravity. After a device of a driver was lost, the
 *   host calls close and open, not more often than 4 times a second, until open succeeds.
 * close: setup. Switch the motors off.
 * measure: tick. ENAMEL_OK: a new sample. ENAMEL_STALE: no new sample since the last call. Others: the device cannot
 *   continue, and the guard ramps out; ENAMEL_INACTIVE also before open and after close.
 * actuate: tick. Send the efforts (N m or N) of `joints` joints. ENAMEL_NOT_FINITE and ENAMEL_OUT_OF_RANGE: nothing was
 *   sent, because a number is not finite, or the number of joints is wrong. Larger efforts than those of the device
 *   file are cut. ENAMEL_STALE: the device could not take the command.
 * grip: tick, before each actuate. Set the force of the gripper's motor, N, opening it; larger ones are cut. */
typedef struct EnamelDevice {
  uint32_t size;
  uint32_t reserved;
  void* user;
  int32_t (*open)(void* user, EnamelMessage message);
  void (*close)(void* user);
  int32_t (*measure)(void* user, EnamelMeasurement* measurement);
  int32_t (*actuate)(void* user, const double* effort, int32_t joints);
  int32_t (*grip)(void* user, double force);
} EnamelDevice;

/* A device that connect() found. */
typedef struct EnamelConnected {
  uint32_t size;
  int32_t joints;          /* of the device file */
  const char* device_file; /* TOML text; valid until disconnect() */
  int32_t delay_low;       /* ticks from the instant of a measurement to the motors, for the command that answers it */
  int32_t delay_high;      /* the largest one */
  int32_t has_own_clock;   /* 1: samples come at instants of the device; measure() is then called four times a tick */
  uint32_t reserved;
  EnamelDevice device;
} EnamelConnected;

/* Functions of a driver. */
typedef struct EnamelDriver {
  uint32_t abi_version;      /* ENAMEL_DRIVER_ABI_VERSION; all later fields may change with it */
  uint32_t driver_size;      /* sizeof(EnamelDriver) */
  uint32_t connected_size;   /* sizeof(EnamelConnected) */
  uint32_t measurement_size; /* sizeof(EnamelMeasurement) */

  /* Setup. Return the description, never NULL. Its name is the scheme: small letters, digits, '-'. Its parameters are
   * the options of a URL. */
  const EnamelDescription* (*describe)(void);

  /* Setup. Write the devices that are connected, one a line: its URL after "scheme://", a tab, and a text. Without any,
   * `message` has the reason, for example that a library of the vendor is missing, and the result is not ENAMEL_OK. */
  int32_t (*list)(EnamelMessage devices, EnamelMessage message);

  /* Setup. Find the device with an address ("": the only or first one), and fill in `connected`. The motors stay off.
   * The host gives only options that the description has. On success `message` may have one line about the device for
   * reports, such as its model, serial number, firmware and limits. */
  int32_t (*connect)(const char* address, const EnamelParameter* options, size_t option_count,
                     EnamelConnected* connected, EnamelMessage message);

  /* Setup, while not open. Release what connect() acquired. */
  void (*disconnect)(EnamelConnected* connected);
} EnamelDriver;

/* Setup. Return the table of functions; the only exported symbol. The table is valid while the library is loaded. */
ENAMEL_PLUGIN_EXPORT const EnamelDriver* enamel_driver(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-deprecated-headers, modernize-use-using, readability-identifier-naming) */

#endif
