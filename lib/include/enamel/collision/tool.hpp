// The tool that the person holds: capsules fixed to the platform.
#pragma once

#include <array>
#include <limits>
#include <string>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// A capsule fixed to the platform frame P. It is a sphere if both ends are equal, a point if the radius is also 0.
struct ToolPart {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis, in P, m
  double radius = 0.0;                      ///< m
};

inline constexpr int kMaxToolParts = 8;

/// A compound of capsules. Default: one point at the TCP.
struct Tool {
  std::array<ToolPart, kMaxToolParts> parts{};
  int count = 1;
  int head = 1;  ///< number of parts, from Bur::part on, that spin together as a bur
};

/// Parts of a tool with successive numbers. Default: none.
struct PartRange {
  int first = -1, count = 0;
  bool has(int part) const noexcept { return part >= first && part < first + count; }
};

/// The head of a tool, which spins and cuts: Tool::head parts.
struct Bur {
  int part = 0;         ///< number of its first part
  double wear = 0.05;   ///< Archard's coefficient; finer grit has smaller values
  double turns = 2000;  ///< turns per second while it spins without a load
  /// Torque of the motor at rest, N m. It falls linearly to 0 at `turns`. Infinite: the speed does not change.
  double torque = std::numeric_limits<double>::infinity();
  double inertia = 1e-8;  ///< of rotor and bur, kg m^2
  double drag = 0.3;      ///< tangential over normal cutting force: the load of the motor
  double runOut = 0.0;    ///< distance of the head's axis from the axis of rotation, m
  int blades = 0;         ///< 0: grit
  /// Give of the shaft that carries the head, m/N (0: rigid, no chatter), its natural frequency, Hz, and damping ratio.
  double shaftCompliance = 0.0, shaftFrequency = 1000.0, shaftDamping = 0.05;
};

/// Largest distance of an end from the TCP along an axis, and largest radius, m. Larger values are probably
/// millimetres, and such a tool would sweep through whole scenes in one tick.
inline constexpr double kLargestTool = 1.0;

/// Return a dental tool by its name. Its tip is at the TCP, its shaft is along z of P. Its first parts, from 0 on, are
/// the head, also of a Bur. D is the largest diameter of the head in 0.1 mm (three digits, as in ISO 6360), 003 to 100.
/// L is the length of the head in 0.1 mm (three digits), at least D.
/// - "round-D": a ball.
/// - "cylinder-D-L": a cylinder with a round end.
/// - "flat-D-L": a cylinder with a flat end.
/// - "cone-D-L-T": a cone with a round end of the diameter T in 0.1 mm (three digits, below D).
/// - "flame-D-L": a flame, whose side is an arc.
/// - "bur-245": a cylinder with round ends in place of the pear of a bur 245.
/// - "cpi-probe": the WHO probe, a ball of 0.5 mm on a thin rod.
/// - "explorer": a straight point in steps.
///
/// lib/docs/preparation.md shows all dimensions, their sources, and what is approximate. Throws Error for another name.
/// Realtime: no.
Tool toolOf(const std::string& name);

/// Return whether queries accept a tool. Statuses: ok; notFinite; outOfRange. outOfRange means a count outside 0 to
/// kMaxToolParts, an end farther away than kLargestTool, or a radius outside 0 to kLargestTool. Realtime: yes.
[[nodiscard]] Status checkTool(const Tool& tool) noexcept;

}  // namespace enamel
