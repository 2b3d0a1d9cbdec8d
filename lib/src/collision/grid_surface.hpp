// The surface in a grid of samples, by marching tetrahedra.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>

#include "enamel/collision/mesh.hpp"
#include "tetrahedra.hpp"

namespace enamel::kernel {

/// Return the mesh where the samples are 0. It is closed if no sample at the border is inside.
/// - `value(sample)`: negative inside; the first axis is the fastest;
/// - `place(grid)`: position of a point of the grid, m.
template <typename Value, typename Place>
TriangleMesh surfaceOfGrid(const std::array<int, 3>& size, const Value& value, const Place& place) {
  const std::size_t row = static_cast<std::size_t>(size[0]), slice = row * static_cast<std::size_t>(size[1]);
  TriangleMesh mesh;
  std::unordered_map<std::uint64_t, int> vertices;  // by sample and direction of an edge
  for (int z = 0; z + 1 < size[2]; ++z)
    for (int y = 0; y + 1 < size[1]; ++y)
      for (int x = 0; x + 1 < size[0]; ++x) {
        const std::size_t first =
            static_cast<std::size_t>(x) + static_cast<std::size_t>(y) * row + static_cast<std::size_t>(z) * slice;
        const auto sampleOf = [&](int corner) {
          return first + static_cast<std::size_t>(corner & 1) + static_cast<std::size_t>(corner >> 1 & 1) * row +
                 static_cast<std::size_t>(corner >> 2) * slice;
        };
        std::array<double, 8> values;
        int inside = 0;
        for (int corner = 0; corner < 8; ++corner) {
          values[static_cast<std::size_t>(corner)] = value(sampleOf(corner));
          inside += values[static_cast<std::size_t>(corner)] < 0.0;
        }
        if (inside == 0 || inside == 8) continue;
        const auto on = [&](int from, int to) {
          const int low = from & to, high = from | to;
          const auto [entry, isNew] = vertices.try_emplace(8 * sampleOf(low) + static_cast<std::uint64_t>(low ^ high),
                                                           static_cast<int>(mesh.vertices.size()));
          if (isNew) {
            const double a = values[static_cast<std::size_t>(low)], b = values[static_cast<std::size_t>(high)];
            const double t = std::clamp(a / (a - b), kEnd, 1.0 - kEnd);
            const auto corner = [&](int c) { return Vec3(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)); };
            mesh.vertices.push_back(place((1.0 - t) * corner(low) + t * corner(high)));
          }
          return entry->second;
        };
        addTriangles([&](int corner) { return values[static_cast<std::size_t>(corner)] < 0.0; }, on,
                     [&](int a, int b, int c) {
                       mesh.triangles.push_back({a, b, c});
                     });
      }
  return mesh;
}

}  // namespace enamel::kernel
