// The two loops that drive a viewer: a person's in a window, a script's without a display.
#pragma once

#include "options.hpp"

namespace enamel::viewer {

/// Runs in a window until it is closed, the script ends, or SIGINT or SIGTERM comes, and then writes the report. After
/// SIGUSR1 it also writes one of the next picture, and goes on. Returns the signal that ended it, or 0. Throws Error;
/// also where the window is closed while the tool is in contact. `started`: seconds on the steady clock when the
/// program began.
int runInWindow(const Options& options, double started);

/// Runs a script without a display on simulated time: the same script gives the same pictures. Otherwise as above.
int runHeadless(const Options& options, double started);

/// Seconds on the steady clock.
double steadySeconds();

}  // namespace enamel::viewer
