// The inside of a MeshModel.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/sweep.hpp"
#include "huge_pages.hpp"
#include "kernel.hpp"

namespace enamel::kernel {

/// Where a node or leaf hangs: child `lane` of `node`; node -1 for the root.
struct Parent {
  std::int32_t node = -1, lane = 0;
};

template <typename T>
using Array = std::vector<T, HugePages<T>>;

struct MeshData {
  TriangleMesh mesh;
  std::vector<int> place;  // of each vertex, as weld()
  Array<Node> nodes;
  Array<Leaf> leaves;
  Array<AlignedBoxes> boxes;                     // by node
  Array<MomentRows> moments;                     // by node
  Array<Triangle> triangles;                     // by slot
  Array<std::uint8_t> tainted;                   // by slot; bit i: corner or edge i (as TriangleFeature) touches a
                                                 // triangle without normal, or was edited
  Array<std::int32_t> slotOf;                    // by triangle number, as many as there may be; of others than
                                                 // present ones: a slot close by, which another may have taken
  Array<std::array<std::int32_t, 3>> neighbour;  // by triangle number: across edges 01, 12, 20; -1: not one
  std::vector<Parent> nodeParent, leafParent;
  Mesh view{};
  // Triangles at a place, for the updates: corner = 3 * triangle + i; -1 ends a list.
  std::vector<std::int32_t> firstCorner;  // by place
  std::vector<std::int32_t> nextCorner;   // by corner
  int mostVertices = 0;                   // that there may be
  // Working space of the updates, as large as it can ever become.
  std::vector<Vec3> scratch;
  std::vector<std::int32_t> dirtyLeaves;
  std::vector<char> isDirty;      // by leaf
  std::vector<char> isRewritten;  // by slot
  std::vector<int> taintedPlaces;
  std::vector<char> isTainted;  // by place
  std::vector<std::int32_t> staleLeaves, staleNodes;
  std::vector<std::int32_t> freeInNode, freeInLeaf;  // slots below it that hold no triangle
  std::vector<char> isStaleLeaf, isStaleNode;
  int openEdges = 0;           // with more triangles one way than the other
  int crowdedEdges = 0;        // with more than two triangles
  bool crossesItself = false;  // when it was built
  bool closed = false;         // no edge is open
  bool sound = false;          // closed, no edge crowded, no triangle through another: pseudonormals tell the side
  bool inwards = false;        // around a negative volume: taken as if all triangles were turned round
  double size = 0.0;           // diagonal of the bounding box, m
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // corners of it; updates only enlarge it
};

/// Opens to the module what its public classes hold.
struct Inside {
  static MeshData& of(MeshModel& model) noexcept { return *model.data_; }
  static const MeshData& of(const MeshModel& model) noexcept { return *model.data_; }
  static Cache* of(ProximityCache* cache) noexcept { return cache == nullptr ? nullptr : cache->content_.get(); }
};

/// The public functions of these names, for what the public classes hold.
SurfacePoint closestPoint(const MeshData& data, const Vec3& p, Cache* cache, double limit) noexcept;
SurfacePoint signedDistance(const MeshData& data, const Vec3& p, Cache* cache, double limit,
                            bool isOutside = false) noexcept;
SweepHit sweepSphere(const MeshData& data, const Vec3& from, const Vec3& to, double radius, Cache* cache) noexcept;

SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius,
                      int advances) noexcept;
inline constexpr int kMostAdvances = 256;  ///< of sweepCapsule() on a triangle

/// Writes what the loops call a feature as public answers do.
template <typename PublicAnswer>
void setFeature(std::int32_t feature, PublicAnswer& answer) noexcept {
  answer.feature = feature == kFace ? Feature::face : feature >= kEdge01 ? Feature::edge : Feature::vertex;
  answer.featureIndex = feature == kFace ? -1 : feature % 3;
}
static_assert(kCorner0 % 3 == 0 && kEdge01 % 3 == 0);

/// What closestPoint() answers where `found` is nearest.
SurfacePoint surfacePoint(const MeshData& data, const Answer& found) noexcept;

/// What signedDistance() answers for p where `found` is nearest; `isOutside`: p is known to be there.
SurfacePoint signedSurfacePoint(const MeshData& data, const Vec3& p, const Answer& found, Cache* cache,
                                bool isOutside = false) noexcept;

/// The loops of the SIMD level in use.
const Loops& loops() noexcept;

/// Makes the updates' working space as large as it can ever become, with this room for vertices.
void reserveForUpdates(MeshData& data, int spareVertices);

/// Whether a triangle is there (not removed).
inline bool hasTriangle(const MeshData& data, std::int32_t triangle) noexcept {
  return data.triangles[data.slotOf[triangle]].index == triangle;
}

}  // namespace enamel::kernel
