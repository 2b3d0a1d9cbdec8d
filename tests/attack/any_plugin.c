/* A plugin with arbitrary description, results and outputs. It takes them from the bytes at ENAMEL_ATTACK_BYTES, an
 * environment variable with "ADDRESS SIZE" in this process. */
#include <enamel/plugin/abi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const unsigned char* bytes;
static size_t left;

static void take(void* to, size_t size) {
  const size_t some = size < left ? size : left;
  memset(to, 0, size);
  memcpy(to, bytes, some);
  bytes += some, left -= some;
}

static unsigned char any(void) {
  unsigned char value;
  take(&value, 1);
  return value;
}

static int32_t any_result(void) {
  int32_t result = any() % 16;
  if (result > ENAMEL_BAD_CONFIGURATION) result = ENAMEL_OK;
  if (any() % 16 == 0) take(&result, sizeof result);
  return result;
}

static char texts[3][300];
static const char* any_text(int i) {
  const size_t size = any();
  if (any() % 16 == 0) return NULL;
  take(texts[i], size);
  texts[i][size] = 0;
  return texts[i];
}

static const EnamelDescription* describe(void) {
  static EnamelDescription description;
  static const EnamelParameter parameter = {"key", "0", "meaning"};
  if (any() % 16 == 0) return NULL;
  description.name = any() % 4 == 0 ? any_text(0) : "any";
  description.version = any() % 4 == 0 ? any_text(1) : "1";
  description.summary = any() % 4 == 0 ? any_text(2) : "Any answer";
  description.parameters = any() % 8 == 0 ? NULL : &parameter;
  description.parameter_count = any() % 2;
  return &description;
}

static size_t state_bytes;
static void* create(void) {
  static int instance;
  state_bytes = any() % 16 == 0 ? 0 : 8u * any();
  if (any() % 32 == 0) take(&state_bytes, sizeof state_bytes);
  return any() % 16 == 0 ? NULL : &instance;
}

static int32_t say(EnamelMessage message) {
  if (message.text != NULL && any() % 2 == 0) take(message.text, message.size); /* possibly unterminated */
  return any_result();
}

static int32_t configure(void* self, const EnamelConfiguration* configuration, EnamelMessage message) {
  (void)self, (void)configuration;
  return say(message);
}

static int32_t activate(void* self, double period, EnamelMessage message) {
  (void)self, (void)period;
  return say(message);
}

static int32_t step(void* self, const EnamelTickInput* input, EnamelTickOutput* output) {
  (void)self, (void)input;
  if (any() % 2 == 0) {
    take(output, sizeof *output);
  } else {
    memset(output, 0, sizeof *output);
    output->torque[any() % ENAMEL_MAX_JOINTS] = 0.02 * (any() - 128);
    output->wrench[any() % 6] = 0.02 * (any() - 128);
    output->answer = any() % 3;
    output->mode = any() % 4;
  }
  return any_result();
}

static void nothing(void* self) { (void)self; }
static size_t state_size(const void* self) {
  (void)self;
  return state_bytes;
}
static void save_state(const void* self, void* state) {
  (void)self;
  take(state, state_bytes);
}
static void load_state(void* self, const void* state) { (void)self, (void)state; }

ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void) {
  static EnamelPlugin plugin;
  const char* where = getenv("ENAMEL_ATTACK_BYTES");
  void* address = NULL;
  size_t size = 0;
  if (where != NULL && sscanf(where, "%p %zu", &address, &size) == 2) bytes = address, left = size;
  plugin.abi_version = any() % 16 == 0 ? any() : any() % 8 == 0 ? ENAMEL_OLDEST_ABI_VERSION : ENAMEL_ABI_VERSION;
  plugin.plugin_size = sizeof(EnamelPlugin);
  plugin.input_size = sizeof(EnamelTickInput);
  plugin.output_size = sizeof(EnamelTickOutput);
  plugin.needs = any() % 4;
  plugin.reserved = any() % 32 == 0;
  plugin.describe = any() % 32 == 0 ? NULL : describe;
  plugin.create = create;
  plugin.configure = configure;
  plugin.activate = activate;
  plugin.step = step;
  plugin.reset = plugin.deactivate = plugin.destroy = nothing;
  plugin.state_size = state_size;
  plugin.save_state = save_state;
  plugin.load_state = load_state;
  return any() % 32 == 0 ? NULL : &plugin;
}
