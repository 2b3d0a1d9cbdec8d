// Plugins that fail as soon as they are asked for their table: FAIL_BY_CRASH ends the process, else an exception.
#include <cstdlib>
#include <stdexcept>

#include "enamel/plugin/abi.h"

extern "C" ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void) {
#ifdef FAIL_BY_CRASH
  std::abort();
#else
  throw std::runtime_error("thrown while it was loaded");
#endif
}
