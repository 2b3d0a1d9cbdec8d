/* A host in plain C. It loads a renderer plugin and pushes a free mass of 0.3 kg against the wall z = 0 with 12 N, at
 * 1 kHz. The host computes contact, motion and loop; the plugin renders the wall. The device is Cartesian: its three
 * joints are x, y and z, and their torques are forces. Its Jacobian is therefore the identity. A real host measures
 * and sends its own values.
 *
 *   plugin_host PLUGIN.so cartesian-3.toml
 */
#include <dlfcn.h>
#include <enamel/plugin/abi.h>
#include <math.h>
#include <stdio.h>

static const double kMass = 0.3, kDamping = 4.0, kPush = 12.0, kPeriod = 1e-3, kLargestForce = 30.0; /* SI */

static int fail(const char* what, const char* why) {
  fprintf(stderr, "plugin_host: %s: %s\n", what, why);
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage", "plugin_host PLUGIN.so DEVICE.toml");
  void* library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) return fail("dlopen()", dlerror());
  const EnamelPlugin* (*entry)(void);
  *(void**)&entry = dlsym(library, ENAMEL_PLUGIN_SYMBOL);
  if (entry == NULL) return fail(argv[1], "does not export " ENAMEL_PLUGIN_SYMBOL "()");
  const EnamelPlugin* plugin = entry();
  if (plugin->abi_version != ENAMEL_ABI_VERSION || plugin->plugin_size != sizeof(EnamelPlugin) ||
      plugin->input_size != sizeof(EnamelTickInput) || plugin->output_size != sizeof(EnamelTickOutput))
    return fail(argv[1], "is made for another version of the boundary");
  char why[256] = "";
  const EnamelMessage message = {why, sizeof why};
  const EnamelConfiguration configuration = {.device_path = argv[2]};
  void* wall = plugin->create();
  if (wall == NULL) return fail(argv[1], "create() failed");
  if (plugin->configure(wall, &configuration, message) != ENAMEL_OK) return fail("configure()", why);
  if (plugin->activate(wall, kPeriod, message) != ENAMEL_OK) return fail("activate()", why);

  /* Ticks. */
  double z = 0.0, v = 0.0, force = 0.0, deepest = 0.0;
  int tick, axis, failed = 0;
  for (tick = 0; tick < 1000 && !failed; ++tick) {
    EnamelTickInput input = {0};
    EnamelTickOutput output;
    input.time = kPeriod * (tick + 1);
    input.joint_count = 3;
    input.q[2] = input.position[2] = z;
    input.rates[2] = input.twist[2] = v;
    input.rotation[0] = input.rotation[4] = input.rotation[8] = 1.0;
    for (axis = 0; axis < 3; ++axis) {
      input.jacobian[axis][axis] = input.inverse[axis][axis] = 1.0;
      input.inertia[axis][axis] = kMass, input.max_torque[axis] = kLargestForce;
    }
    input.applied[2] = force;
    input.applied_known = 1;
    input.contact_count = 1;
    input.contacts[0].point[2] = z;
    input.contacts[0].normal[2] = 1.0;
    input.contacts[0].gap = z;
    input.contacts[0].stiffness = HUGE_VAL; /* rigid, without friction */
    input.contacts[0].triangle = input.contacts[0].feature_index = -1;
    failed = plugin->step(wall, &input, &output) != ENAMEL_OK;
    force = output.answer == ENAMEL_WRENCH ? output.wrench[2] : output.torque[2];
    if (force > kLargestForce) force = kLargestForce;
    v += kPeriod * (force - kPush - kDamping * v) / kMass;
    z += kPeriod * v;
    if (z < deepest) deepest = z;
    if (tick % 100 == 99) printf("%.1f s: %7.3f mm deep, the wall pushes with %6.2f N\n", input.time, -1e3 * z, force);
  }
  plugin->deactivate(wall);
  plugin->destroy(wall);
  dlclose(library);
  if (failed) return fail("step()", "the plugin reported a fault");
  printf("%s: deepest %.3f mm under %.0f N, at rest %.3f mm\n", argv[1], -1e3 * deepest, kPush, -1e3 * z);
  return 0;
}
