#include "bad_inputs.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

#include "core/message.hpp"

namespace enamel::conformance {
namespace {

constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300,
                           1e300};

}  // namespace

void BadInputs::offer(const std::string& what, const EnamelTickInput& bad, bool mustRefuse) {
  const std::int32_t result = instance_.step(bad);
  demand(!mustRefuse || result != ENAMEL_OK, what + " was accepted");
  requireDefined(instance_.output, bad, result != ENAMEL_OK, what);
  if (result == ENAMEL_OK) {
    instance_.load(before_);
    return;
  }
  demand(instance_.output.mode == ENAMEL_FAULT, what + ": the mode is not fault");
  demand(instance_.save() == before_, what + ": the state has changed");
}

void BadInputs::offerNumbers() {
  constexpr std::size_t kNumbers = offsetof(EnamelTickInput, joint_count) / sizeof(double);
  const auto joints = static_cast<std::size_t>(good_.joint_count);
  for (std::size_t k = 0; k < kNumbers; ++k)
    for (const double value : kBad) {
      EnamelTickInput bad = good_;
      std::memcpy(reinterpret_cast<char*>(&bad) + k * sizeof(double), &value, sizeof value);
      const bool time = k == 0, angle = k >= 1 && k < 1 + joints;
      offer("number " + std::to_string(k) + " = " + formatNumber(value), bad,
            (angle || time) && !(std::isfinite(value) && time));
    }
}

void BadInputs::offerSurfaces() {
  for (const double value : kBad) {
    EnamelTickInput bad = good_;
    bad.contacts[0].gap = value;
    offer("gap = " + formatNumber(value), bad, std::isnan(value));
  }
  for (double EnamelContact::*number : {&EnamelContact::stiffness, &EnamelContact::friction,
                                        &EnamelContact::sliding_friction, &EnamelContact::viscosity})
    for (const double value : kBad) {
      EnamelTickInput bad = good_;
      bad.contacts[0].*number = value;
      offer("a number of the surface = " + formatNumber(value), bad, false);
    }
}

void BadInputs::offerCounts() {
  for (const int count : {-1, ENAMEL_MAX_CONTACTS + 1, 1 << 30}) {
    EnamelTickInput bad = good_;
    bad.contact_count = count;
    offer("contact count " + std::to_string(count), bad, true);
  }
  for (const int count : {-1, 0, ENAMEL_MAX_JOINTS + 1, 1 << 30}) {
    EnamelTickInput bad = good_;
    bad.joint_count = count;
    offer("joint count " + std::to_string(count), bad, true);
  }
}

}  // namespace enamel::conformance
