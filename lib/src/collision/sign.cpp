#include "sign.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "boxes.hpp"
#include "winding.hpp"

namespace enamel::kernel {
namespace {

#include "exact.inl"

constexpr double kCoarse = 2.0, kFine = 8.0;              // `accept` of windingNumber()
constexpr double kCoarseError = 0.05, kFineError = 1e-3;  // errors of the winding number at these, with a margin
constexpr double kThreshold = 0.5;
// Bound of the gradient of the winding number times the distance from the mesh. It is 1 / (2 pi) beside a straight
// border and 1/2 in the middle of a round hole. A harmonic function between 0 and 1 has at most 3/4.
constexpr double kSlope = 0.75;

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

// Two triangles cross if an edge of one passes through the other.
bool crossesItself(const MeshData& data, const std::vector<EdgeUse>& edges) {
  std::vector<const EdgeUse*> byLeaf;  // sorted so that near edges follow each other
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse*) { byLeaf.push_back(first); });
  std::sort(byLeaf.begin(), byLeaf.end(),
            [&](const EdgeUse* a, const EdgeUse* b) { return data.slotOf[a->triangle] < data.slotOf[b->triangle]; });
  for (const EdgeUse* edge : byLeaf) {
    const auto& t = data.mesh.triangles[edge->triangle];
    const Vec3 &a = data.mesh.vertices[t[edge->edge]], &b = data.mesh.vertices[t[(edge->edge + 1) % 3]];
    Crossing s{&data, edge, axisBetween(a.data(), b.data()), false};
    loops().visit(data.view, a.data(), b.data(), 0.0, &tryCrossing, &s);
    if (s.isFound) return true;
  }
  return false;
}

// Whether the volume is negative for every closing of the open edges of total length l. The circle has the largest area
// of all loops, l^2 / (4 pi). No cone over it reaches farther than the mesh.
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
  const bool isManifold = data.closed && data.crowdedEdges == 0;
  data.crossesItself = isManifold && crossesItself(data, edges);
  data.sound = isManifold && !data.crossesItself;
  data.inwards = isInwards(data, edges);
}

bool isInside(const MeshData& data, const Vec3& p, double distance, Cache* cache) noexcept {
  if ((p.array() < data.low.array()).any() || (p.array() > data.high.array()).any()) return false;
  if (cache != nullptr && cache->signRevision == data.view.revision &&
      (p - Vec3(cache->signAt[0], cache->signAt[1], cache->signAt[2])).norm() <= cache->signWithin)
    return cache->isInside != 0;
  const auto over = [&](double accept) {
    const double winding = windingNumber(data, p, accept);
    return (data.inwards ? -winding : winding) - kThreshold;
  };
  double excess = over(kCoarse), error = kCoarseError;
  if (std::abs(excess) < error) {
    excess = over(kFine);
    error = kFineError;
  }
  const bool inside = excess > 0.0;
  if (cache == nullptr) return inside;
  cache->signRevision = data.view.revision;
  for (int k = 0; k < 3; ++k) cache->signAt[k] = p[k];
  const double change = std::max(std::abs(excess) - 2.0 * error, 0.0);
  cache->signWithin = distance * (1.0 - std::exp(-change / kSlope));
  cache->isInside = inside ? 1 : 0;
  return inside;
}

}  // namespace enamel::kernel
