// When does a moving tool first touch a scene?
#pragma once

#include "enamel/collision/contacts.hpp"

namespace enamel {

/// First touch of a moving tool.
struct ToolSweep {
  Status status = Status::ok;  ///< notFinite: a pose; outOfRange: farther than kFarthestTool; checkTool()
  bool hit = false;
  double time = 1.0;  ///< of the first touch, as SweepHit::time
  Contact contact;    ///< there; the point is the obstacle's, the gap 0
};

/// First touch of the tool between two poses, with the obstacles at rest in theirs; of touches at the same time the
/// first of the scene, then of the tool. The ends of the parts move on straight lines; spheres are exact as in
/// sweepSphere(), capsules as in sweepCapsule(). `cache` as in findContacts(). Realtime: yes.
ToolSweep sweepTool(const Scene& scene, const Tool& tool, const Pose& from, const Pose& to, ToolCache* cache) noexcept;

}  // namespace enamel
