// The contacts of a tool with a scene: what a haptic tick asks of the collision module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "enamel/collision/contact.hpp"
#include "enamel/collision/scene.hpp"
#include "enamel/collision/tool.hpp"
#include "enamel/core/status.hpp"

namespace enamel {

namespace kernel {
struct PartCache;
struct PartTrack;
}  // namespace kernel

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
  std::vector<int> first_;                // by obstacle: the first of its parts; -1: it is no mesh
  std::vector<kernel::PartCache> parts_;  // one for each part and mesh
};

/// Cache for `tool` in `scene` as it is now: 19 KB for each part and mesh, nothing for other shapes. Throws Error:
/// checkTool() refuses the tool. Realtime: no.
ToolCache makeToolCache(const Scene& scene, const Tool& tool);

/// Farthest that a tool may be from the origin of W in a query, m: gaps are then still known to 2 nm.
inline constexpr double kFarthestTool = 1e7;

/// All contacts whose gap is at most `margin`, the deepest first (then by obstacle), at most kMaxContacts.
/// A sphere at p touches an obstacle at every local minimum of the distance |p - x| over its surface, one for each
/// direction within 15 deg; inside an obstacle at the nearest surface point only. A capsule touches with its two ends
/// and, where its signed distance is below theirs by more than 1e-9 m, with one point of its axis between them: the
/// deepest one in an analytic shape; the one nearest to a mesh, and only while both ends are outside of it. The
/// obstacle's velocity is v + w x r. `cache` may be null and must else come from makeToolCache() of this scene and
/// tool; the contacts are the same (with meshes whose sign is defined: signedDistance()). Statuses: notFinite
/// for a pose or margin; outOfRange for a position farther than kFarthestTool; those of checkTool(); no contacts then.
/// Realtime: yes. Threads: const scene, own cache.
Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept;

/// Where a tool came from: what followContacts() remembers. Made by makeToolTrack(), outside the ticks; belongs to
/// whoever owns the tick. Copying as with a ToolCache.
class ToolTrack {
 public:
  ToolTrack();
  ToolTrack(const ToolTrack& other);
  ToolTrack(ToolTrack&& other) noexcept;
  ToolTrack& operator=(const ToolTrack& other);
  ToolTrack& operator=(ToolTrack&& other) noexcept;
  ~ToolTrack();

  /// What it remembers, as stateSize() numbers, and back, for the scene and tool that it was made for: what comes next
  /// is then the same bit for bit (with meshes whose sign is defined). Numbers that no track can have are those of a
  /// new one. Realtime: yes.
  std::size_t stateSize() const noexcept;
  void saveState(const Scene& scene, double* state) const noexcept;
  void loadState(const Scene& scene, const double* state) noexcept;

  /// Forgets where the tool was, as after makeToolTrack(). Realtime: yes.
  void reset(const Scene& scene) noexcept;

 private:
  friend ToolTrack makeToolTrack(const Scene& scene, const Tool& tool);
  friend Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                               ContactSnapshot& contacts) noexcept;
  ToolCache cache_;
  std::vector<kernel::PartTrack> parts_;  // one for each part and obstacle
  ContactSnapshot last_;                  // in the frames of the obstacles
  std::uint32_t lastKey_ = 0;
};

/// Track for `tool` in `scene` as it is now. Throws Error: as makeToolCache(). Realtime: no.
ToolTrack makeToolTrack(const Scene& scene, const Tool& tool);

/// A tool that is farther than this from where it was at the last tick has been put there, and has not moved, m.
inline constexpr double kLargestMove = 0.02;

/// findContacts() of a tool that moves. The axis of a part never changes sides but where it can go round: it is swept
/// from where it was, stays outside as long as it crosses no surface, and where it would, its place in the open that is
/// nearest to it is followed along the surface instead (Zilles & Salisbury, "A constraint-based god-object method",
/// 1995; with all parts of the axis as Ortega, Redon & Coquillart, 2007, have it, for each part on its own). Contacts
/// are those of that place, with gaps continued along their normals to where the axis is: however thin a wall is, the
/// tool is pushed back to the side from which it came, until its way back is free. On that side an open mesh, or one
/// that crosses itself, has no inside at all: both its faces touch. Where a part begins inside, by the sign of
/// signedDistance(), it has the contacts of findContacts() until it is out; likewise after a move by more than
/// kLargestMove and where a mesh was changed. Each contact has a key that it keeps while its part slides on.
/// `track` must come from makeToolTrack() of this scene and tool. Statuses, Realtime, threads: as findContacts().
Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                      ContactSnapshot& contacts) noexcept;

/// The contact of smallest gap, near or far, among equals the first of the scene: the first of findContacts() where its
/// gap is within the margin. For a scene without surfaces, a pose that findContacts() refuses or a tool that
/// checkTool() refuses the gap is kNoLimit.
/// Realtime: yes. Threads: as findContacts().
Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept;

}  // namespace enamel
