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

/// One of the materials that a solid is made of, such as enamel, dentine, pulp.
struct SolidLayer {
  std::string name;
  Material material;                        ///< what the contacts on it carry
  double hardness = 3e9;                    ///< force per area that indents it (Vickers), Pa
  double depth = 0.0;                       ///< it begins so far below the surface of the uncut solid, m
  std::shared_ptr<const MeshModel> within;  ///< if any: it begins at the surface of this closed mesh instead
};

inline constexpr int kMaxSolidLayers = 8;

/// Sizes of a solid.
struct SolidOptions {
  double cell = 1e-4;     ///< edge of a cell, m
  int undoBricks = 1024;  ///< room for what undo() needs, in bricks of 3 KB
};

/// Samples of one brick: the corners of its cells, x fastest, the last ones those of the next brick too. In cells,
/// negative inside, within +-kBand.
inline constexpr int kBrickCells = 8, kBrickSamples = kBrickCells + 1;
using BrickSamples = std::array<float, kBrickSamples * kBrickSamples * kBrickSamples>;

/// What a cut took away, m^3, by layer.
using RemovedVolume = std::array<double, kMaxSolidLayers>;

/// The surface is where the trilinear interpolation of the samples is 0: cells whose corners have both signs hold it,
/// and queries look at these cells only. So nothing depends on samples far from it, which a cut leaves as they are.
/// Distances of a smooth surface with the least curvature radius R are off by up to about h^2 / (4 R) for cells of h;
/// what is thinner than a cell may be lost. Queries: const, any number of threads. Cuts: one thread, no query
/// meanwhile but cell(), layers(), low(), high(), lowOf(), brickAt() and layerAt(), which no cut changes.
class Solid {
 public:
  /// Samples the distance from a closed mesh; every brick that holds a part of it is allocated now, cuts never are.
  /// About 1 us a sample near the surface. Layers: the outermost first, at the surface; where several begin, the last
  /// one counts. Throws Error: a mesh that is not closed; a cell below kSmallestCell, or so small that the solid would
  /// take more than 1 GB; no layer, more than kMaxSolidLayers, one without hardness or with a depth below that of the
  /// one before; an undo room that is negative. Realtime: no.
  Solid(const MeshModel& surface, const std::vector<SolidLayer>& layers, const SolidOptions& options = {});

  static constexpr double kSmallestCell = 1e-6;  ///< m

  double cell() const noexcept { return cell_; }
  const std::vector<SolidLayer>& layers() const noexcept { return layers_; }
  Vec3 low() const noexcept { return origin_; }  ///< corner of the box that holds it
  Vec3 high() const noexcept;                    ///< opposite corner
  std::size_t bytes() const noexcept;            ///< of memory
  int bricks() const noexcept { return static_cast<int>(bricks_.size()); }

  /// What is there now, m^3, by layer. Realtime: no, some ms.
  RemovedVolume volume() const;

  /// Remove what a capsule sweeps whose axis moves from one place to another; it has cut at the first. Only samples
  /// within reach are visited; no other sample changes its side, to h^2 / (12 radius). Removes nothing, with a
  /// `reached` of 0, if a value is not finite, the radius is outside 0 to kLargestBur, the axis is longer than 100 mm,
  /// or an end moves by more than 20 mm. `reached` is the share of the way that was cut. It is below 1 if the call
  /// stopped after 4096 bricks of 8 cells: continue from there at the next tick. Returns about what was removed: the
  /// sum of many cuts is off by some h^2 / radius^2 of itself, volume() is exact. Realtime: yes, some ms at most.
  RemovedVolume cut(const Segment& from, const Segment& to, double radius, double* reached = nullptr) noexcept;
  static constexpr double kLargestBur = 5e-3;  ///< radius, m

  /// What is cut from now on is one step of undo(). Realtime: yes.
  void mark() noexcept;
  /// Puts back what was cut since the last mark() that was not undone; false: nothing was, or the room for it did not
  /// do. Realtime: yes, 0.2 us a brick.
  bool undo() noexcept;
  /// Puts everything back. Realtime: yes, some ms.
  void restore() noexcept;
  /// A number that grows whenever material comes back. Realtime: yes.
  std::uint64_t restorations() const noexcept { return restorations_; }

