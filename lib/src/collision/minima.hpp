// The local minima of the distance from a point to a mesh.
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

/// The nearest minima, whatever the order in which they are found: by distance, then by triangle.
struct Minima {
  static constexpr int kMost = 64;
  std::array<Minimum, kMost> all;
  int count = 0;
};

/// All minima about p within `reach`, m. Answers the nearest point of all triangles within reach, as Loops::closest.
Answer findMinima(const MeshData& data, const Vec3& p, double reach, Minima& minima) noexcept;

}  // namespace enamel::kernel
