// Parts of the first trial that judge samples. Each throws Surprise. Private to the library.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "enamel/core/types.hpp"
#include "enamel/render/guard_reason.hpp"

namespace enamel::trial {

/// The end of a trial, with the expected and the measured quantity.
struct Surprise {
  std::string what;
};

/// One tick. Rotations are vectors relative to the first tick: axis times angle.
struct Sample {
  double time = 0.0;                                 // s, of the measurement
  Vec6 place = Vec6::Zero(), wrench = Vec6::Zero();  // m and rad; above gravity, N and N m
  Vec6 rates = Vec6::Zero();                         // m/s, rad/s
  bool isNew = false, isEnabled = true;
  std::uint32_t buttons = 0, conditions = 0;
  double gripper = 0.0, depth = 0.0;  // rad; m, in the wall z = 0
  bool hasGripper = false;
};

/// Directions 0 to 2 are translations along x, y, z, and 3 to 5 turns about them.
constexpr bool isTurn(int direction) noexcept { return direction > 2; }

/// Return a direction in the words of a request: "to the right", "so that its front end goes up".
const char* wordsOf(int direction) noexcept;

/// Return the size of a motion or a force with its unit.
std::string lengthText(double size, bool isTurn);
std::string forceText(double size, bool isTurn);

/// Fill in a line as printf() does.
std::string text(const char* format, double a, double b = 0.0, double c = 0.0);

/// Require that no fault of the guard came, and that the device reported nothing about itself. `needsForces`: and that
/// it was enabled.
void requireNoFault(GuardReason fault, const std::vector<Sample>& samples, bool needsForces);

/// Require that a motion is mainly along a direction, forwards.
void requireAlong(const Vec3& way, int direction, const std::string& what);

/// Require that the rates of the samples add up to the way along their directions.
void requireRates(const std::vector<Sample>& samples, bool isTurn, double period);

struct Fit {
  double mass = 0.0;  // kg or kg m^2
  int delay = 0;      // ticks
};

/// Fit m x'' = F - b x' - k x - f to `count` samples from `first`: damping and stiffness of the hand, friction of the
/// device, integrated twice. F is delayed; f acts once the handle moved by `step`. Choose the delay with the smallest
/// residual. The motion after the push separates the force from the friction.
Fit fit(const std::vector<Sample>& samples, std::size_t first, std::size_t count, int direction, double step,
        const Vec6& drift, double period);

}  // namespace enamel::trial
