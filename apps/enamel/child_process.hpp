// Runs code that may throw, crash or hang in a separate process.
#pragma once

#include <functional>
#include <string>

namespace enamel::app {

struct ChildResult {
  std::string answer;   // return value of `work`
  std::string failure;  // empty on success; otherwise the message of an Error, or `what` and how it ended
};

/// Run `work` in a child process and return its answer. The child is killed after `seconds` of CPU time or three times
/// as much wall-clock time. `what` is the subject of a failure: "FILE: loading it" gives "FILE: loading it ended in a
/// crash (Aborted)". Call it while this process has one thread. Throws Error: no process can be started.
ChildResult runInChild(const std::string& what, double seconds, const std::function<std::string()>& work);

}  // namespace enamel::app
