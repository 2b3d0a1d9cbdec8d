// Local minima of the distance from a point to a mesh.
#pragma once

#include <array>

#include "mesh_data.hpp"

namespace enamel::kernel {

/// A local minimum of the distance from a point.
struct Minimum {
  Vec3 point, normal;
  double distance;
  int triangle;
  Feature feature;
  int featureIndex;
};

/// The nearest minima, sorted by distance, then by triangle, so that the order of the search does not matter.
struct Minima {
  static constexpr int kMost = 64;
  std::array<Minimum, kMost> all;
  int count = 0;
};

/// Find all minima around p within `reach`, m. Returns the nearest point of all triangles within reach, as
/// Loops::closest does.
Answer findMinima(const MeshData& data, const Vec3& p, double reach, Minima& minima) noexcept;

}  // namespace enamel::kernel
