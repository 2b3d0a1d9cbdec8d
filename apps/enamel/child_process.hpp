// Code that may throw, crash or hang, in a process of its own.
#pragma once

#include <functional>
#include <string>

namespace enamel::app {

struct ChildResult {
  std::string answer;   // what `work` returned
  std::string failure;  // why there is no answer: the message of an Error, or `what` and how it ended; else empty
};

/// Run `work` in a child process and return its answer. The child is ended after `seconds` of computing, and after
/// three times as long in all. `what` is the subject of a failure: "FILE: loading it" ... "ended in a crash (Aborted)".
/// Call it while this process has one thread. Throws Error: no process can be started.
ChildResult runInChild(const std::string& what, double seconds, const std::function<std::string()>& work);

}  // namespace enamel::app
