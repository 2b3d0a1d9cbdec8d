/* A template for drivers in plain C: a simulated stylus with three axes and one button, held by a hand. Replace the
 * part "the device" by calls of your vendor's library. ../DRIVERS.md has the contract.
 *
 * Build it with the installed package:  find_package(Enamel REQUIRED)  enamel_add_plugin(my_device driver.c)
 * Check it:  enamel check-driver ./my_device.so
 */
#define _POSIX_C_SOURCE 199309L
#include <enamel/plugin/driver.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <time.h>
#endif

#define JOINTS 3
#define MAX_FORCE 3.3 /* N, of each axis, as in the device file */

static const char kDeviceFile[] =
    "kind = \"cartesian\"\n"
    "name = \"Template of a driver\"\n"
    "axes = 3\n"
    "half_widths = [0.080, 0.060, 0.035]  # m\n"
    "max_force = 3.3                      # N\n"
    "position_step = 5.5e-5               # m\n"
    "[platform]\n"
    "mass = 0.045                         # kg\n";

static const EnamelParameter kOptions[] = {{"push", "1", "force of the simulated hand along -z, N"}};

static const EnamelDescription kDescription = {"driver-template", "0.2.0",
                                               "A simulated stylus on three axes: a template for your own driver",
                                               kOptions, sizeof kOptions / sizeof kOptions[0]};

/* ---- the device: a mass of 45 g that a hand pushes along -z, to 20 mm behind the origin ---- */

typedef struct Stylus {
  int is_open;
  double push;                           /* N */
  double time;                           /* s, of the simulation */
  double q[JOINTS], rates[JOINTS];       /* m, m/s */
  double command[JOINTS];                /* N */
  double last[JOINTS], filtered[JOINTS]; /* the measured position before, m; its filtered rate, m/s */
  double last_time;                      /* of the last sample, s */
} Stylus;

/* Return the time of a monotonic clock, s. */
static double now(void) {
#ifdef _WIN32
  LARGE_INTEGER count, frequency;
  QueryPerformanceCounter(&count);
  QueryPerformanceFrequency(&frequency);
  return (double)count.QuadPart / (double)frequency.QuadPart;
#else
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
#endif
}

/* Advance the simulation to the present. After a pause of more than 0.1 s, simulate only the last 0.1 s. */
static void advance(Stylus* stylus, double time) {
  const double mass = 0.045, step = 2e-5;
  if (time - stylus->time > 0.1) stylus->time = time - 0.1;
  for (; stylus->time < time; stylus->time += step) {
    int i;
    for (i = 0; i < JOINTS; ++i) {
      double force = stylus->command[i] - 5.0 * stylus->rates[i] - (i < 2 ? 200.0 * stylus->q[i] : stylus->push);
      if (i == 2 && stylus->q[i] < -0.02) force += 200.0 * (-0.02 - stylus->q[i]);
      stylus->rates[i] += step * force / mass;
      stylus->q[i] += step * stylus->rates[i];
    }
  }
}

/* ---- setup: may allocate, read files and wait ---- */

static int32_t refuse(EnamelMessage message, int32_t result, const char* why, const char* what) {
  if (message.text != NULL && message.size > 0) snprintf(message.text, message.size, "%s%s", why, what);
  return result;
}

static const EnamelDescription* describe(void) { return &kDescription; }

static int32_t list(EnamelMessage devices, EnamelMessage message) {
  (void)message; /* without a device: its reason here, and a result other than ENAMEL_OK */
  snprintf(devices.text, devices.size, "0\tsimulated stylus\n");
  return ENAMEL_OK;
}

static int32_t open_stylus(void* user, EnamelMessage message) {
  Stylus* stylus = user;
  (void)message;
  memset(stylus->command, 0, sizeof stylus->command);
  stylus->is_open = 1;
  return ENAMEL_OK;
}

static void close_stylus(void* user) { ((Stylus*)user)->is_open = 0; }

