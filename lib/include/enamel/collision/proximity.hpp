// Nearest points of triangle meshes: exact in double, on a wide hierarchy of bounding boxes, fast for a tool that
// moves little from tick to tick. Coordinates are those of the mesh's own frame, m.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "enamel/collision/feature.hpp"
#include "enamel/collision/mesh.hpp"
#include "enamel/core/status.hpp"

namespace enamel {

namespace kernel {
struct Cache;
struct Inside;
struct MeshData;
}  // namespace kernel

/// Room for vertices and triangles that are added later (mesh_update.hpp): 40 bytes a vertex, about 230 a triangle.
struct SpareCapacity {
  int vertices = 0;
  int triangles = 0;
};

/// A mesh ready for queries. Immutable but for the updates of mesh_update.hpp; const use is thread-safe.
class MeshModel {
 public:
  /// Builds the hierarchy: 2 us a triangle, 4 us of a manifold mesh (do triangles cross?). Throws Error as checkMesh()
  /// does, and for a capacity that is negative or beyond 2^27 with the mesh. Realtime: no.
  explicit MeshModel(TriangleMesh mesh, SpareCapacity spare = {});
  MeshModel(MeshModel&&) noexcept;
  MeshModel& operator=(MeshModel&&) noexcept;
  ~MeshModel();

  /// As it is after all updates. Removed triangles keep their numbers and last corners: isPresent() tells them apart,
  /// presentMesh() leaves them out.
  const TriangleMesh& mesh() const noexcept;

 private:
  friend struct kernel::Inside;
  std::unique_ptr<kernel::MeshData> data_;
};

/// Whether the mesh is the surface of a solid: watertight, with two triangles at every edge, none through another (this
/// as it was when the model was built). Realtime: yes.
bool isSound(const MeshModel& model) noexcept;

/// The mesh without its removed triangles; the others in the order of their numbers. Realtime: no.
TriangleMesh presentMesh(const MeshModel& model);

/// What the mesh is now, after all updates, and what that means for the sign of its distances, in one line. Realtime:
/// no.
std::string describe(const MeshModel& model);

/// What a tool remembers of its last query on a mesh, so that the next one, close by, is answered faster. The answer is
/// the same bit for bit with a cache, with a cache of another place or mesh, and without one. One for each point that
/// is followed on a mesh; not shared between threads. Making and copying one allocates (6.3 KB), assigning a copy does
/// not; one that was moved from helps no more. Realtime: queries only.
class ProximityCache {
 public:
  ProximityCache();
  ProximityCache(const ProximityCache& other);
  ProximityCache(ProximityCache&& other) noexcept;
  ProximityCache& operator=(const ProximityCache& other);
  ProximityCache& operator=(ProximityCache&& other) noexcept;
  ~ProximityCache();

 private:
  friend struct kernel::Inside;
  std::unique_ptr<kernel::Cache> content_;
};

inline constexpr double kNoLimit = std::numeric_limits<double>::max();

/// Answer of the nearest-point queries.
struct SurfacePoint {
  Status status = Status::ok;  ///< notFinite: of the point, or the limit is NaN; outOfRange: the limit is negative
  int triangle = -1;           ///< -1: no triangle within the limit; then only the distance, kNoLimit, has a meaning
  Feature feature = Feature::face;
  int featureIndex = -1;       ///< as Feature tells
  Vec3 point = Vec3::Zero();   ///< on the mesh, m
  double distance = kNoLimit;  ///< m
  Vec3 normal = Vec3::Zero();  ///< outward unit normal; only from signedDistance()
};

/// The point of the mesh nearest to p: argmin |p - x|, among equally near triangles the one of smallest number. The
/// distance is computed in double, to about 1e-15 of the mesh size, also for triangles without area.
/// `limit`, m: farther triangles are not reported. `cache` may be null. Realtime: yes (no allocation; a point far
/// from the surface in comparison with the mesh's features may visit many triangles).
SurfacePoint closestPoint(const MeshModel& model, const Vec3& p, ProximityCache* cache = nullptr,
                          double limit = kNoLimit) noexcept;

/// closestPoint() with sign (negative inside) and outward unit normal.
/// - Of a sound mesh (isSound()) the sign is exact, that of (p - x).n with the angle-weighted pseudonormal n of the
///   face, edge or corner that x lies on (Baerentzen & Aanaes, "Signed distance computation using the angle weighted
///   pseudonormal", 2005).
/// - Of any other mesh, inside is where the generalised winding number w (Jacobson et al. 2013) is above 1/2, and
///   nothing outside of the bounding box. w is approximate (Barill et al. 2018): where it is nearer to 1/2 than 1e-3,
///   either sign may be answered. Through an opening the sign changes where w passes 1/2, with the distance that the
///   point has there from the mesh: a tool that moves asks followContacts() instead, which needs no sign.
/// - Triangles run counterclockwise seen from outside. A mesh around a negative volume, however its openings are
/// closed,
///   is taken as if all were turned round; another open one is taken as it is.
/// Realtime: yes, as closestPoint(); w takes 10 us, near 1/2 100 us, and holds for the cache while the point moves by
/// less than about 0.4 of its distance.
SurfacePoint signedDistance(const MeshModel& model, const Vec3& p, ProximityCache* cache = nullptr,
                            double limit = kNoLimit) noexcept;

/// Triangles that were found, and how many there are.
struct TriangleCount {
  Status status = Status::ok;  ///< notFinite: p or the radius is not finite; outOfRange: a number is negative
  int found = 0;               ///< all of them; above the capacity, only so many were written
};

/// All triangles within `radius` (m) of p, borders included, written to triangles[0] to triangles[capacity - 1] in
/// rising order; where there are more, the smallest numbers are. Realtime: yes.
TriangleCount trianglesWithin(const MeshModel& model, const Vec3& p, double radius, int* triangles,
                              int capacity) noexcept;

/// Instruction sets that the query loops are compiled for.
enum class SimdLevel : int { baseline, avx2, avx512 };

/// Level in use: at the start the best that this processor has. Realtime: yes.
SimdLevel simdLevel() noexcept;

/// Chooses the level for the whole process, for tests and measurements; the answers do not depend on it. Levels that
/// the processor lacks are lowered to the best that it has; returns the level in use. Not while queries run.
SimdLevel useSimdLevel(SimdLevel level) noexcept;

}  // namespace enamel
