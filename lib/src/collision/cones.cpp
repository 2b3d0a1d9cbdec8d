#include "cones.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "boxes.hpp"

namespace enamel::kernel {
namespace {

double angleBetween(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }
double angleOfCone(float cone) { return std::acos(std::sqrt(static_cast<double>(cone))); }
float coneOfCosine(double cosine) {  // rounded to a slightly wider cone
  const double least = 0.99999 * std::max(cosine, 0.0);
  return static_cast<float>(least * least);
}
float coneOfAngle(double angle) {
  const double cosine = angle + 1e-3 < 0.5 * M_PI ? std::cos(angle + 1e-3) : 0.0;
  return static_cast<float>(0.999 * cosine * cosine);
}

// Cosines of the widest angles between a triangle's normal and the directions from its edges and corners. Only
// directions to points whose nearest point is on this edge or corner count, in front of the triangle and behind it.
struct Widest {
  double front = 1.0, back = 1.0;
  void add(double cosine, bool isBehind) { (isBehind ? back : front) = std::min(isBehind ? back : front, cosine); }
};

// Find the cone of directions to the points that have a corner as their nearest point. No edge at the corner may be
// nearer. `directions` are its rays along the edges; a saddle has none. Returns false if the corner has too many edges.
bool findDirections(const MeshData& data, int place, std::vector<Vec3>& directions) {
  constexpr std::size_t kMostEdges = 12;
  constexpr double kRounding = 1e-3;  // rad
  std::array<Vec3, kMostEdges> edge;
  std::size_t count = 0;
  for (std::int32_t c = data.firstCorner[place]; c >= 0; c = data.nextCorner[c]) {  // each leaves in one triangle
    if (count == kMostEdges) return false;
    const auto& t = data.mesh.triangles[c / 3];
    edge[count++] = (data.mesh.vertices[t[(c + 1) % 3]] - data.mesh.vertices[t[c % 3]]).normalized();
  }
  directions.clear();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vec3 across = edge[i].cross(edge[k]);
      const double length = across.norm();
      if (!(length > kRounding)) continue;
      for (const Vec3& direction : {Vec3(across / length), Vec3(across / -length)})
        if (std::all_of(edge.begin(), edge.begin() + count,
                        [&](const Vec3& e) { return e.dot(direction) <= kRounding; }))
          directions.push_back(direction);
    }
  return true;
}

// Whether a single walk round a corner meets all its triangles. If several surfaces meet there, each has contacts of
// its own, also where another one is nearer. No cone describes that.
bool isOneFan(const MeshData& data, int place) {
  const std::int32_t first = data.firstCorner[place];
  int count = 0, met = 0;
  for (std::int32_t c = first; c >= 0; c = data.nextCorner[c]) ++count;
  std::int32_t t = first / 3;
  do {
    int corner = 0;
    while (corner < 2 && data.place[data.mesh.triangles[t][corner]] != place) ++corner;
    t = data.neighbour[t][(corner + 2) % 3];
    ++met;
  } while (t >= 0 && t != first / 3 && met < count);
  return t == first / 3 && met == count;
}

// At a local minimum of the distance, the offset to the point is a combination of the surrounding normals with
// non-negative weights, and no edge there is nearer. An open surface gets 0, no restriction.
void writeTriangleCones(MeshData& data, const std::vector<Vec3>& normal, const std::vector<char>& isOpen) {
  const TriangleMesh& mesh = data.mesh;
  std::vector<Widest> widest(mesh.triangles.size());
  std::vector<double> around(mesh.triangles.size(), 1.0);  // cosine of the angle to the farthest normal
  std::vector<Vec3> directions;
  for (std::size_t place = 0; place < isOpen.size(); ++place) {
    const std::int32_t first = data.firstCorner[place];
    if (first < 0) continue;
    const bool isKnown = isOpen[place] == 0 && isOneFan(data, static_cast<int>(place));
    const bool hasDirections = isKnown && findDirections(data, static_cast<int>(place), directions);
    for (std::int32_t c = first; c >= 0; c = data.nextCorner[c]) {
      const std::size_t t = static_cast<std::size_t>(c / 3);
      double least = isKnown ? 1.0 : 0.0;
      for (std::int32_t other = first; other >= 0 && least > 0.0; other = data.nextCorner[other])
        least = std::min(least, normal[t].dot(normal[static_cast<std::size_t>(other / 3)]));
      around[t] = std::min(around[t], least);
      if (!hasDirections) {
        widest[t].add(least, false);
        widest[t].add(least, true);
        continue;
      }
      double most = -1.0, smallest = 1.0;
      for (const Vec3& direction : directions) {
        most = std::max(most, normal[t].dot(direction));
        smallest = std::min(smallest, normal[t].dot(direction));
      }
      if (most > 0.0) widest[t].add(std::max(smallest, least), false);
      if (smallest < 0.0) widest[t].add(std::max(-most, least), true);
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const std::int32_t other = data.neighbour[t][i];
      if (other < 0) continue;
      const Vec3 &a = mesh.vertices[mesh.triangles[t][i]], &b = mesh.vertices[mesh.triangles[t][(i + 1) % 3]];
      // Height of the other triangle's third corner. If it is in front, the edge is a ridge as seen from behind.
      double height = 0.0;
      for (const int v : mesh.triangles[other]) height += normal[t].dot(mesh.vertices[v] - a);
      const double flat = 1e-9 * (b - a).norm(), cosine = normal[t].dot(normal[other]);
      if (height <= flat) widest[t].add(cosine, false);
      if (height >= -flat) widest[t].add(cosine, true);
    }
    const std::int32_t slot = data.slotOf[t];
    Leaf& leaf = data.leaves[slot / kWidth];
    leaf.front[slot % kWidth] = coneOfCosine(widest[t].front);
    leaf.back[slot % kWidth] = coneOfCosine(widest[t].back);
    if (data.triangles[slot].cone >= 0.0f) data.triangles[slot].cone = coneOfCosine(around[t]);
  }
}

// The cone of a leaf, about the third axis of its box, contains the cones of its triangles.
void writeLeafCone(MeshData& data, std::int32_t leaf, const std::vector<Vec3>& normal) {
  const Parent at = data.leafParent[leaf];
  const Vec3 axis = readOriented(data, at).axes.row(2);
  double widest = 0.0;
  const Leaf& cones = data.leaves[leaf];
  for (int lane = 0; lane < kWidth; ++lane) {
    const std::int32_t number = data.triangles[leaf * kWidth + lane].index;
    if (number < 0) continue;
    const float cone = std::min(cones.front[lane], cones.back[lane]);
    widest = std::max(widest, angleBetween(axis, normal[number]) + angleOfCone(cone));
  }
  data.nodes[at.node].cone[at.lane] = coneOfAngle(widest);
}

// The cone of a node contains those of its children.
void writeNodeCone(MeshData& data, std::int32_t number) {
  const Parent at = data.nodeParent[number];
  if (at.node < 0) return;
  const Node& node = data.nodes[number];
  const Vec3 axis = readOriented(data, at).axes.row(2);
  double widest = 0.0;
  for (int lane = 0; lane < kWidth; ++lane)
    if ((node.lanes >> lane & 1u) != 0)
      widest = std::max(
          widest, angleBetween(axis, readOriented(data, {number, lane}).axes.row(2)) + angleOfCone(node.cone[lane]));
  data.nodes[at.node].cone[at.lane] = coneOfAngle(widest);
}

// Places where the surface has a border or an unknown normal.
std::vector<char> openPlaces(const MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal) {
  std::vector<char> isOpen(data.firstCorner.size(), 0);
  for (std::size_t t = 0; t < normal.size(); ++t)
    if (normal[t].isZero(0.0))
      for (const int v : data.mesh.triangles[t]) isOpen[data.place[v]] = 1;
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    if (last - first != 2 || balanceOf(first, last) != 0) isOpen[first->low] = isOpen[first->high] = 1;
  });
  return isOpen;
}

}  // namespace

void buildCones(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal) {
  writeTriangleCones(data, normal, openPlaces(data, edges, normal));
  for (std::size_t leaf = 0; leaf < data.leaves.size(); ++leaf)
    writeLeafCone(data, static_cast<std::int32_t>(leaf), normal);
  for (std::size_t node = data.nodes.size(); node-- > 0;) writeNodeCone(data, static_cast<std::int32_t>(node));
}

void openCones(MeshData& data, Parent at) {
  for (; at.node >= 0 && data.nodes[at.node].cone[at.lane] > 0.0f; at = data.nodeParent[at.node])
    data.nodes[at.node].cone[at.lane] = 0.0f;
}

}  // namespace enamel::kernel
