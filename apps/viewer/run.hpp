// The two loops of the viewer: a person's in a window, and a script's without a display.
#pragma once

#include "options.hpp"

namespace enamel::viewer {

/// Run in a window until it is closed, the script ends, or SIGINT or SIGTERM arrives; then write the report. SIGUSR1
/// writes a report of the next picture without ending. Return the signal that ended it, or 0. Throws Error; also if the
/// window is closed while the tool is in contact. `started`: start of the program in seconds of the steady clock.
int runInWindow(const Options& options, double started);

/// Run a script without a display in simulated time: the same script gives the same pictures. Otherwise as
/// runInWindow().
int runHeadless(const Options& options, double started);

/// Return the seconds of the steady clock.
double steadySeconds();

}  // namespace enamel::viewer
