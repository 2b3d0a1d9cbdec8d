// Nearest points of triangle meshes, exact in double. A wide hierarchy of bounding boxes makes queries fast for a tool
// that moves little from tick to tick. Coordinates are those of the mesh's own frame, m.
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

/// Room for vertices and triangles to be added later (mesh_update.hpp): 40 bytes a vertex, about 230 bytes a triangle.
struct SpareCapacity {
  int vertices = 0;
  int triangles = 0;
};

/// A mesh ready for queries. Only the functions of mesh_update.hpp change it. Const use is thread-safe.
class MeshModel {
 public:
  /// Build the hierarchy: 2 us a triangle, or 4 us if the mesh is manifold (with the test for crossing triangles).
  /// Throws Error as checkMesh(), and for a spare capacity that is negative or above 2^27 together with the mesh.
  /// Realtime: no.
  explicit MeshModel(TriangleMesh mesh, SpareCapacity spare = {});
  MeshModel(MeshModel&&) noexcept;
  MeshModel& operator=(MeshModel&&) noexcept;
  ~MeshModel();

  /// Return the mesh after all updates. Removed triangles keep their numbers and last corners: isPresent() identifies
  /// them, presentMesh() leaves them out.
  const TriangleMesh& mesh() const noexcept;

 private:
  friend struct kernel::Inside;
  std::unique_ptr<kernel::MeshData> data_;
};

/// Return true if the mesh is the surface of a solid: watertight, two triangles at every edge, no triangle through
/// another. The last property is that of the mesh when the model was built. Realtime: yes.
bool isSound(const MeshModel& model) noexcept;

/// Return the mesh without its removed triangles; the others keep their order. Realtime: no.
TriangleMesh presentMesh(const MeshModel& model);

/// Return a description, in one line, of the mesh after all updates and of the sign of its distances. Realtime: no.
std::string describe(const MeshModel& model);

/// Memory of a query's result that makes the next query nearby faster. It never changes a result: results are
/// bit-identical with this cache, with a cache of another place or mesh, and without one. Use one for each point that
/// follows a mesh; do not share it between threads. Construction and copying allocate (6.3 KB); assigning does not. A
/// moved-from cache is valid and gives no speed-up. Realtime: queries only.
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

/// Result of the nearest-point queries.
struct SurfacePoint {
  Status status = Status::ok;  ///< notFinite: the point, or a NaN limit; outOfRange: negative limit
  int triangle = -1;           ///< -1: no triangle within the limit; only `distance` = kNoLimit is then valid
  Feature feature = Feature::face;
  int featureIndex = -1;       ///< see Feature
  Vec3 point = Vec3::Zero();   ///< on the mesh, m
  double distance = kNoLimit;  ///< m
  Vec3 normal = Vec3::Zero();  ///< outward unit normal; only from signedDistance()
};

/// Return the point of the mesh nearest to p: argmin |p - x|. Of equally near triangles the one with the smallest
/// number counts. The distance is accurate to about 1e-15 of the mesh size, also for triangles without area.
/// - `limit`, m: triangles farther away are not reported.
/// - `cache` may be null.
///
/// Realtime: yes (no allocation; if the distance is large compared with the mesh's features, it may visit many
/// triangles).
SurfacePoint closestPoint(const MeshModel& model, const Vec3& p, ProximityCache* cache = nullptr,
                          double limit = kNoLimit) noexcept;

/// Return closestPoint() with sign (negative inside) and outward unit normal.
///
/// Sound mesh (isSound()): the sign is exact. It is the sign of (p - x).n with the angle-weighted pseudonormal n of the
/// face, edge or corner at x. Source: Baerentzen & Aanaes, "Signed distance computation using the angle weighted
/// pseudonormal", 2005.
///
/// Any other mesh: the inside is where the generalised winding number w is above 1/2 (Jacobson et al. 2013). Points
/// outside the bounding box are outside.
/// - w is approximate (Barill et al. 2018). If w is within 1e-3 of 1/2, either sign is possible.
/// - At an opening the sign changes where w passes 1/2. The signed distance jumps there from d to -d, with d the
///   distance from the mesh.
/// - A moving tool should use followContacts(), which needs no sign.
///
/// Orientation: triangles are counterclockwise as seen from outside. A mesh counts as reversed if its volume is
/// negative for every way to close its openings. Any other open mesh counts as it is.
///
/// Realtime: yes, as closestPoint(). w takes 10 us, or 100 us near 1/2. The cache keeps it while the point moves by
/// less than about 0.4 of its distance.
SurfacePoint signedDistance(const MeshModel& model, const Vec3& p, ProximityCache* cache = nullptr,
                            double limit = kNoLimit) noexcept;

/// Result of trianglesWithin().
struct TriangleCount {
  Status status = Status::ok;  ///< notFinite: p or the radius; outOfRange: a negative number
  int found = 0;               ///< number of all triangles found; may exceed the capacity
};

/// Find all triangles within `radius` (m) of p, borders included, and write their numbers to `triangles` in rising
/// order. If there are more than `capacity`, only the smallest numbers are written. Realtime: yes.
TriangleCount trianglesWithin(const MeshModel& model, const Vec3& p, double radius, int* triangles,
                              int capacity) noexcept;

/// Instruction sets that the query loops support.
enum class SimdLevel : int { baseline, avx2, avx512 };

/// Return the level in use. It starts as the best level of this processor. Realtime: yes.
SimdLevel simdLevel() noexcept;

/// Set the level for the whole process, for tests and measurements, and return the level in use. Results do not depend
/// on it. A level above the processor's best is lowered to that. Do not call it while queries run.
SimdLevel useSimdLevel(SimdLevel level) noexcept;

}  // namespace enamel
