// Guides: lines, surfaces and regions that a soft force leads the tool to (virtual fixtures).
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "enamel/collision/shapes.hpp"

namespace enamel {

/// All points within `radius` of a line through `points` (its own frame, m). One point gives a ball. Radius 0: the
/// line.
struct Polyline {
  std::vector<Vec3> points;
  double radius = 0.0;  ///< m
};

/// The plane z = 0 of its frame.
struct Plane {};

/// Where the TCP shall be: on a line or within its radius, on a plane, in a box. For a half space: above it, at z >= 0.
using GuideShape = std::variant<Polyline, Plane, HalfSpace, Box>;

/// A force on the TCP towards the nearest point of a shape. Guidance (enamel/render/guidance.hpp) has its law.
struct Guide {
  GuideShape shape;
  Pose pose;               ///< of the shape's frame in W
  double stiffness = 0.0;  ///< force at the hand per distance in the scene, N/m; 0: no force
  double maxForce = 0.0;   ///< at the hand, N
};

/// Largest number of guides of a scene and of points of a line, and largest values of a guide, N/m and N.
inline constexpr std::size_t kMaxGuides = 8, kMaxGuidePoints = 64;
inline constexpr double kLargestGuideStiffness = 1e5, kLargestGuideForce = 100.0;

/// Throw Error, beginning with `name`, for:
/// - a stiffness outside 0 to kLargestGuideStiffness, a force outside 0 to kLargestGuideForce;
/// - a pose that is not finite or not a rotation within 1e-6, a point farther than 100 m (kFarthest);
/// - a line without points, with more than kMaxGuidePoints, or with two equal ones in a row;
/// - a radius that is negative or not finite, a box with a size that is not positive and finite.
/// Realtime: no.
void checkGuide(const Guide& guide, const std::string& name);

/// How far a point is from its place. All in W.
struct GuideError {
  Vec3 offset = Vec3::Zero();  ///< e: from the nearest point of the shape to the point, m
  Vec3 rate = Vec3::Zero();    ///< e': its rate at the velocity of the point, m/s
  bool isRegion = false;       ///< the shape has an inside: the guide pushes back, and does not hold
};

/// Return the error of a point (W, m) that moves at `velocity` (W, m/s). Realtime: yes.
GuideError errorOf(const Guide& guide, const Vec3& point, const Vec3& velocity) noexcept;

}  // namespace enamel
