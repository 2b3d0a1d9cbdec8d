// The part of a surface at a nearest point.
#pragma once

#include <cstdint>

namespace enamel {

/// Feature of a triangle or shape on which a point lies. Results add an index:
/// - triangle: edge i joins the corners i and (i + 1) % 3; vertex i is corner i; a face has -1.
/// - box: the sum of 3^k (1 + s_k) over the axes k = 0, 1, 2. s_k is the side of the box along axis k, -1 or 1. It is
///   0 if the feature extends along that axis.
/// - other shapes: one face, -1.
enum class Feature : std::uint8_t { face, edge, vertex };

}  // namespace enamel
