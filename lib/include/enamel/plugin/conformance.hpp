// Tests of the contract of abi.h, for authors of plugins.
#pragma once

#include <functional>
#include <string>

#include "enamel/plugin/host.hpp"

namespace enamel {

/// A requirement of the contract, and the result of its check.
struct ConformanceResult {
  enum class Verdict { passed, failed, notChecked };
  std::string what;
  Verdict verdict;
  std::string detail;  ///< why it failed or was not checked, or a number
};

struct ConformanceOptions {
  double period = 1e-3;  ///< s
  int ticks = 2000;      ///< on the path into a wall and out again
  /// Return the number of allocations and releases of this thread so far. Empty: allocations in a tick are not checked.
  std::function<long()> allocationCount;
};

/// Run every check, and report each one when it is done. After a crash the last report shows where it happened. The
/// plugin is configured with `setup`. The device of `setup` also defines the path. Exceptions from the plugin are
/// caught and reported. Return whether no check failed. Throws Error if the device of `setup` is unusable. Realtime:
/// no.
bool checkPlugin(const std::shared_ptr<const PluginLibrary>& library, const PluginSetup& setup,
                 const ConformanceOptions& options, const std::function<void(const ConformanceResult&)>& report);

}  // namespace enamel
