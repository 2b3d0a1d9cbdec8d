// The contacts of a tool with a scene: what a haptic tick asks of the collision module.
#pragma once

#include <vector>

#include "enamel/collision/contact.hpp"
#include "enamel/collision/scene.hpp"
#include "enamel/collision/tool.hpp"
#include "enamel/core/status.hpp"

namespace enamel {

namespace kernel {
struct PartCache;
}

/// What a tool remembers of its last tick in a scene. Made by makeToolCache(), outside the ticks; not shared between
/// threads. Copying one allocates, assigning to one for the same scene and tool does not; an empty one, or one that was
/// moved from, helps no query.
class ToolCache {
 public:
  ToolCache();
  ToolCache(const ToolCache& other);
  ToolCache(ToolCache&& other) noexcept;
  ToolCache& operator=(const ToolCache& other);
  ToolCache& operator=(ToolCache&& other) noexcept;
  ~ToolCache();

 private:
  friend struct kernel::PartCache;
  friend ToolCache makeToolCache(const Scene& scene, const Tool& tool);
  std::vector<kernel::PartCache> parts_;  // one for each part and obstacle
};

/// Cache for `tool` in `scene` as it is now: 19 KB for each part and obstacle. Realtime: no.
ToolCache makeToolCache(const Scene& scene, const Tool& tool);

/// All contacts whose gap is at most `margin`, the deepest first (then by obstacle), at most kMaxContacts.
/// A sphere at p touches an obstacle at every local minimum of the distance |p - x| over its surface, one for each
/// direction within 15 deg; inside an obstacle at the nearest surface point only. A capsule touches with its two ends
/// and, where its signed distance is below theirs by more than 1e-9 m, with one point of its axis between them: the
/// deepest one in an analytic shape; the one nearest to a mesh, and only while both ends are outside of it. The
/// obstacle's velocity is v + w x r. `cache` may be null and must else come from makeToolCache() of this scene and
/// tool; the contacts are the same (with meshes whose sign is defined: signedDistance()). notFinite: a pose or the
/// margin is not finite; no contacts then. Realtime: yes. Threads: const scene, own cache.
Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept;

/// The contact of smallest gap, near or far, among equals the first of the scene: the first of findContacts() where its
/// gap is within the margin. For a scene without surfaces or a pose that is not finite the gap is kNoLimit.
/// Realtime: yes. Threads: as findContacts().
Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept;

}  // namespace enamel
