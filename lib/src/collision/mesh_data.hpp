// The content of a MeshModel.
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

/// Parent of a node or leaf: child `lane` of `node`; node -1 for the root.
struct Parent {
  std::int32_t node = -1, lane = 0;
};

template <typename T>
using Array = std::vector<T, HugePages<T>>;

struct MeshData {
  TriangleMesh mesh;
  std::vector<int> place;  // of each vertex, as weld() numbers them
  Array<Node> nodes;
  Array<Leaf> leaves;
  Array<AlignedBoxes> boxes;                     // by node
  Array<MomentRows> moments;                     // by node
  Array<Triangle> triangles;                     // by slot
  Array<std::uint8_t> tainted;                   // by slot; bit i: corner or edge i (as TriangleFeature) was edited or
                                                 // touches a triangle without normal
  Array<std::int32_t> slotOf;                    // by triangle number, up to the largest possible; an absent triangle
                                                 // has a near slot that may be in use
  Array<std::array<std::int32_t, 3>> neighbour;  // by triangle number: across edges 01, 12, 20; -1 if it is not unique
  std::vector<Parent> nodeParent, leafParent;
  Mesh view{};
  // Triangles at a place, for updates: corner = 3 * triangle + i; -1 ends a list.
  std::vector<std::int32_t> firstCorner;  // by place
  std::vector<std::int32_t> nextCorner;   // by corner
  int mostVertices = 0;                   // largest possible number
  // Working space of the updates, allocated for the largest update.
  std::vector<Vec3> scratch;
  std::vector<std::int32_t> dirtyLeaves;
  std::vector<char> isDirty;      // by leaf
  std::vector<char> isRewritten;  // by slot
  std::vector<int> taintedPlaces;
  std::vector<char> isTainted;  // by place
  std::vector<std::int32_t> staleLeaves, staleNodes;
  std::vector<std::int32_t> freeInNode, freeInLeaf;  // free slots below it
  std::vector<char> isStaleLeaf, isStaleNode;
  int openEdges = 0;           // with more triangles in one direction than in the other
  int crowdedEdges = 0;        // with more than two triangles
  bool crossesItself = false;  // when it was built
  bool closed = false;         // no edge is open
  bool sound = false;          // closed, no edge crowded, no triangles cross: pseudonormals give the side
  bool edited = false;         // vertices moved or triangles were added since: triangles may cross, though it is sound
  bool inwards = false;        // the volume is negative: treated as if all triangles were reversed
  double size = 0.0;           // diagonal of the bounding box, m
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // corners of it; updates only enlarge it
};

/// Gives the module access to the content of its public classes.
struct Inside {
  static MeshData& of(MeshModel& model) noexcept { return *model.data_; }
  static const MeshData& of(const MeshModel& model) noexcept { return *model.data_; }
  static Cache* of(ProximityCache* cache) noexcept { return cache == nullptr ? nullptr : cache->content_.get(); }
};

/// The public functions of the same names, for the content of the public classes.
SurfacePoint closestPoint(const MeshData& data, const Vec3& p, Cache* cache, double limit) noexcept;
SurfacePoint signedDistance(const MeshData& data, const Vec3& p, Cache* cache, double limit,
                            bool isOutside = false) noexcept;
SweepHit sweepSphere(const MeshData& data, const Vec3& from, const Vec3& to, double radius, Cache* cache) noexcept;

SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius,
                      int advances) noexcept;
inline constexpr int kMostAdvances = 256;  ///< of sweepCapsule() on a triangle

/// Write a feature of the loops as public answers have it.
template <typename PublicAnswer>
void setFeature(std::int32_t feature, PublicAnswer& answer) noexcept {
  answer.feature = feature == kFace ? Feature::face : feature >= kEdge01 ? Feature::edge : Feature::vertex;
  answer.featureIndex = feature == kFace ? -1 : feature % 3;
}
static_assert(kCorner0 % 3 == 0 && kEdge01 % 3 == 0);

/// Convert the nearest triangle to the result of closestPoint().
SurfacePoint surfacePoint(const MeshData& data, const Answer& found) noexcept;

/// Convert the nearest triangle of p to the result of signedDistance(). `isOutside`: p is known to be outside.
SurfacePoint signedSurfacePoint(const MeshData& data, const Vec3& p, const Answer& found, Cache* cache,
                                bool isOutside = false) noexcept;

/// Return the loops of the SIMD level in use.
const Loops& loops() noexcept;

/// Allocate the working space of updates for the largest one, with room for additional vertices.
void reserveForUpdates(MeshData& data, int spareVertices);

/// Whether a triangle is present (not removed).
inline bool hasTriangle(const MeshData& data, std::int32_t triangle) noexcept {
  return data.triangles[data.slotOf[triangle]].index == triangle;
}

}  // namespace enamel::kernel
