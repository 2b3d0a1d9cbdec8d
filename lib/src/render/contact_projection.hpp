// Projection onto the free space: min |y|^2 with g_k . y >= h_k, solved by its dual over lambda >= 0.
#pragma once

namespace enamel {

inline constexpr int kMaxWalls = 24;  ///< most walls in a problem

/// Minimise 1/2 l^T G l - h^T l over l >= 0 with the active-set method of Lawson and Hanson. G = g g^T is positive
/// semidefinite and n <= kMaxWalls. The solution uses independent rows only. Returns false if the iteration limit is
/// reached. Realtime: yes.
bool solveNonNegative(const double (&G)[kMaxWalls][kMaxWalls], const double* h, int n, double* l) noexcept;

}  // namespace enamel
