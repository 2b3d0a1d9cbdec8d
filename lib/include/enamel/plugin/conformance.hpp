// Does a plugin keep the contract of abi.h? For authors, before a host finds out.
#pragma once

#include <functional>
#include <string>

#include "enamel/plugin/host.hpp"

namespace enamel {

/// One thing that the contract asks for, and what the plugin did.
struct ConformanceResult {
  enum class Verdict { passed, failed, notChecked };
  std::string what;
  Verdict verdict;
  std::string detail;  ///< why it failed or was not checked, or a number
};

struct ConformanceOptions {
  double period = 1e-3;  ///< s
  int ticks = 2000;      ///< of the path into a wall and out again
  /// Allocations and releases of the process so far; empty: allocation in a tick is not checked.
  std::function<long()> allocationCount;
};

/// Runs every check and reports each one when it is done, so that a crash shows in which it happened. The plugin is
/// configured with `setup`; its device (or the text of one) also makes the path. Exceptions out of the plugin are
/// caught and reported. Returns whether nothing failed. Throws Error: the device of `setup` is unusable. Realtime: no.
bool checkPlugin(const std::shared_ptr<const PluginLibrary>& library, const PluginSetup& setup,
                 const ConformanceOptions& options, const std::function<void(const ConformanceResult&)>& report);

}  // namespace enamel
