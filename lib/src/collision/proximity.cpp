#include "enamel/collision/proximity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "cones.hpp"
#include "enamel/core/error.hpp"
#include "hierarchy.hpp"
#include "normals.hpp"
#include "sign.hpp"
#include "winding.hpp"

namespace enamel {
namespace kernel {
namespace {

#include "exact.inl"

const Loops& loopsOf(SimdLevel level) noexcept {
#ifdef ENAMEL_X86_KERNELS
  if (level == SimdLevel::avx512) return kAvx512Loops;
  if (level == SimdLevel::avx2) return kAvx2Loops;
#endif
  (void)level;
  return kBaselineLoops;
}

SimdLevel bestLevel() noexcept {
#ifdef ENAMEL_X86_KERNELS
  if (__builtin_cpu_supports("avx512f")) return SimdLevel::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return SimdLevel::avx2;
#endif
  return SimdLevel::baseline;
}

// Relaxed is enough: all levels give the same answers.
std::atomic<SimdLevel>& chosenLevel() noexcept {
  static std::atomic<SimdLevel> level{bestLevel()};
  return level;
}

Vec3 cornerOf(const Triangle& t, int i) { return {t.corner[i][0], t.corner[i][1], t.corner[i][2]}; }

// Where triangles without area meet, the normals of their neighbours do not add up along the edges of the mesh. Then
// all triangles through the point x count, connected or not: faces with 2 pi, edges with pi, corners with their angle.
struct NormalSum {
  const MeshData* data;
  double p[3];
  Vec3 x;
  double tolerance;
  Vec3 sum = Vec3::Zero();
};

double addNormal(void* context, std::int32_t slot, double reach) {
  auto& all = *static_cast<NormalSum*>(context);
  const Triangle& t = all.data->triangles[slot];
  Candidate c;
  closestOnTriangle(&t, all.p, &c);
  if (std::sqrt(c.squared) > reach || (Vec3(c.point[0], c.point[1], c.point[2]) - all.x).norm() > all.tolerance)
    return reach;
  const Vec3 a = cornerOf(t, 0), b = cornerOf(t, 1), d = cornerOf(t, 2);
  const Vec3 normal = unitNormal(a, b, d);
  double angle = 2.0 * M_PI;
  if (c.feature == kCorner0) angle = cornerAngle(a, b, d);
  if (c.feature == kCorner1) angle = cornerAngle(b, d, a);
  if (c.feature == kCorner2) angle = cornerAngle(d, a, b);
  if (c.feature >= kEdge01 && c.feature <= kEdge20) angle = M_PI;
  all.sum += angle * normal;
  return reach;
}

Vec3 gatheredNormal(const MeshData& data, const Vec3& p, const Vec3& x, double distance) {
  NormalSum all{&data, {p[0], p[1], p[2]}, x, 1e-9 * data.size};
  loops().visit(data.view, all.p, all.p, distance * (1.0 + 1e-12) + 1e-11 * data.size, &addNormal, &all);
  return all.sum;
}

Vec3 normalOf(const Triangle& t) { return (cornerOf(t, 1) - cornerOf(t, 0)).cross(cornerOf(t, 2) - cornerOf(t, 0)); }

// Pseudonormal at the location of the nearest point, not normalised.
Vec3 pseudonormal(const MeshData& data, const Vec3& p, const Vec3& x, double distance, std::int32_t slot,
                  std::int32_t feature) {
  const Triangle& t = data.triangles[slot];
  if (feature == kFace) return normalOf(t);
  if ((data.tainted[slot] >> feature & 1) != 0) return gatheredNormal(data, p, x, distance);
  return normalAround(data, t.index, feature);
}

}  // namespace

const Loops& loops() noexcept { return loopsOf(chosenLevel().load(std::memory_order_relaxed)); }

}  // namespace kernel

SimdLevel simdLevel() noexcept { return kernel::chosenLevel().load(std::memory_order_relaxed); }

SimdLevel useSimdLevel(SimdLevel level) noexcept {
  const SimdLevel best = kernel::bestLevel();
  if (static_cast<int>(level) > static_cast<int>(best)) level = best;
  kernel::chosenLevel().store(level, std::memory_order_relaxed);
  return level;
}

MeshModel::MeshModel(TriangleMesh mesh, SpareCapacity spare) {
  checkMesh(mesh);
  const auto checkSpare = [](std::size_t present, int more, const char* things) {
    if (more < 0 || static_cast<std::size_t>(more) > kMostTriangles - std::min(present, kMostTriangles))
      throw Error("the spare capacity is " + std::to_string(more) + " " + things + " in addition to " +
                  std::to_string(present) + ", must be at least 0 and the sum at most " +
                  std::to_string(kMostTriangles));
  };
  checkSpare(mesh.vertices.size(), spare.vertices, "vertices");
  checkSpare(mesh.triangles.size(), spare.triangles, "triangles");
  data_ = std::make_unique<kernel::MeshData>();
  data_->mesh = std::move(mesh);
  data_->mesh.vertices.shrink_to_fit();
  data_->mesh.triangles.shrink_to_fit();
  kernel::buildHierarchy(*data_, spare.triangles);
  const std::vector<kernel::EdgeUse> edges = kernel::buildTopology(*data_);
  const std::vector<Vec3> normals = kernel::unitNormals(data_->mesh);
  kernel::markWithoutNormal(*data_, edges, normals);
  kernel::buildCones(*data_, edges, normals);
  kernel::buildWinding(*data_);
  kernel::chooseSign(*data_, edges);
  kernel::reserveForUpdates(*data_, spare.vertices);
}

MeshModel::MeshModel(MeshModel&&) noexcept = default;
MeshModel& MeshModel::operator=(MeshModel&&) noexcept = default;
MeshModel::~MeshModel() = default;

const TriangleMesh& MeshModel::mesh() const noexcept { return data_->mesh; }

bool isSound(const MeshModel& model) noexcept { return kernel::Inside::of(model).sound; }

TriangleMesh presentMesh(const MeshModel& model) {
  const kernel::MeshData& data = kernel::Inside::of(model);
  TriangleMesh mesh;
  mesh.vertices = data.mesh.vertices;
  for (std::size_t t = 0; t < data.mesh.triangles.size(); ++t)
    if (kernel::hasTriangle(data, static_cast<std::int32_t>(t))) mesh.triangles.push_back(data.mesh.triangles[t]);
  return mesh;
}

std::string describe(const MeshModel& model) {
  const kernel::MeshData& data = kernel::Inside::of(model);
  const TriangleMesh mesh = presentMesh(model);
  if (mesh.triangles.empty()) return "has no triangles left";
  const MeshReport report = inspect(mesh);
  std::string what;
  const auto add = [&what](int count, const char* things) {
    if (count > 0) what += (what.empty() ? "" : ", ") + std::to_string(count) + things;
  };
  add(report.boundaryEdges, report.boundaryEdges == 1 ? " boundary edge" : " boundary edges");
  add(report.nonManifoldEdges, report.nonManifoldEdges == 1 ? " non-manifold edge" : " non-manifold edges");
  add(report.flippedEdges, report.flippedEdges == 1 ? " edge between triangles of opposite orientation"
                                                    : " edges between triangles of opposite orientation");
  what = (data.closed ? "watertight" : "open") + (what.empty() ? "" : " (" + what + ")");
  if (data.crossesItself) what += ", crosses itself";
  if (data.inwards) what += ", normals point inwards (they are reversed)";
  if (data.sound) return what + ": the sign of distances is exact";
  return what + ": points with a winding number above 1/2 are inside; a moving tool keeps its side without this rule";
}

ProximityCache::ProximityCache() : content_(std::make_unique<kernel::Cache>()) {}

ProximityCache::ProximityCache(const ProximityCache& other)
    : content_(other.content_ ? std::make_unique<kernel::Cache>(*other.content_) : nullptr) {}

ProximityCache& ProximityCache::operator=(const ProximityCache& other) {
  if (content_ && other.content_)
    *content_ = *other.content_;
  else
    *this = ProximityCache(other);
  return *this;
}

ProximityCache::ProximityCache(ProximityCache&&) noexcept = default;
ProximityCache& ProximityCache::operator=(ProximityCache&&) noexcept = default;
ProximityCache::~ProximityCache() = default;

SurfacePoint kernel::surfacePoint(const MeshData& data, const Answer& found) noexcept {
  SurfacePoint answer;
  const Candidate& nearest = found.nearest;
  answer.point = {nearest.point[0], nearest.point[1], nearest.point[2]};
  if (found.slot < 0) return answer;
  answer.triangle = data.triangles[found.slot].index;
  setFeature(nearest.feature, answer);
  answer.distance = std::sqrt(nearest.squared);
  return answer;
}

SurfacePoint kernel::signedSurfacePoint(const MeshData& data, const Vec3& p, const Answer& found, Cache* cache,
                                        bool isOutside) noexcept {
  SurfacePoint answer = surfacePoint(data, found);
  if (found.slot < 0) return answer;
  const Candidate& nearest = found.nearest;
  const double distance = answer.distance;
  const Vec3 away = p - answer.point;
  // All normals around a triangle lie within its cone, and so do their sums. If the offset to the point is clearly on
  // one side of the cone, the triangle's own normal gives the side.
  Vec3 n = Vec3::Zero();
  double side = nearest.overPlane;  // 0 for a long or flat triangle, like n.n: unknown
  const double beyondCone = 1.0 - static_cast<double>(data.triangles[found.slot].cone);
  const bool isApart = distance > 1e-9 * data.size;
  bool inside = false;
  if (isApart && (isOutside || !data.sound || data.edited)) {
    inside = !isOutside && isInside(data, p, distance, cache);
  } else {
    if (!isApart || !(side * side > beyondCone * nearest.squared * nearest.normalSquared)) {
      n = pseudonormal(data, p, answer.point, distance, found.slot, nearest.feature);
      side = away.dot(n);
    }
    inside = (side < 0.0) != data.inwards;
  }
  if (isApart) {
    // Compute 1 / d as d / d^2, so that the division need not wait for the root. Close to the surface the point's
    // rounding affects the length.
    const bool isClear = std::abs(away.squaredNorm() - nearest.squared) <= 1e-10 * nearest.squared;
    const double inverse = isClear ? distance * (1.0 / nearest.squared) : 1.0 / away.norm();
    answer.normal = away * (inside ? -inverse : inverse);
  } else {
    const double length = n.norm();
    answer.normal = length > 0.0 ? Vec3(n / (data.inwards ? -length : length)) : Vec3(Vec3::UnitZ());
  }
  if (inside) answer.distance = -answer.distance;
  return answer;
}

namespace {

bool search(const kernel::MeshData& data, const Vec3& p, kernel::Cache* cache, double limit,
            kernel::Answer& found) noexcept {
  if (!p.allFinite() || !(limit >= 0.0)) return false;
  kernel::loops().closest(data.view, p.data(), limit * limit, cache, &found);
  return true;
}

SurfacePoint refused(double limit) noexcept {
  SurfacePoint answer;
  answer.status = limit < 0.0 ? Status::outOfRange : Status::notFinite;
  return answer;
}

}  // namespace

SurfacePoint kernel::closestPoint(const MeshData& data, const Vec3& p, Cache* cache, double limit) noexcept {
  Answer found;
  return search(data, p, cache, limit, found) ? surfacePoint(data, found) : refused(limit);
}

SurfacePoint kernel::signedDistance(const MeshData& data, const Vec3& p, Cache* cache, double limit,
                                    bool isOutside) noexcept {
  Answer found;
  return search(data, p, cache, limit, found) ? signedSurfacePoint(data, p, found, cache, isOutside) : refused(limit);
}

SurfacePoint closestPoint(const MeshModel& model, const Vec3& p, ProximityCache* cache, double limit) noexcept {
  return kernel::closestPoint(kernel::Inside::of(model), p, kernel::Inside::of(cache), limit);
}

SurfacePoint signedDistance(const MeshModel& model, const Vec3& p, ProximityCache* cache, double limit) noexcept {
  return kernel::signedDistance(kernel::Inside::of(model), p, kernel::Inside::of(cache), limit);
}

namespace {

struct Within {
  const kernel::MeshData* data;
  const double* p;
  int* triangles;
  int capacity, found;
};

// The stored triangles are a heap with the largest number first.
double keepTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<Within*>(context);
  const kernel::Triangle& triangle = s.data->triangles[slot];
  kernel::Candidate c;
  kernel::closestOnTriangle(&triangle, s.p, &c);
  if (!(std::sqrt(c.squared) <= reach)) return reach;
  int count = std::min(s.found++, s.capacity);
  if (count == s.capacity) {
    if (count == 0 || !(triangle.index < s.triangles[0])) return reach;
    std::pop_heap(s.triangles, s.triangles + count--);
  }
  s.triangles[count++] = triangle.index;
  std::push_heap(s.triangles, s.triangles + count);
  return reach;
}

}  // namespace

TriangleCount trianglesWithin(const MeshModel& model, const Vec3& p, double radius, int* triangles,
                              int capacity) noexcept {
  TriangleCount answer;
  if (!p.allFinite() || !std::isfinite(radius) || radius < 0.0 || capacity < 0) {
    answer.status = radius < 0.0 || capacity < 0 ? Status::outOfRange : Status::notFinite;
    return answer;
  }
  Within s{&kernel::Inside::of(model), p.data(), triangles, capacity, 0};
  kernel::loops().visit(s.data->view, p.data(), p.data(), radius, &keepTriangle, &s);
  std::sort_heap(triangles, triangles + std::min(s.found, capacity));
  answer.found = s.found;
  return answer;
}

}  // namespace enamel
