// The nearest point of the free space: min |y|^2 with g_k . y >= h_k, by its dual, min over lambda >= 0.
#pragma once

namespace enamel {

inline constexpr int kMaxWalls = 24;  ///< of one problem

/// min 1/2 l^T G l - h^T l over l >= 0, with G = g g^T positive semidefinite, n <= kMaxWalls (Lawson and Hanson's
/// active set). The answer uses independent rows only. Returns false where it was cut short. Realtime: yes.
bool solveNonNegative(const double (&G)[kMaxWalls][kMaxWalls], const double* h, int n, double* l) noexcept;

}  // namespace enamel
