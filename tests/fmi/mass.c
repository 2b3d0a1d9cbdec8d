/* An FMI 3.0 unit as another tool might write it: in C, from the text of the standard, without this project's sources.
   Three motors push a body of 0.1 kg along x, y, z with a damping of 2 N s/m. The motion is exact for a constant force
   over a step. Its variables are scalars in an unusual order, and it has no parameters. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define MASS 0.1
#define DAMPING 2.0
#define EXPORT __attribute__((visibility("default")))

/* torque 0-2, force 3-5, velocity 6-8, position 9-11, time 12 */
typedef struct {
  double value[13];
} Body;

EXPORT const char* fmi3GetVersion(void) { return "3.0"; }

EXPORT void* fmi3InstantiateCoSimulation(const char* name, const char* token, const char* resources, bool visible,
                                         bool logging, bool events, bool early, const uint32_t required[], size_t count,
                                         void* environment, void* log, void* update) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
  (void)required, (void)count, (void)environment, (void)log, (void)update;
  return calloc(1, sizeof(Body));
}
EXPORT void fmi3FreeInstance(void* body) { free(body); }
EXPORT int fmi3EnterInitializationMode(void* body, bool tolerant, double tolerance, double start, bool stops,
                                       double stop) {
  (void)tolerant, (void)tolerance, (void)stops, (void)stop;
  ((Body*)body)->value[12] = start;
  return 0;
}
EXPORT int fmi3ExitInitializationMode(void* body) { return (void)body, 0; }
EXPORT int fmi3Terminate(void* body) { return (void)body, 0; }

EXPORT int fmi3GetFloat64(void* body, const uint32_t references[], size_t count, double values[], size_t size) {
  if (count != size) return 3;
  for (size_t i = 0; i < count; ++i) {
    if (references[i] > 12) return 3;
    values[i] = ((Body*)body)->value[references[i]];
  }
  return 0;
}
EXPORT int fmi3SetFloat64(void* body, const uint32_t references[], size_t count, const double values[], size_t size) {
  if (count != size) return 3;
  for (size_t i = 0; i < count; ++i) {
    if (references[i] > 5) return 3;
    ((Body*)body)->value[references[i]] = values[i];
  }
  return 0;
}

EXPORT int fmi3DoStep(void* body, double time, double step, bool final, bool* event, bool* terminate, bool* early,
                      double* last) {
  double* v = ((Body*)body)->value;
  const double decay = exp(-DAMPING / MASS * step);
  (void)final;
  for (int i = 0; i < 3; ++i) {
    const double fastest = (v[i] + v[3 + i]) / DAMPING, excess = v[6 + i] - fastest;
    v[9 + i] += fastest * step + excess * (1.0 - decay) * MASS / DAMPING;
    v[6 + i] = fastest + excess * decay;
  }
  *event = *terminate = *early = false;
  *last = v[12] = time + step;
  return 0;
}
