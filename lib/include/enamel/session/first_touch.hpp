// The first trial of a device: steps with small forces, each confirmed by a person. It stops at the first surprise.
#pragma once

#include <functional>
#include <string>

#include "enamel/session/open_device.hpp"

namespace enamel {

struct FirstTouchOptions {
  double rate = 1000.0;       ///< ticks per second, Hz
  double largestForce = 2.0;  ///< of the last pushes and of the walls, N; 0.5 to 10
  double moveTime = 3.0;      ///< for a motion by hand, s
  std::string recording;      ///< file for the ticks at the last wall; empty: none
  bool isSimulated = false;   ///< the device advances with actuate(): do not wait for the clock
};

struct FirstTouchResult {
  std::string surprise;     ///< empty: none. Otherwise what was expected and what was measured
  bool isComplete = false;  ///< false: a surprise, or the person did not confirm a step
  std::string report;       ///< one line a step, with the numbers
};

/// Try a device in this order; each step begins with a request that `ask` shows. `ask` returns false to end the trial.
///
/// - rest: rate, lost samples, time stamps and noise, without force;
/// - the person moves the handle to the right, up, and to the user: axes, signs and unit of the positions;
/// - pushes of 0.1 N, 0.5 N and the largest force along each axis, 60 ms long: axes, signs and unit of the forces,
///   apparent mass, delay;
/// - a wall of 300 N/m, then position control, in the middle of the workspace.
///
/// Pushes are compared with x'' = (F - b x') / m, delayed; b is the damping of the hand. The mass must be within a
/// factor of 4 of the device file, the delay within 2 ticks of the stated one. A fault of the guard is a surprise.
/// Throws Error as HapticLoop and Recorder, and for options outside their range. Realtime: no.
FirstTouchResult firstTouch(OpenedDevice& opened, const FirstTouchOptions& options,
                            const std::function<bool(const std::string& request)>& ask);

}  // namespace enamel
