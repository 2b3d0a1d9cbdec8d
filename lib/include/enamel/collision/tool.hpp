// What the person holds: capsules fixed to the platform.
#pragma once

#include <array>

#include "enamel/core/status.hpp"
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

/// The part of a tool that spins and cuts: a ball, or a cylinder with round ends.
struct Bur {
  int part = 0;         ///< of the tool
  double wear = 0.05;   ///< Archard's coefficient: the finer the grit, the smaller
  double turns = 2000;  ///< a second, when it spins
};

/// Farthest that an end may be from the TCP along an axis, and largest radius, m. What is larger was measured in
/// millimetres, and would sweep through whole scenes in a tick.
inline constexpr double kLargestTool = 1.0;

/// Whether queries can work with a tool: ok; notFinite; outOfRange for a count outside 0 to kMaxToolParts, an end
/// farther away than kLargestTool, a radius outside 0 to kLargestTool. Realtime: yes.
[[nodiscard]] Status checkTool(const Tool& tool) noexcept;

}  // namespace enamel
