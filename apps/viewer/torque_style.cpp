#include "torque_style.hpp"

#include <algorithm>

#include "colours/palette.hpp"

namespace enamel::viewer {

TorqueStyle::TorqueStyle(const Mechanism& mechanism) : joints(mechanism.joints()) {
  const JointVector& limits = mechanism.limits().effort;
  const std::vector<Bar> bars = mechanism.bars(mechanism.home().pose);
  int chains = 0;
  for (const Bar& bar : bars) chains = std::max(chains, bar.chain + 1);
  perChain = chains > 0 && joints % chains == 0 && joints <= 2 * chains ? joints / chains : 0;
  // Joints without chains are axes; some of them may be rotary.
  shares = chains == 0 || (limits.array() != limits[0]).any();
  limit = shares ? 100.0 : limits[0];
  factor = shares ? JointVector(100.0 * limits.cwiseInverse()) : JointVector::Ones(joints);
}

unsigned TorqueStyle::colourOf(int joint) const { return kJoints[(perChain > 0 ? joint / perChain : joint) % 3]; }

bool TorqueStyle::dashed(int joint) const { return perChain > 0 ? joint % perChain > 0 : joint / 3 % 2 > 0; }

}  // namespace enamel::viewer
