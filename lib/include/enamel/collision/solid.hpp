// A solid that can be cut: its signed distance, sampled on bricks of 8 x 8 x 8 cells. Coordinates are those of the
// solid's own frame, m.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/feature.hpp"
#include "enamel/collision/material.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/sweep.hpp"

namespace enamel {

/// One material layer of a solid, such as enamel, dentine or pulp.
struct SolidLayer {
  std::string name;
  Material material;                        ///< material of the contacts on it
  double hardness = 3e9;                    ///< Vickers hardness: force over area of an indentation, Pa
  double depth = 0.0;                       ///< depth below the surface of the uncut solid at which it begins, m
  std::shared_ptr<const MeshModel> within;  ///< if set: a closed mesh at whose surface it begins instead
  Tap tap = {};                             ///< how the handle vibrates after an impact on it
};

inline constexpr int kMaxSolidLayers = 8;

/// Resolution and undo memory of a solid.
struct SolidOptions {
  double cell = 1e-4;     ///< edge of a cell, m
  int undoBricks = 1024;  ///< room for undo(), in bricks of 3 KB
};

/// Samples of one brick at the corners of its cells, x fastest; the last ones also belong to the next brick. Distances
/// are in cells, negative inside, limited to +-kBand.
inline constexpr int kBrickCells = 8, kBrickSamples = kBrickCells + 1;
using BrickSamples = std::array<float, kBrickSamples * kBrickSamples * kBrickSamples>;

/// Volume that a cut removed, m^3, for each layer.
using RemovedVolume = std::array<double, kMaxSolidLayers>;

/// A solid that can be cut. Its surface is where the trilinear interpolation of the samples is 0. It lies in cells
/// whose corners have both signs, and queries visit only these cells. Samples far from the surface therefore have no
/// effect, and a cut leaves them unchanged.
///
/// Let R be the least curvature radius of a smooth surface and h the size of a cell. Distances then have errors up to
/// about h^2 / (4 R). Parts thinner than a cell may be lost.
///
/// Threads: any number may query the const solid. One thread may cut while no query runs. During a cut only cell(),
/// layers(), low(), high(), lowOf(), brickAt() and layerAt() may be called, because no cut changes their results.
class Solid {
 public:
  /// Sample the distance from a closed mesh, about 1 us a sample near the surface. All bricks with a part of the solid
  /// are allocated here; cuts do not allocate. Realtime: no.
  ///
  /// The first layer is the outermost and begins at the surface. Where several layers overlap, the last one counts.
  ///
  /// Throws Error for:
  /// - a mesh that is not closed, also that of a layer;
  /// - a cell below kSmallestCell, so small that the solid would need more than 1 GB, or so large that nothing remains;
  /// - no layer, or more than kMaxSolidLayers;
  /// - a layer without hardness, or with a depth below that of the layer before;
  /// - a negative `undoBricks`.
  Solid(const MeshModel& surface, const std::vector<SolidLayer>& layers, const SolidOptions& options = {});

  static constexpr double kSmallestCell = 1e-6;  ///< m

  double cell() const noexcept { return cell_; }
  const std::vector<SolidLayer>& layers() const noexcept { return layers_; }
  Vec3 low() const noexcept { return origin_; }  ///< corner of the bounding box, m
  Vec3 high() const noexcept;                    ///< opposite corner, m
  std::size_t bytes() const noexcept;            ///< size in memory
  int bricks() const noexcept { return static_cast<int>(bricks_.size()); }

  /// Return the present volume, m^3, for each layer. Realtime: no, some ms.
  RemovedVolume volume() const;

  /// Remove the volume that a capsule of `radius` (m) sweeps while its axis moves from `from` to `to`. The volume at
  /// `from` must be cut already. Returns the removed volume. Realtime: yes, some ms at most.
  ///
  /// `reached` is the fraction of the way that was cut. It is below 1 if the call stopped after 4096 bricks: continue
  /// from there at the next tick. The call removes nothing and sets `reached` to 0 if:
  /// - a value is not finite;
  /// - the radius is not above 0, or above kLargestBur;
  /// - the axis is longer than 100 mm;
  /// - an end moves by more than 20 mm.
  ///
  /// Only samples within reach are visited. All others keep their side, to an accuracy of h^2 / (12 radius). The
  /// returned volume is approximate: the sum of many cuts has a relative error of about h^2 / radius^2. volume() is
  /// exact.
  RemovedVolume cut(const Segment& from, const Segment& to, double radius, double* reached = nullptr) noexcept;
  static constexpr double kLargestBur = 5e-3;  ///< radius, m

