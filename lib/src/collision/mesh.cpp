#include "enamel/collision/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "enamel/core/error.hpp"
#include "normals.hpp"

namespace enamel {
namespace {

constexpr double kLargestCoordinate = 1e9;

struct Place {
  std::uint64_t bits[3];
  bool operator==(const Place& other) const { return std::memcmp(bits, other.bits, sizeof bits) == 0; }
};

struct PlaceHash {
  std::size_t operator()(const Place& p) const {
    std::uint64_t h = 0;
    for (const std::uint64_t b : p.bits) {
      h = (h ^ b) * 0x9e3779b97f4a7c15u;
      h ^= h >> 29;
    }
    return static_cast<std::size_t>(h);
  }
};

Place placeOf(const Vec3& v) {
  Place p;
  for (int k = 0; k < 3; ++k) {
    const double x = v[k] + 0.0;  // -0 and 0 are the same place
    std::memcpy(&p.bits[k], &x, sizeof x);
  }
  return p;
}

// Disjoint sets with union and find.
class Partition {
 public:
  explicit Partition(std::size_t count) {
    parent_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) parent_.push_back(static_cast<int>(i));
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int a, int b) { parent_[find(a)] = find(b); }

 private:
  std::vector<int> parent_;
};

}  // namespace

void checkMesh(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw Error("the mesh has no triangles");
  if (mesh.triangles.size() > kMostTriangles)
    throw Error("the mesh has " + std::to_string(mesh.triangles.size()) + " triangles, must have at most " +
                std::to_string(kMostTriangles));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!(mesh.vertices[i].cwiseAbs().maxCoeff() <= kLargestCoordinate) || !mesh.vertices[i].allFinite())
      throw Error("vertex " + std::to_string(i) + " has a coordinate that is not finite or larger than 1e9 m");
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t])
      if (v < 0 || v >= count)
        throw Error("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + ", the mesh has " +
                    std::to_string(count));
}

std::vector<int> weld(const TriangleMesh& mesh) {
  std::unordered_map<Place, int, PlaceHash> numbers;
  numbers.reserve(mesh.vertices.size());
  std::vector<int> place;
  place.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices)
    place.push_back(numbers.emplace(placeOf(v), static_cast<int>(numbers.size())).first->second);
  return place;
}

MeshReport inspect(const TriangleMesh& mesh) {
  checkMesh(mesh);
  MeshReport report;
  const std::vector<int> place = weld(mesh);
  report.triangles = static_cast<int>(mesh.triangles.size());
  report.vertices = static_cast<int>(mesh.vertices.size());
  report.places = *std::max_element(place.begin(), place.end()) + 1;

  report.low = Vec3::Constant(kLargestCoordinate);
  report.high = -report.low;
  std::vector<std::array<int, 3>> keys;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (const Vec3* v : {&a, &b, &c}) {
      report.low = report.low.cwiseMin(*v);
      report.high = report.high.cwiseMax(*v);
    }
    if (kernel::unitNormal(a, b, c).isZero(0.0)) ++report.degenerateTriangles;
    report.area += 0.5 * (b - a).cross(c - a).norm();
    std::array<int, 3> key{place[t[0]], place[t[1]], place[t[2]]};
    std::sort(key.begin(), key.end());
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i) report.duplicateTriangles += keys[i] == keys[i - 1];

  const std::vector<kernel::EdgeUse> edges = kernel::sortedEdges(mesh, place);
  Partition pieces(mesh.triangles.size()), fans(3 * mesh.triangles.size());
  bool balanced = !edges.empty();
  kernel::forEachEdge(edges, [&](const kernel::EdgeUse* first, const kernel::EdgeUse* last) {
    const auto corner = [](const kernel::EdgeUse& u, bool atLow) {
      return 3 * u.triangle + (u.edge + (u.forward == atLow ? 0 : 1)) % 3;
    };
    for (const kernel::EdgeUse* use = first + 1; use != last; ++use) {
      pieces.unite(first->triangle, use->triangle);
      for (const bool atLow : {false, true}) fans.unite(corner(*first, atLow), corner(*use, atLow));
    }
    const auto uses = last - first;
    const bool isBalanced = kernel::balanceOf(first, last) == 0;
    ++report.edges;
    report.boundaryEdges += uses == 1;
    report.nonManifoldEdges += uses > 2;
    report.flippedEdges += uses == 2 && !isBalanced;
    balanced = balanced && isBalanced;
  });
  for (int t = 0; t < report.triangles; ++t) report.components += pieces.find(t) == t;
  std::vector<int> fanPlaces;
  for (int c = 0; c < 3 * report.triangles; ++c)
    if (fans.find(c) == c) fanPlaces.push_back(place[mesh.triangles[c / 3][c % 3]]);
  std::sort(fanPlaces.begin(), fanPlaces.end());
  for (std::size_t first = 0, last; first < fanPlaces.size(); first = last) {
    for (last = first + 1; last < fanPlaces.size() && fanPlaces[last] == fanPlaces[first];) ++last;
    report.nonManifoldVertices += last > first + 1;
  }

  report.watertight = balanced;
  if (balanced) {
    const Vec3 centre = 0.5 * (report.low + report.high);  // any point is correct; a near one rounds least
    for (const auto& t : mesh.triangles) {
      const Vec3 a = mesh.vertices[t[0]] - centre, b = mesh.vertices[t[1]] - centre, c = mesh.vertices[t[2]] - centre;
      report.volume += a.dot(b.cross(c)) / 6.0;
    }
    report.inwards = report.volume < 0.0;
  }
  return report;
}

}  // namespace enamel
