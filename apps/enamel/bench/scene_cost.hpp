// Time of a tool's contacts in a scene: for the table of `enamel bench` and for `enamel scene --explain`.
#pragma once

#include <functional>
#include <vector>

#include "bench/measurement.hpp"
#include "enamel/collision/contacts.hpp"

namespace enamel::bench {

/// Return poses of a tool that moves from `start` (m, W) to the nearest surface and then slides over it. It slides at
/// 30 mm/s and 1 kHz, up to 50 um above the surface, within `reach` (m) of the first touch. The poses are
/// deterministic.
std::vector<Pose> slideOver(const Scene& scene, const Tool& tool, const Vec3& start, int ticks, double reach);

struct SceneCost {
  std::vector<double> times_us;  // of followContacts(), in ascending order
  int most = 0;                  // largest number of simultaneous contacts
  double touching = 0.0;         // share of the ticks with contacts
};

/// Time followContacts() along the poses. `before(i)` runs before each call and `after(i, contacts)` after it, both
/// untimed.
SceneCost costOf(const Scene& scene, const Tool& tool, const std::vector<Pose>& poses,
                 const std::function<void(int)>& before = {},
                 const std::function<void(int, const ContactSnapshot&)>& after = {});

/// Return the distance of a point from a mesh in m, by the plain formula over all triangles: the foot point in the
/// plane, or else the nearest edge.
double exhaustiveDistance(const TriangleMesh& mesh, const Vec3& p);

}  // namespace enamel::bench
