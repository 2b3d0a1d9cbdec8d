// Contacts of one part of a tool with one obstacle, and the collection of a tick's contacts.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "minima.hpp"
#include "solid_query.hpp"
#include "tool_parts.hpp"

namespace enamel::kernel {

/// A place on an axis, usually an end, and its query results. The next part often begins where the last one ended.
struct End {
  Vec3 point = Vec3::Zero();
  double limit = -1.0;   ///< search limit of the nearest point
  SurfacePoint nearest;  ///< signed
  double reach = -1.0;   ///< search limit of the minima of the distance
  Minima minima;

  bool isAhead() const { return nearest.distance > 0.0; }
};

/// The last place on an axis whose minima a solid was searched for.
struct SolidEnd {
  Vec3 point = Vec3::Zero();
  double reach = 0.0;  ///< search limit
  SolidMinima minima;
};

/// Collects the contacts of one tick, deepest first.
struct Collector {
  ContactSnapshot* contacts;
  double margin;
  Pair pair;
  End* last;                                         ///< of the previous part
  End* next;                                         ///< becomes `last`
  std::optional<SolidEnd>* solid;                    ///< empty at first
  double nextRadius;                                 ///< of the part that begins where this one ends, or 0
  bool isOutside = false;                            ///< the axis is known to be outside
  double pad = 0.0;                                  ///< of a sheet: half its thickness, added to all radii
  const Segment *from = nullptr, *actual = nullptr;  ///< if set: the queried axis `from` replaces the axis `actual`
  SolidNear* near = nullptr;                         ///< if set: of the part's end a in an earlier tick

  double reachOf(double radius) const { return radius + std::max(margin, 0.0); }

  /// Add a contact. `asked` and `found` are in the obstacle's frame.
  template <typename Found>
  void add(const Vec3& asked, const Found& found, double radius);
};

/// Add the contacts of a part whose axis is given in the obstacle's frame. Realtime: yes.
void addPart(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache, Collector& out) noexcept;

/// Add the nearest place of a part, under the rules of addPart(). Realtime: yes.
void addNearest(const Obstacle& obstacle, const Segment& axis, double radius, PartCache* cache,
                Collector& out) noexcept;

/// Call visit(obstacle, axis, radius, cache, collector) for every part and obstacle. An error leaves no contacts.
template <typename Visit>
Status forEachPart(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                   ContactSnapshot& contacts, const Visit& visit) {
  contacts.count = 0;
  if (!std::isfinite(margin)) return Status::notFinite;
  if (const Status status = checkPlace(pose); status != Status::ok) return status;
  if (const Status status = checkTool(tool); status != Status::ok) return status;
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  End ends[2];
  std::optional<SolidEnd> solid;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (!obstacles[i].active) continue;
    if (!isFinite(obstacles[i].pose)) {
      contacts.count = 0;
      return Status::notFinite;
    }
    ends[0].limit = -1.0;
    ends[0].nearest = SurfacePoint();
    solid.reset();
    Collector out{&contacts, margin, {&obstacles[i], static_cast<int>(i), 0}, &ends[0], &ends[1], &solid, 0.0};
    out.pad = 0.5 * obstacles[i].thickness;
    out.isOutside = out.pad > 0.0;
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      out.pair.part = k;
      out.nextRadius = k + 1 < tool.count && tool.parts[k + 1].a == part.b ? tool.parts[k + 1].radius + out.pad : 0.0;
      const Segment axis = axisOf(part, pose, obstacles[i]);
      PartCache* known = PartCache::of(cache, i, k);
      visit(obstacles[i], axis, part.radius + out.pad, known, out);
    }
  }
  return Status::ok;
}

}  // namespace enamel::kernel
