// Bad inputs for a plugin under test.
#pragma once

#include "instance.hpp"

namespace enamel::conformance {

/// Gives an instance bad inputs in place of a good one. It must answer each with a defined output. If it rejects one,
/// its state must not change. Every function throws Failure.
class BadInputs {
 public:
  BadInputs(Instance& instance, const EnamelTickInput& good)
      : instance_(instance), good_(good), before_(instance.save()) {}

  void offer(const std::string& what, const EnamelTickInput& bad, bool mustRefuse);
  /// Replace every number of the input in turn. A renderer may accept bad numbers that it does not use.
  void offerNumbers();
  void offerSurfaces();
  void offerCounts();

 private:
  Instance& instance_;
  const EnamelTickInput& good_;
  const std::vector<unsigned char> before_;
};

}  // namespace enamel::conformance
