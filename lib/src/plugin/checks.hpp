// The parts that the conformance suites of renderers and drivers share.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "enamel/core/error.hpp"
#include "enamel/plugin/conformance.hpp"

namespace enamel::conformance {

/// Thrown by a failing check.
struct Failure {
  std::string reason;
};

inline void demand(bool condition, const std::string& reason) {
  if (!condition) throw Failure{reason};
}

/// Return the name of a result of the C interface.
inline std::string nameOf(std::int32_t result) {
  constexpr const char* names[] = {"ok",           "not finite", "unreachable", "singular",    "not converged",
                                   "out of range", "stale",      "inactive",    "wrong order", "bad configuration"};
  return result >= 0 && result < 10 ? names[result] : "unknown code " + std::to_string(result);
}

/// A check: a member function that returns a detail to report, or throws Failure.
template <typename Checks>
struct Check {
  const char* what;
  std::string (Checks::*run)();
};

/// Runs checks, and reports each one when it is done.
template <typename Checks>
class Suite {
 public:
  Suite(Checks& checks, const std::function<void(const ConformanceResult&)>& report)
      : checks_(checks), report_(report) {}

  /// Return whether no check has failed so far.
  bool allPassed() const noexcept { return allPassed_; }

  bool run(const Check<Checks>& check) {
    const ConformanceResult result = resultOf(check);
    allPassed_ = allPassed_ && result.verdict != ConformanceResult::Verdict::failed;
    report_(result);
    return allPassed_;
  }
  template <std::size_t n>
  bool run(const Check<Checks> (&list)[n]) {
    for (const Check<Checks>& check : list) run(check);
    return allPassed_;
  }
  /// Run a check that counts allocations, if this program does.
  void runCounted(const Check<Checks>& check, bool counts) {
    if (counts)
      run(check);
    else
      report_({check.what, ConformanceResult::Verdict::notChecked, "allocations are not counted in this program"});
  }

 private:
  ConformanceResult resultOf(const Check<Checks>& check) {
    using Verdict = ConformanceResult::Verdict;
    try {
      return {check.what, Verdict::passed, (checks_.*check.run)()};
    } catch (const Failure& failure) {
      return {check.what, Verdict::failed, failure.reason};
    } catch (const Error& error) {
      return {check.what, Verdict::failed, error.what()};
    } catch (const std::exception& error) {
      return {check.what, Verdict::failed, std::string("an exception crossed the boundary: ") + error.what()};
    } catch (...) {
      return {check.what, Verdict::failed, "an exception crossed the boundary"};
    }
  }

  Checks& checks_;
  const std::function<void(const ConformanceResult&)>& report_;
  bool allPassed_ = true;
};

}  // namespace enamel::conformance
