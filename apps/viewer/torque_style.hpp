// How the torques of a mechanism's joints are charted.
#pragma once

#include "enamel/device/mechanism.hpp"

namespace enamel::viewer {

/// Units, colours and strokes of the torques, joint by joint.
struct TorqueStyle {
  explicit TorqueStyle(const Mechanism& mechanism);

  int joints;
  int perChain;        ///< joints of a chain, which share a colour; 0: every joint for itself
  bool shares;         ///< in % of each joint's own limit: where the limits, or maybe their units, differ; else N m
  double limit;        ///< 100 %, or N m
  JointVector factor;  ///< of a torque, to what is shown

  unsigned colourOf(int joint) const;
  bool dashed(int joint) const;
};

}  // namespace enamel::viewer
