#include "instance.hpp"

#include <algorithm>
#include <cmath>

#include "core/message.hpp"

namespace enamel::conformance {

void requireDefined(const EnamelTickOutput& output, const EnamelTickInput& input, bool failed,
                    const std::string& when) {
  demand(output.answer == ENAMEL_TORQUE || output.answer == ENAMEL_WRENCH,
         when + ": the answer is " + std::to_string(output.answer) + ", must be torque or wrench");
  for (int i = 0; i < kMaxJoints; ++i) {
    const std::string name = when + ": torque " + std::to_string(i + 1);
    const double limit = i < input.joint_count && std::isfinite(input.max_torque[i]) ? input.max_torque[i] : 0.0;
    demand(std::isfinite(output.torque[i]), name + " is not finite");
    demand(std::abs(output.torque[i]) <= (failed ? 0.0 : std::max(0.0, limit)),
           name + " is " + formatNumber(output.torque[i]) + " N m, the limit is " + formatNumber(failed ? 0.0 : limit) +
               " N m");
    demand(output.answer == ENAMEL_TORQUE || output.torque[i] == 0.0, name + " must be 0 if the answer is a wrench");
  }
  for (const double value : output.wrench) {
    demand(std::isfinite(value), when + ": the wrench is not finite");
    demand((output.answer == ENAMEL_WRENCH && !failed) || value == 0.0, when + ": the wrench is not zero");
  }
  demand(std::isfinite(output.normal_force), when + ": the normal force is not finite");
  demand(output.mode >= ENAMEL_FREE && output.mode <= ENAMEL_FAULT,
         when + ": the mode is " + std::to_string(output.mode));
  demand(output.saturated == 0 || output.saturated == 1, when + ": saturated is " + std::to_string(output.saturated));
}

bool same(const EnamelTickOutput& a, const EnamelTickOutput& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): bit by bit
}

}  // namespace enamel::conformance
