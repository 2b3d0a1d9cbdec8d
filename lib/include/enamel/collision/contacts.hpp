// The contacts of a tool with a scene, for the haptic tick.
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

/// Results of the last tick that speed up the next query of one tool in one scene. Made by makeToolCache() outside the
/// ticks; not for sharing between threads. A copy allocates; an assignment between caches of the same scene and tool
/// does not. An empty or moved-from cache is valid and gives no speed-up.
class ToolCache {
 public:
  ToolCache();
  ToolCache(const ToolCache& other);
  ToolCache(ToolCache&& other) noexcept;
  ToolCache& operator=(const ToolCache& other);
  ToolCache& operator=(ToolCache&& other) noexcept;
  ~ToolCache();

 private:
  friend class ToolTrack;
  friend struct kernel::PartCache;
  friend ToolCache makeToolCache(const Scene& scene, const Tool& tool);
  std::vector<std::vector<kernel::PartCache>> parts_;  // by obstacle and part; empty: the obstacle has no mesh
};

/// Make a cache for `tool` in the present `scene`. Size: 19 KB for each pair of part and mesh, nothing for other
/// shapes. Throws Error if checkTool() rejects the tool. Realtime: no.
ToolCache makeToolCache(const Scene& scene, const Tool& tool);

/// Largest distance of a tool from the origin of W in a query, m. At this distance gaps are accurate to 2 nm.
inline constexpr double kFarthestTool = 1e7;

/// Find all contacts with a gap of at most `margin` (m): the deepest first, then by obstacle, at most kMaxContacts.
/// `omitted` counts the others.
///
/// Sphere outside an obstacle: one contact at each local minimum of the distance |p - x| from its centre p to the
/// surface. Minima with directions within 15 deg of each other count as one. For a solid this limit is 30 deg, and if
/// the smallest gap is above 0.2 mm, only the nearest place gives a contact.
///
/// Sphere with its centre inside an obstacle: one contact, at the nearest surface point.
///
/// Capsule: contacts at both ends of its axis, as for spheres. One more point between the ends counts if its signed
/// distance is smaller than that of both ends by more than 1e-9 m. In an analytic shape it is the deepest point of the
/// axis. With a mesh or a solid it is the point nearest to the surface, and only while both ends are outside.
///
/// The obstacle's velocity at a contact is v + w x r. `cache` is null or comes from makeToolCache() of this scene and
/// tool. It does not change the contacts with meshes whose sign is defined (signedDistance()).
///
/// Statuses: notFinite (pose or margin); outOfRange (a position farther than kFarthestTool); those of checkTool().
/// After an error `contacts` is empty. Realtime: yes. Threads: const scene, own cache.
Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept;

/// The path of a tool, as followContacts() needs it. Made by makeToolTrack() outside the ticks; it belongs to the owner
/// of the tick. Copies and assignments: as for ToolCache.
class ToolTrack {
 public:
  ToolTrack();
  ToolTrack(const ToolTrack& other);
  ToolTrack(ToolTrack&& other) noexcept;
  ToolTrack& operator=(const ToolTrack& other);
  ToolTrack& operator=(ToolTrack&& other) noexcept;
  ~ToolTrack();

  /// Save and load the state as stateSize() numbers, for the scene and tool that the track was made for. After a load,
  /// all later results are the same bit for bit (with meshes whose sign is defined). loadState() replaces invalid
  /// numbers with the state of a new track. Realtime: yes.
  std::size_t stateSize() const noexcept;
  void saveState(const Scene& scene, double* state) const noexcept;
  void loadState(const Scene& scene, const double* state) noexcept;

  /// Forget the tool's path, as after makeToolTrack(). Realtime: yes.
  void reset(const Scene& scene) noexcept;

  /// Forget the path of a part at an obstacle: the part may be inside. Out-of-range numbers do nothing. Realtime: yes.
  void letIn(const Tool& tool, int obstacle, int part) noexcept;

  /// Continue the path of `old`, a track of the same tool in the scene `before`, among the obstacles that both scenes
  /// have (isSameObstacle()). `now` is the scene of this track. `old` is then only good for destruction. Realtime: yes.
  void takeOver(ToolTrack& old, const Scene& before, const Scene& now) noexcept;

 private:
  friend ToolTrack makeToolTrack(const Scene& scene, const Tool& tool);
  friend Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                               ContactSnapshot& contacts) noexcept;
  ToolCache cache_;
  std::vector<kernel::PartTrack> parts_;  // one for each part and obstacle
  ContactSnapshot last_;                  // in the frames of the obstacles
  std::uint32_t lastKey_ = 0;
};

/// Make a track for `tool` in the present `scene`. Throws Error: as makeToolCache(). Realtime: no.
ToolTrack makeToolTrack(const Scene& scene, const Tool& tool);

/// Longest move between two ticks that counts as a motion, m. After a longer one the tool counts as placed there.
inline constexpr double kLargestMove = 0.02;

/// Find the contacts of a moving tool: findContacts() without tunnelling.
///
/// A part of the tool cannot tunnel through a surface. Its axis is swept from its last position. If the sweep hits a
/// surface, a god object stays outside and slides along the surface at the free place nearest to the axis. Each part
/// has its own god object: the whole axis of the part. Sources: Zilles & Salisbury, "A constraint-based god-object
/// method", 1995; Ortega, Redon & Coquillart, 2007. The contacts are those of the god object, with gaps extended along
/// their normals to the real axis. The tool is therefore pushed back to the side that it came from, even by a very thin
/// wall, until the way back is free.
///
/// While a part is tracked, an open or self-intersecting mesh has no inside: both faces of a triangle give contacts.
///
/// A track starts again at the present position if:
/// - the part moved by more than kLargestMove since the last tick;
/// - the mesh was changed, or a solid got material back;
/// - the god object is closer than 0.01 cell to the sampled surface of a solid.
///
/// A part that starts inside, by the sign of signedDistance(), has the contacts of findContacts() until it is outside.
/// Each contact has a key, which it keeps while the part slides on. `track` must come from makeToolTrack() of this
/// scene and tool. Statuses, realtime, threads: as findContacts().
Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                      ContactSnapshot& contacts) noexcept;

/// Return the contact with the smallest gap, at any distance; of equal gaps, the first in the scene. It is the first
/// contact of findContacts() if its gap is within the margin. The gap is kNoLimit for a scene without surfaces, and for
/// a pose or tool that findContacts() or checkTool() rejects. Realtime: yes. Threads: as findContacts().
Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept;

}  // namespace enamel
