/* A host in C99: an own mesh as an obstacle, a push on the virtual device, and the bits of the torques of every
 * tick. The other clients (push.py, Push.cs, tests/unit/c_interface.cpp) print the same. */
#include <enamel/c/enamel.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* A box of 40 x 40 x 10 mm below z = 0. */
static const double kVertices[] = {-0.02, -0.02, -0.01, 0.02, -0.02, -0.01, 0.02, 0.02, -0.01, -0.02, 0.02, -0.01,
                                   -0.02, -0.02, 0.0,   0.02, -0.02, 0.0,   0.02, 0.02, 0.0,   -0.02, 0.02, 0.0};
static const int32_t kTriangles[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                     1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};

int main(void) {
  EnamelSessionDef def;
  EnamelSession* session = NULL;
  EnamelVirtualDevice* device = NULL;
  EnamelPose start = {{0.0, 0.0, 0.5e-3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  char text[256] = "";
  EnamelMessage message;
  EnamelObstacleDef plate;
  EnamelObstacle id;
  int i, j;
  message.text = text;
  message.size = sizeof text;
  enamel_session_defaults(&def);
  def.start = &start;
  if (enamel_session_create(&def, &session, message) != ENAMEL_OK) {
    fprintf(stderr, "%s\n", text);
    return 1;
  }
  enamel_obstacle_defaults(&plate);
  plate.name = "plate";
  plate.shape = ENAMEL_MESH;
  plate.vertices = kVertices;
  plate.vertex_count = 8;
  plate.triangles = kTriangles;
  plate.triangle_count = 12;
  if (enamel_add(session, &plate, &id) != ENAMEL_OK || enamel_virtual_create(session, &device) != ENAMEL_OK) {
    enamel_message(session, message);
    fprintf(stderr, "%s\n", text);
    return 1;
  }
  for (i = 0; i < 300; ++i) {
    EnamelMeasurement measurement;
    EnamelPose pose;
    double effort[ENAMEL_MAX_JOINTS] = {0}, twist[6], wrench[6];
    measurement.size = sizeof measurement;
    if (enamel_virtual_measure(device, &measurement) != ENAMEL_OK) return 1;
    if (enamel_tick(session, &measurement, effort) != ENAMEL_OK) return 1;
    enamel_virtual_state(device, &pose, twist);
    for (j = 0; j < 6; ++j) wrench[j] = (j < 3 ? -5.0 : -0.02) * twist[j];
    wrench[2] -= 2.0;
    enamel_virtual_actuate(device, effort);
    if (enamel_virtual_advance(device, wrench) != ENAMEL_OK) return 1;
    for (j = 0; j < 6; ++j) {
      uint64_t bits;
      memcpy(&bits, &effort[j], sizeof bits);
      printf("%016" PRIx64 "%c", bits, j < 5 ? ' ' : '\n');
    }
  }
  enamel_virtual_destroy(device);
  enamel_session_destroy(session);
  return 0;
}
