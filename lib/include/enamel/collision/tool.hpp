// What the person holds: capsules fixed to the platform.
#pragma once

#include <array>

#include "enamel/core/types.hpp"

namespace enamel {

/// Capsule fixed to the platform frame P: a sphere where both ends are the same, a point where the radius is 0.
struct ToolPart {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis, in P, m
  double radius = 0.0;                      ///< m
};

inline constexpr int kMaxToolParts = 8;

/// Compound of capsules; by default one point at the TCP.
struct Tool {
  std::array<ToolPart, kMaxToolParts> parts{};
  int count = 1;
};

}  // namespace enamel
