/* A host in C99: an own mesh, felt with a simulated device, in 60 lines. A hand pushes the tool down onto a
 * pyramid that moves to the side. The program prints the state 30 times a second and stops when the wall pushes back.
 * A device of your own is a struct of functions: EnamelDevice in enamel.h.
 */
#define _POSIX_C_SOURCE 199309L /* nanosleep() */
#include <enamel/c/enamel.h>
#include <stdio.h>
#include <time.h>

static const double kVertices[] = {-0.02, -0.02, -0.01, 0.02,  -0.02, -0.01, 0.02, 0.02,
                                   -0.01, -0.02, 0.02,  -0.01, 0.0,   0.0,   0.0}; /* m */
static const int32_t kTriangles[] = {0, 2, 1, 0, 3, 2, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};

static int fail(EnamelSession* session, const char* what) {
  char text[512] = "";
  EnamelMessage message = {text, sizeof text};
  enamel_message(session, message);
  fprintf(stderr, "c_host: %s: %s\n", what, text);
  enamel_session_destroy(session);
  return 1;
}

int main(void) {
  char why[512] = "";
  EnamelMessage message = {why, sizeof why};
  EnamelPose start = {{0.0, 0.0, 2e-3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  EnamelSessionDef def;
  EnamelSession* session;
  enamel_session_defaults(&def); /* the nominal TAU, no obstacles, position control at 1 kHz */
  def.start = &start;
  if (enamel_session_create(&def, &session, message) != ENAMEL_OK) return fprintf(stderr, "c_host: %s\n", why), 1;

  EnamelObstacleDef pyramid;
  EnamelObstacle id;
  enamel_obstacle_defaults(&pyramid);
  pyramid.name = "pyramid";
  pyramid.shape = ENAMEL_MESH;
  pyramid.vertices = kVertices;
  pyramid.vertex_count = sizeof kVertices / sizeof *kVertices / 3;
  pyramid.triangles = kTriangles;
  pyramid.triangle_count = sizeof kTriangles / sizeof *kTriangles / 3;
  if (enamel_add(session, &pyramid, &id) != ENAMEL_OK) return fail(session, "add");
  if (enamel_start_virtual(session, NULL, NULL) != ENAMEL_OK)
    return fail(session, "start"); /* or enamel_start_device */

  EnamelSnapshot now = {.size = sizeof now};
  for (int frame = 0; frame < 3000 && (now.contact_count == 0 || now.wrench[2] < 0.5);
       ++frame) { /* the graphics thread */
    const struct timespec pause = {0, 33000000};
    EnamelPose place = {{1e-4 * frame, 0.0, 0.0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    nanosleep(&pause, NULL);
    if (enamel_move(session, id, &place, NULL) != ENAMEL_OK) return fail(session, "move");
    if (enamel_snapshot(session, &now) != ENAMEL_OK) return fail(session, "snapshot");
    if (now.fault != 0) enamel_reset(session); /* a late tick on a busy machine; a real program asks the person first */
    printf("tick %6llu  z %6.3f mm  %d contacts  %5.2f N\n", (unsigned long long)now.tick, 1e3 * now.position[2],
           (int)now.contact_count, now.wrench[2]);
  }
  enamel_session_destroy(session); /* ramps out and stops */
  return now.contact_count > 0 && now.wrench[2] >= 0.5 ? 0 : 1;
}
