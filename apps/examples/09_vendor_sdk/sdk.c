/* Simulates the stand-in in real time: a hand presses a stylus of 45 g on the table twice a second. */
#define _POSIX_C_SOURCE 199309L
#include "sdk.h"

#include <math.h>
#include <time.h>

#define MASS 0.045     /* kg */
#define GRIP 250.0     /* N/m, of the hand */
#define DAMPING 5.0    /* N s/m */
#define STEP 2e-5      /* s */
#define LARGEST 3.3    /* N */
#define COUNT_MM 0.055 /* of the encoders */

static struct {
  int open;
  double time, position[3], velocity[3], force[3]; /* s, m, m/s, N; z away from the user */
  struct timespec begin;
} device;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)(t.tv_sec - device.begin.tv_sec) + 1e-9 * (double)(t.tv_nsec - device.begin.tv_nsec);
}

/* Advance the stylus to `time`. After a pause of more than 0.1 s, simulate only the last 0.1 s. */
static void advance(double time) {
  if (time - device.time > 0.1) device.time = time - 0.1;
  for (; device.time < time; device.time += STEP) {
    const double turn = 4.0 * 3.14159265358979 * device.time;
    const double hand[3] = {0.010 * sin(0.25 * turn), 0.0, 0.004 - 0.007 * cos(turn)};
    for (int i = 0; i < 3; ++i) {
      const double pull = GRIP * (hand[i] - device.position[i]) - DAMPING * device.velocity[i];
      device.velocity[i] += STEP * (pull + device.force[i]) / MASS;
      device.position[i] += STEP * device.velocity[i];
    }
  }
}

int sdk_open(void) {
  if (device.open) return 1;
  clock_gettime(CLOCK_MONOTONIC, &device.begin);
  device.time = 0.0;
  for (int i = 0; i < 3; ++i) device.position[i] = device.velocity[i] = device.force[i] = 0.0;
  device.position[2] = -0.003;
  device.open = 1;
  return 0;
}

int sdk_position(double position_mm[3], int* grip) {
  if (!device.open) return 1;
  advance(now());
  for (int i = 0; i < 3; ++i) position_mm[i] = COUNT_MM * nearbyint(1e3 * device.position[i] / COUNT_MM);
  *grip = 1;
  return 0;
}

int sdk_force(const double force[3]) {
  if (!device.open) return 1;
  advance(now());
  for (int i = 0; i < 3; ++i) device.force[i] = fmax(-LARGEST, fmin(LARGEST, force[i]));
  return 0;
}

void sdk_sleep(double seconds) {
  const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - floor(seconds)))};
  nanosleep(&t, NULL);
}

void sdk_close(void) {
  for (int i = 0; i < 3; ++i) device.force[i] = 0.0;
  device.open = 0;
}