/* ---- tick: no allocation, no lock; only the exchange with the device ---- */

static int32_t measure(void* user, EnamelMeasurement* measurement) {
  Stylus* stylus = user;
  const double step = 5.5e-5, cutoff = 100.0; /* m; Hz, of the low pass of the rates */
  const double time = now(), elapsed = time - stylus->last_time;
  int i;
  if (!stylus->is_open) return ENAMEL_INACTIVE;
  if (elapsed < 2e-4) return ENAMEL_STALE; /* this device samples at 5 kHz */
  advance(stylus, time);
  memset(measurement, 0, sizeof *measurement);
  measurement->size = sizeof *measurement;
  measurement->time = time;
  measurement->enabled = 1; /* the state of the dead man's switch, if there is one */
  for (i = 0; i < JOINTS; ++i) {
    const double position = step * nearbyint(stylus->q[i] / step);
    const double gain = stylus->last_time > 0.0 ? 1.0 - exp(-2.0 * 3.14159265358979 * cutoff * elapsed) : 0.0;
    stylus->filtered[i] += gain * ((position - stylus->last[i]) / elapsed - stylus->filtered[i]);
    stylus->last[i] = position;
    measurement->q[i] = position;
    measurement->rates[i] = stylus->filtered[i];
  }
  stylus->last_time = time;
  return ENAMEL_OK;
}

static int32_t actuate(void* user, const double* effort, int32_t joints) {
  Stylus* stylus = user;
  int i;
  if (!stylus->is_open) return ENAMEL_INACTIVE;
  if (joints != JOINTS) return ENAMEL_OUT_OF_RANGE;
  for (i = 0; i < JOINTS; ++i)
    if (!isfinite(effort[i])) return ENAMEL_NOT_FINITE;
  advance(stylus, now());
  for (i = 0; i < JOINTS; ++i) stylus->command[i] = fmax(-MAX_FORCE, fmin(MAX_FORCE, effort[i]));
  return ENAMEL_OK;
}

/* ---- connection ---- */

static int32_t connect_stylus(const char* address, const EnamelParameter* options, size_t option_count,
                              EnamelConnected* connected, EnamelMessage message) {
  double push = strtod(kOptions[0].value, NULL);
  Stylus* stylus;
  size_t i;
  if (strcmp(address, "") != 0 && strcmp(address, "0") != 0)
    return refuse(message, ENAMEL_BAD_CONFIGURATION, "there is only the device 0, not ", address);
  for (i = 0; i < option_count; ++i) {
    char* end = NULL;
    push = strtod(options[i].value, &end);
    if (end == options[i].value || *end != 0 || !(push >= 0.0 && push <= 2.0))
      return refuse(message, ENAMEL_BAD_CONFIGURATION, "push must be in 0 to 2 N, is ", options[i].value);
  }
  stylus = calloc(1, sizeof *stylus);
  if (stylus == NULL) return refuse(message, ENAMEL_BAD_CONFIGURATION, "no memory", "");
  stylus->push = push;
  stylus->q[2] = 0.003;
  stylus->time = now();
  connected->joints = JOINTS;
  connected->device_file = kDeviceFile;
  connected->delay_low = connected->delay_high = 0;
  connected->has_own_clock = 0;
  connected->device.size = sizeof connected->device;
  connected->device.user = stylus;
  connected->device.open = open_stylus;
  connected->device.close = close_stylus;
  connected->device.measure = measure;
  connected->device.actuate = actuate;
  return ENAMEL_OK;
}

static void disconnect_stylus(EnamelConnected* connected) { free(connected->device.user); }

/* ---- the table ---- */

const EnamelDriver* enamel_driver(void) {
  static const EnamelDriver table = {ENAMEL_DRIVER_ABI_VERSION,
                                     sizeof(EnamelDriver),
                                     sizeof(EnamelConnected),
                                     sizeof(EnamelMeasurement),
                                     describe,
                                     list,
                                     connect_stylus,
                                     disconnect_stylus};
  return &table;
}
