// The modes that position control uses at a pose, for an analysis of its closed loop.
#pragma once

#include "enamel/render/position_control.hpp"
#include "render/predicted_modes.hpp"

namespace enamel {

/// Numbers of PushObserver::describe(), and the axes of the modes.
struct ControlledModes {
  ModeData data;
  JointVector unseen;  ///< of each joint, as PushObserver()
  int count;
  double handStep;  ///< F_h, N
  ModeAxes axes;
  Lane inertia, step, tremor;  ///< as PushObserver::State
  Lane readingVariance, largestStep, joint;
};

/// Return the modes of a renderer after its first tick. Realtime: yes.
ControlledModes modesOf(const PositionControlRenderer& renderer) noexcept;

}  // namespace enamel
