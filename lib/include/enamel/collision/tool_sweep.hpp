// The first touch of a moving tool with a scene.
#pragma once

#include "enamel/collision/contacts.hpp"

namespace enamel {

/// Result of sweepTool().
struct ToolSweep {
  Status status = Status::ok;  ///< notFinite: a pose; outOfRange: farther than kFarthestTool; or as checkTool()
  bool hit = false;
  double time = 1.0;  ///< time of the first touch, as SweepHit::time
  Contact contact;    ///< at the first touch; its point is the obstacle's, its gap is 0
};

/// Find the first touch of the tool between two poses, with all obstacles at rest. Of equal times the first in the
/// scene counts, then the first in the tool. The ends of the parts move on straight lines.
///
/// Spheres are as accurate as in sweepSphere(), capsules as in sweepCapsule(). Against a solid the gap at the touch is
/// up to 0.001 cells. `cache` as in findContacts(). Realtime: yes.
ToolSweep sweepTool(const Scene& scene, const Tool& tool, const Pose& from, const Pose& to, ToolCache* cache) noexcept;

}  // namespace enamel
