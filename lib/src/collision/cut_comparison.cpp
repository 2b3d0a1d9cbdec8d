#include "enamel/collision/cut_comparison.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "mesh_data.hpp"
#include "solid_query.hpp"

namespace enamel {
namespace {

constexpr double kFloor = 0.7071067811865476;  // cosine between a floor's normal and the axis
constexpr double kPercentile = 0.95;

// A distance and the area where it is.
struct Patch {
  double distance, area;
};

void addDistances(std::vector<Patch> patches, CutDifference& difference) {
  std::sort(patches.begin(), patches.end(),
            [](const Patch& a, const Patch& b) { return std::abs(a.distance) < std::abs(b.distance); });
  for (const Patch& patch : patches) {
    difference.area += patch.area;
    difference.mean += patch.area * std::abs(patch.distance);
    difference.deepest = std::max(difference.deepest, -patch.distance);
    difference.highest = std::max(difference.highest, patch.distance);
  }
  if (difference.area > 0.0) difference.mean /= difference.area;
  double below = 0.0;
  for (const Patch& patch : patches) {
    below += patch.area;
    difference.p95 = std::abs(patch.distance);
    if (below >= kPercentile * difference.area) break;
  }
}

std::vector<double> areasOf(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vec3 ab = mesh.vertices[static_cast<std::size_t>(t[1])] - a,
               ac = mesh.vertices[static_cast<std::size_t>(t[2])] - a;
    for (const int v : t) areas[static_cast<std::size_t>(v)] += ab.cross(ac).norm() / 6.0;
  }
  return areas;
}

class Comparison {
 public:
  Comparison(const Solid& cut, const MeshModel& target, const Vec3& axis)
      : cut_(cut), uncut_(cut), target_(target), axis_(axis) {
    uncut_.restore();
  }

  CutComparison result() {
    for (int brick = 0; brick < cut_.bricks(); ++brick) addVolumes(brick);
    for (std::size_t k = 0; k < kMaxSolidLayers; ++k) {
      result_.whole.overCut[k] = result_.floors.overCut[k] + result_.walls.overCut[k];
      result_.whole.underCut[k] = result_.floors.underCut[k] + result_.walls.underCut[k];
    }
    addSurface();
    return std::move(result_);
  }

 private:
  bool isFloor(const SurfacePoint& nearest) const { return nearest.normal.dot(axis_) > kFloor; }

  void addVolumes(int brick) {
    const Vec3 low = cut_.lowOf(brick), place = ((low - cut_.low()) / cut_.cell()).array().round();
    kernel::sampleMesh(target_, cut_.low(), cut_.cell(), place, cache_, samples_);
    const double cellVolume = std::pow(cut_.cell(), 3);
    for (int z = 0; z < kBrickCells; ++z)
      for (int y = 0; y < kBrickCells; ++y)
        for (int x = 0; x < kBrickCells; ++x) {
          const double whole = kernel::filledShare(uncut_.samples(brick), x, y, z),
                       now = kernel::filledShare(cut_.samples(brick), x, y, z);
          if (!(whole > 0.0)) continue;
          const double planned = std::min(whole, kernel::filledShare(samples_, x, y, z));
          const Vec3 corner = low + cut_.cell() * Vec3(x, y, z);
          const auto layer = static_cast<std::size_t>(cut_.layerAt(corner));
          result_.removed[layer] += cellVolume * (whole - now);
          result_.planned[layer] += cellVolume * (whole - planned);
          if (now == planned) continue;
          const SurfacePoint nearest = signedDistance(target_, corner + Vec3::Constant(0.5 * cut_.cell()), &cache_);
          CutDifference& region = isFloor(nearest) ? result_.floors : result_.walls;
          (now < planned ? region.overCut : region.underCut)[layer] += cellVolume * std::abs(planned - now);
        }
  }

  void addSurface() {
    result_.surface = surfaceOf(cut_);
    const std::vector<double> areas = areasOf(result_.surface);
    std::vector<Patch> floors, walls;
    for (std::size_t v = 0; v < areas.size(); ++v) {
      const Vec3& p = result_.surface.vertices[v];
      const SurfacePoint nearest = signedDistance(target_, p, &cache_);
      const bool isPrepared =
          std::abs(nearest.distance) > cut_.cell() || !(std::abs(signedDistance(uncut_, p).distance) <= cut_.cell());
      result_.distance.push_back(nearest.distance);
      result_.isPrepared.push_back(isPrepared ? 1 : 0);
      if (isPrepared) (isFloor(nearest) ? floors : walls).push_back({nearest.distance, areas[v]});
    }
    addDistances(floors, result_.floors);
    addDistances(walls, result_.walls);
    floors.insert(floors.end(), walls.begin(), walls.end());
    addDistances(std::move(floors), result_.whole);
  }

  const Solid& cut_;
  Solid uncut_;
  const MeshModel& target_;
  Vec3 axis_;
  ProximityCache cache_;
  BrickSamples samples_;
  CutComparison result_;
};

}  // namespace

CutComparison compareCut(const Solid& cut, const MeshModel& target, const Vec3& axis) {
  if (!kernel::Inside::of(target).closed)
    throw Error("the target of a preparation must be closed; this mesh has open edges");
  if (!(axis.norm() > 0.0 && axis.allFinite())) throw Error("the axis of a preparation is zero or not finite");
  return Comparison(cut, target, axis.normalized()).result();
}

}  // namespace enamel
