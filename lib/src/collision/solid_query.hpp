// Queries of a solid for other parts of the module, besides the public ones.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/collision/solid.hpp"
#include "kernel.hpp"

namespace enamel::kernel {

inline constexpr int kMaxSolidMinima = KnownMinima::kMost;
inline constexpr double kMostSolidBytes = 1e9, kMostSolidPlaces = 1 << 22;  // in memory; of bricks

/// Local minima of the distance from a point, nearest first. Of minima within 30 deg only the nearest is kept.
struct SolidMinima {
  std::array<SolidPoint, kMaxSolidMinima> all;
  int count = 0;
};

/// Find the minima nearer than `reach` to a point outside of the solid. Realtime: yes.
void findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept;

/// Search the cell of the last answer first. Of places that are equally near, another one may be found than without it.
/// Realtime: yes.
SolidPoint closestToSegment(const Solid& solid, const Segment& segment, double limit, SolidCache& cache) noexcept;

/// Return the cells of a brick with corners on both sides: bit x + 8 y of entry z. Realtime: yes.
std::array<std::uint64_t, kBrickCells> surfaceCells(const BrickSamples& samples) noexcept;

/// Throw Error for a layer with a number out of range, except its depth.
void checkLayer(const SolidLayer& layer);

/// Sample the distance from a closed mesh for the brick with its corner `corner` cells from `origin`, as Solid does.
void sampleMesh(const MeshModel& mesh, const Vec3& origin, double cell, const Vec3& corner, ProximityCache& cache,
                BrickSamples& samples);

/// Return the share of a cell that is inside, as Solid::volume() counts it.
double filledShare(const BrickSamples& samples, int x, int y, int z) noexcept;

}  // namespace enamel::kernel
