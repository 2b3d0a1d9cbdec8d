// The template, a good plugin, with one defect; the macro selects it.
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "enamel/plugin/abi.h"  // declares the template's good_plugin(): see tests/CMakeLists.txt

#undef enamel_plugin
extern "C" ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void);

#ifdef BAD_SYMBOL
extern "C" double a_function_that_nobody_has(double);
#endif

namespace {

const EnamelPlugin& good() { return *good_plugin(); }

[[maybe_unused]] int32_t badStep(void* self, const EnamelTickInput* input, EnamelTickOutput* output) {
  const int32_t result = good().step(self, input, output);
#if defined(BAD_THROW)
  if (output->mode == ENAMEL_CONTACT) throw std::runtime_error("thrown in a tick");
#elif defined(BAD_ALLOCATION)
  if (result == ENAMEL_OK) {
    volatile char* memory = static_cast<char*>(std::malloc(100));
    memory[0] = 1;
    std::free(const_cast<char*>(memory));
  }
#elif defined(BAD_NAN)
  if (output->mode == ENAMEL_CONTACT) {
    output->answer = ENAMEL_TORQUE;
    output->torque[3] = std::nan("");
    for (double& w : output->wrench) w = 0.0;
  }
#elif defined(BAD_LIMIT)
  if (output->mode == ENAMEL_CONTACT) {
    output->answer = ENAMEL_TORQUE;
    output->torque[2] = 2.0 * input->max_torque[2];
    for (double& w : output->wrench) w = 0.0;
  }
#elif defined(BAD_CRASH)
  if (output->mode == ENAMEL_CONTACT) std::abort();
#elif defined(BAD_SYMBOL)
  output->normal_force = a_function_that_nobody_has(0.0);
#elif defined(BAD_COUNTER)
  static double counter = 0.0;  // state that cannot be saved
  output->normal_force = counter += 1e-3;
#elif defined(BAD_LATE)
  static double contacts = 0.0;  // the same, visible only in contact
  if (output->mode == ENAMEL_CONTACT) output->normal_force += contacts += 1e-3;
#endif
  return result;
}

[[maybe_unused]] void badReset(void*) {}

[[maybe_unused]] int32_t badActivate(void*, double, EnamelMessage message) {
  if (message.size > 8) __builtin_memcpy(message.text, "no brain", 9);
  return ENAMEL_BAD_CONFIGURATION;
}

[[maybe_unused]] int32_t carelessActivate(void* self, double period, EnamelMessage message) {
  good().deactivate(self);
  return good().activate(self, period, message);
}

EnamelPlugin table() {
  EnamelPlugin t = good();
#if defined(BAD_VERSION)
  t.abi_version = ENAMEL_ABI_VERSION + 1;
#elif defined(BAD_SIZE)
  t.input_size -= 8;
#elif defined(BAD_TABLE)
  t.load_state = nullptr;
#elif defined(BAD_RESET)
  t.reset = badReset;
#elif defined(BAD_ACTIVATE)
  t.activate = badActivate;
#elif defined(BAD_DOUBLE)
  t.activate = carelessActivate;
#else
  t.step = badStep;
#endif
  return t;
}

}  // namespace

const EnamelPlugin* enamel_plugin(void) {
  static const EnamelPlugin plugin = table();
  return &plugin;
}
