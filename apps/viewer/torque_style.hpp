// Style of the chart of joint torques.
#pragma once

#include "enamel/device/mechanism.hpp"

namespace enamel::viewer {

/// Units, colours and strokes of the torques by joint.
struct TorqueStyle {
  explicit TorqueStyle(const Mechanism& mechanism);

  int joints;
  int perChain;        ///< joints of a chain, which share a colour; 0: each joint has its own
  bool shares;         ///< in % of each joint's own limit if the limits or possibly the units differ; otherwise in N m
  double limit;        ///< in % or N m
  JointVector factor;  ///< from a torque to the shown value

  unsigned colourOf(int joint) const;
  bool dashed(int joint) const;
};

}  // namespace enamel::viewer
