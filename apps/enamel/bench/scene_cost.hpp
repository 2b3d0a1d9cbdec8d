// What the contacts of a tool in a scene cost: for the table of `enamel bench` and for `enamel scene --explain`.
#pragma once

#include <functional>
#include <vector>

#include "bench/measurement.hpp"
#include "enamel/collision/contacts.hpp"

namespace enamel::bench {

/// A tool that goes from `start` (m, W) to the nearest surface and slides on over it at 30 mm/s and 1 kHz, up to 50 um
/// above it, within `reach` (m) of where it touched first. The same way every time.
std::vector<Pose> slideOver(const Scene& scene, const Tool& tool, const Vec3& start, int ticks, double reach);

struct SceneCost {
  std::vector<double> times_us;  // of followContacts(), in rising order
  int most = 0;                  // contacts at once
  double touching = 0.0;         // share of the ticks that have any
};

/// Times followContacts() along the poses; before each `before(i)` is called, not timed, after it `after(i, contacts)`.
SceneCost costOf(const Scene& scene, const Tool& tool, const std::vector<Pose>& poses,
                 const std::function<void(int)>& before = {},
                 const std::function<void(int, const ContactSnapshot&)>& after = {});

/// Distance of a point from a mesh by the plain formula over all triangles: foot point in the plane, else the nearest
/// edge, m.
double exhaustiveDistance(const TriangleMesh& mesh, const Vec3& p);

}  // namespace enamel::bench
