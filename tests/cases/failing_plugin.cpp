// Plugins that fail as soon as the host requests their table; FAIL_BY_... selects the way.
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "enamel/plugin/abi.h"

#ifdef FAIL_BY_LOADING
namespace {
struct Crash {
  Crash() { std::abort(); }
} crash;
}  // namespace
#endif

extern "C" ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void) {
#if defined(FAIL_BY_CRASHING)
  std::abort();
#elif defined(FAIL_BY_HANGING)
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
#elif defined(FAIL_BY_EXITING)
  std::exit(0);
#elif defined(FAIL_BY_THROWING)
  throw std::runtime_error("thrown while it was loaded");
#else
  return nullptr;
#endif
}