  /// The next brick that has changed since it was asked for, -1: none. Realtime: yes.
  int takeChanged() noexcept;
  const BrickSamples& samples(int brick) const noexcept { return bricks_[static_cast<std::size_t>(brick)].samples; }
  Vec3 lowOf(int brick) const noexcept;  ///< corner of the brick, m
  /// The brick that holds a point, -1: none does. Realtime: yes.
  int brickAt(const Vec3& p) const noexcept;
  /// Layer of the sample nearest to a point. Realtime: yes.
  int layerAt(const Vec3& p) const noexcept;

  static constexpr float kBand = 2.5f;  ///< cells; samples farther from the surface have this distance

 private:
  friend struct SolidQuery;
  struct Brick {
    BrickSamples samples;
    std::array<std::uint8_t, kBrickCells * kBrickCells * kBrickCells> layer;  // of the samples that no other one has
    std::array<std::uint64_t, kBrickCells> surface;  // bit x + 8 y of entry z: the cell holds it
    std::array<std::int32_t, 3> place;               // among the bricks
    std::uint64_t marked = 0;                        // the mark since which it was kept
    bool isChanged = false;
  };
  struct Kept {
    std::int32_t brick = -1;
    std::uint64_t mark = 0;
    BrickSamples samples;
  };

  std::int32_t brickAt(int x, int y, int z) const noexcept { return index_[(z * count_[1] + y) * count_[0] + x]; }
  void fill(const MeshModel& surface, const std::vector<std::array<int, 3>>& places);
  void keep(Brick& brick) noexcept;
  void tellChanged(std::int32_t brick) noexcept;
  void findSurface(Brick& brick) noexcept;
  void put(std::int32_t brick, const BrickSamples& samples) noexcept;
  int cutCapsule(const Segment& axis, double radius, RemovedVolume& removed) noexcept;

  double cell_;
  std::vector<SolidLayer> layers_;
  Vec3 origin_ = Vec3::Zero();
  std::array<int, 3> count_{};       // bricks along the axes
  std::vector<std::int32_t> index_;  // of the bricks, -1: outside
  std::vector<Brick> bricks_;
  std::vector<BrickSamples> original_;
  std::vector<std::uint8_t> hasSurface_;  // by brick: queries ask it far more often than the brick
  std::vector<Kept> kept_;                // a ring
  std::size_t keptBegin_ = 0, keptCount_ = 0;
  std::uint64_t mark_ = 1, lostMark_ = 0;  // marks up to lostMark_ cannot be undone
  std::vector<std::int32_t> changed_;      // a ring with room for all
  std::size_t changedBegin_ = 0, changedCount_ = 0;
  std::uint64_t restorations_ = 1;
};

/// Place on the surface of a solid.
struct SolidPoint {
  bool found = false;           ///< something lies within the limit; else only the distance, kNoLimit, has a meaning
  Vec3 point = Vec3::Zero();    ///< on the surface, m
  Vec3 normal = Vec3::UnitZ();  ///< outward unit normal
  double distance = kNoLimit;   ///< m; from signedDistance() negative inside
  double parameter = 0.0;       ///< of the segment that was asked for
  int layer = 0;                ///< just below the surface there
  Feature feature = Feature::face;
  int featureIndex = -1;
};

/// The point of the surface nearest to p, and how far away it is; negative inside. `limit`, m: nothing beyond is looked
/// for. Points that are not finite find nothing. Realtime: yes.
SolidPoint signedDistance(const Solid& solid, const Vec3& p, double limit = kNoLimit) noexcept;

/// Nearest points of the surface and a segment: distance not negative. Realtime: yes.
SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit = kNoLimit) noexcept;

/// Whether p lies inside. Realtime: yes.
bool isInside(const Solid& solid, const Vec3& p) noexcept;

}  // namespace enamel