  /// Begin a new step of undo(). Realtime: yes.
  void mark() noexcept;
  /// Restore the material of the last step that was not undone. Return false if nothing was cut or the room for undo
  /// was too small. Realtime: yes, 0.2 us a brick.
  bool undo() noexcept;
  /// Restore all material. Realtime: yes, some ms.
  void restore() noexcept;
  /// Return a number that grows whenever material is restored. Realtime: yes.
  std::uint64_t restorations() const noexcept { return restorations_; }

  /// Return the next changed brick and remove it from the list of changes; -1: the list is empty. Realtime: yes.
  int takeChanged() noexcept;
  const BrickSamples& samples(int brick) const noexcept { return bricks_[static_cast<std::size_t>(brick)].samples; }
  /// Replace the samples of a brick by those of another solid with the same mesh and cells, to follow the cuts of
  /// that solid (BrickChange). undo() does not restore them. Realtime: yes, 0.2 us.
  void set(int brick, const BrickSamples& samples) noexcept;
  Vec3 lowOf(int brick) const noexcept;  ///< corner of the brick, m
  /// Return the brick at a point; -1: no brick is there. Realtime: yes.
  int brickAt(const Vec3& p) const noexcept;
  /// Return the layer of the sample nearest to a point. Realtime: yes.
  int layerAt(const Vec3& p) const noexcept;

  static constexpr float kBand = 2.5f;  ///< cells; larger distances are stored as this value

 private:
  friend struct SolidFile;
  friend struct SolidQuery;
  struct Brick {
    BrickSamples samples;
    std::array<std::uint8_t, kBrickCells * kBrickCells * kBrickCells> layer;  // of samples of this brick only
    std::array<std::uint64_t, kBrickCells> surface;  // bit x + 8 y of entry z: the cell contains surface
    std::array<std::int32_t, 3> place;               // position among the bricks
    std::uint64_t marked = 0;                        // last mark at which the brick was saved for undo
    bool isChanged = false;
  };
  struct Capsule;
  struct Kept {
    std::int32_t brick = -1;
    std::uint64_t mark = 0;
    BrickSamples samples;
  };

  std::int32_t brickAt(int x, int y, int z) const noexcept { return index_[(z * count_[1] + y) * count_[0] + x]; }
  Solid() = default;  // for SolidFile
  void prepare(int undoBricks);
  void fill(const MeshModel& surface, const std::vector<std::array<int, 3>>& places);
  void keep(Brick& brick) noexcept;
  void tellChanged(std::int32_t brick) noexcept;
  void findSurface(Brick& brick) noexcept;
  int cutCapsule(const Segment& axis, double radius, RemovedVolume& removed) noexcept;
  void cutBrick(std::int32_t number, const Capsule& capsule, RemovedVolume& removed) noexcept;

  double cell_ = 0.0;
  std::vector<SolidLayer> layers_;
  Vec3 origin_ = Vec3::Zero();
  std::array<int, 3> count_{};       // bricks along the axes
  std::vector<std::int32_t> index_;  // brick numbers; -1: no brick
  std::vector<Brick> bricks_;
  std::vector<BrickSamples> original_;
  std::vector<std::uint8_t> hasSurface_;  // for each brick; queries read it far more often than the brick itself
  std::vector<Kept> kept_;                // a ring buffer
  std::size_t keptBegin_ = 0, keptCount_ = 0;
  std::uint64_t mark_ = 1, lostMark_ = 0;  // marks up to lostMark_ cannot be undone
  std::vector<std::int32_t> changed_;      // a ring buffer with room for all bricks
  std::size_t changedBegin_ = 0, changedCount_ = 0;
  std::uint64_t restorations_ = 1;
};

/// A point on the surface of a solid.
struct SolidPoint {
  bool found = false;           ///< true if a point is within the limit; otherwise only `distance` = kNoLimit is valid
  Vec3 point = Vec3::Zero();    ///< on the surface, m
  Vec3 normal = Vec3::UnitZ();  ///< outward unit normal
  double distance = kNoLimit;   ///< m; negative inside (only from signedDistance())
  double parameter = 0.0;       ///< position on the segment of the query, 0 to 1
  int layer = 0;                ///< layer just below the surface
  Feature feature = Feature::face;
  int featureIndex = -1;
};

/// The cell where a query found its answer. The next query near it searches that cell first. This saves time and does
/// not change the answer, also after a cut.
struct SolidCache {
  std::uint32_t cell = ~0u;
};

/// Return the point of the surface nearest to p and its signed distance, negative inside. Points farther than `limit`
/// (m) are not reported. A p that is not finite gives no point. Realtime: yes.
SolidPoint signedDistance(const Solid& solid, const Vec3& p, double limit = kNoLimit,
                          SolidCache* cache = nullptr) noexcept;

/// Return the nearest points of the surface and a segment. The distance is never negative. Realtime: yes.
SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit = kNoLimit) noexcept;

/// Return true if p is inside. Realtime: yes.
bool isInside(const Solid& solid, const Vec3& p) noexcept;

}  // namespace enamel
