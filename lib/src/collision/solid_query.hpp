// What other parts of the module ask of a solid beside its public queries.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/collision/solid.hpp"

namespace enamel::kernel {

inline constexpr int kMaxSolidMinima = 8;

/// Local minima of the distance from a point, of minima within 30 deg the nearest one; the nearest first.
struct SolidMinima {
  std::array<SolidPoint, kMaxSolidMinima> all;
  int count = 0;
};

/// Those nearer than `reach` to a point outside of the solid. Realtime: yes.
void findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept;

/// Cells of a brick with corners on both sides: bit x + 8 y of entry z. Realtime: yes.
std::array<std::uint64_t, kBrickCells> surfaceCells(const BrickSamples& samples) noexcept;

}  // namespace enamel::kernel
