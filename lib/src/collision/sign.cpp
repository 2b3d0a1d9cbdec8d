#include "sign.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "boxes.hpp"
#include "winding.hpp"

namespace enamel::kernel {
namespace {

#include "exact.inl"

constexpr double kCoarse = 2.0, kFine = 8.0;              // windingNumber's `accept`
constexpr double kCoarseError = 0.03, kFineError = 1e-3;  // of it, with a margin
constexpr double kThreshold = 0.5;
constexpr double kShrink = 64.0 / 27.0;  // what the slope grows by within a quarter of the distance

struct Crossing {
  const MeshData* data;
  const EdgeUse* edge;
  Axis axis;
  bool isFound;
};

double tryCrossing(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<Crossing*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  for (const int v : s.data->mesh.triangles[triangle.index]) {
    const int place = s.data->place[v];
    if (place == s.edge->low || place == s.edge->high) return reach;
  }
  SegmentCandidate c;
  s.isFound = s.isFound || crossesAxis(&triangle, &s.axis, &c) != 0;
  return reach;
}

// Two triangles cross where an edge of one passes through the other.
bool crossesItself(const MeshData& data, const std::vector<EdgeUse>& edges) {
  std::vector<const EdgeUse*> byLeaf;  // those close to each other in turn
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse*) { byLeaf.push_back(first); });
  std::sort(byLeaf.begin(), byLeaf.end(), [&](const EdgeUse* a, const EdgeUse* b) {
    return data.slotOf[a->triangle] < data.slotOf[b->triangle];
  });
  for (const EdgeUse* edge : byLeaf) {
    const auto& t = data.mesh.triangles[edge->triangle];
    const Vec3 &a = data.mesh.vertices[t[edge->edge]], &b = data.mesh.vertices[t[(edge->edge + 1) % 3]];
    Crossing s{&data, edge, axisBetween(a.data(), b.data()), false};
    loops().visit(data.view, a.data(), b.data(), 0.0, &tryCrossing, &s);
    if (s.isFound) return true;
  }
  return false;
}

bool isManifold(const std::vector<EdgeUse>& edges) {
  bool result = true;
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) { result = result && last - first <= 2; });
  return result;
}

// Whether the volume is negative however the open edges, of length l in all, are closed: of all loops the circle has the
// largest area, l^2 / (4 pi), and no cone over it reaches farther than the mesh.
bool isInwards(const MeshData& data, const std::vector<EdgeUse>& edges) {
  const auto vertex = [&](int v) { return local(data.view, data.mesh.vertices[v]); };
  double volume = 0.0, open = 0.0;
  for (const auto& t : data.mesh.triangles) volume += vertex(t[0]).dot(vertex(t[1]).cross(vertex(t[2]))) / 6.0;
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    const auto& t = data.mesh.triangles[first->triangle];
    open += std::abs(balanceOf(first, last)) * (vertex(t[(first->edge + 1) % 3]) - vertex(t[first->edge])).norm();
  });
  return volume < -open * open / (12.0 * M_PI) * data.size * data.view.scale;
}

}  // namespace

void chooseSign(MeshData& data, const std::vector<EdgeUse>& edges) {
  data.sound = data.closed && isManifold(edges) && !crossesItself(data, edges);
  data.inwards = isInwards(data, edges);
}

bool isInside(const MeshData& data, const Vec3& p, double distance, Cache* cache) noexcept {
  if ((p.array() < data.low.array()).any() || (p.array() > data.high.array()).any()) return false;
  if (cache != nullptr && cache->signRevision == data.view.revision &&
      (p - Vec3(cache->signAt[0], cache->signAt[1], cache->signAt[2])).norm() <= cache->signWithin)
    return cache->isInside != 0;
  Winding winding = windingNumber(data, p, distance, kCoarse);
  double error = kCoarseError;
  const auto over = [&] { return (data.inwards ? -winding.number : winding.number) - kThreshold; };
  if (std::abs(over()) < error) {
    winding = windingNumber(data, p, distance, kFine);
    error = kFineError;
  }
  const bool inside = over() > 0.0;
  if (cache == nullptr) return inside;
  cache->signRevision = data.view.revision;
  for (int k = 0; k < 3; ++k) cache->signAt[k] = p[k];
  // Off the surface the winding number is a smooth function of the place.
  cache->signWithin = std::min(0.25 * distance, (std::abs(over()) - 2.0 * error) / (kShrink * winding.slope));
  cache->isInside = inside ? 1 : 0;
  return inside;
}

}  // namespace enamel::kernel
