// The part of a surface that a nearest point lies on.
#pragma once

#include <cstdint>

namespace enamel {

/// Where a point lies on a triangle or a shape. Answers that hold one say which with an index:
/// - triangle: edge i joins its corners i and (i + 1) % 3, vertex i is its corner i; of a face -1
/// - box: sum of 3^k (1 + s_k) over the axes k = 0, 1, 2, where s_k is the side of the box along that axis, -1 or 1, or
/// 0
///   where the feature extends along it
/// - all other shapes are one face, -1
enum class Feature : std::uint8_t { face, edge, vertex };

}  // namespace enamel
