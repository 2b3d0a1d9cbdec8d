// The query loops for AVX2 and FMA. Fused products are used in float bounds only, never in a result.
#include <immintrin.h>

#include "kernel.hpp"

namespace enamel::kernel {
namespace {

#include "vector_avx2.inl"

struct LaneTable {
  uint8_t lane[256][8];  // the lanes of each mask
};
constexpr LaneTable makeLaneTable() {
  LaneTable table{};
  for (int mask = 0; mask < 256; ++mask)
    for (int lane = 0, count = 0; lane < 8; ++lane)
      if ((mask >> lane & 1) != 0) table.lane[mask][count++] = static_cast<uint8_t>(lane);
  return table;
}
constexpr LaneTable kLanesOf = makeLaneTable();
struct Chosen {
  __m256i a, b;  // lanes of the two halves
  int inA;
};
inline __m256i lanesOfHalf(unsigned mask) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLanesOf.lane[mask & 0xffu])));
}
inline Chosen choose(unsigned mask) {
  return {lanesOfHalf(mask), lanesOfHalf(mask >> 8), __builtin_popcount(mask & 0xffu)};
}
inline void compress(V x, const Chosen& lanes, float* p) {
  _mm256_storeu_ps(p, _mm256_permutevar8x32_ps(x.a, lanes.a));
  _mm256_storeu_ps(p + lanes.inA, _mm256_permutevar8x32_ps(x.b, lanes.b));
}
inline void compress(const int32_t* x, const Chosen& lanes, int32_t* p) {
  const __m256i a = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(x));
  const __m256i b = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(x + 8));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm256_permutevar8x32_epi32(a, lanes.a));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p + lanes.inA), _mm256_permutevar8x32_epi32(b, lanes.b));
}
inline void compressNumbers(int32_t first, const Chosen& lanes, int32_t* p) {
  const __m256i a = _mm256_add_epi32(lanes.a, _mm256_set1_epi32(first));
  const __m256i b = _mm256_add_epi32(lanes.b, _mm256_set1_epi32(first + 8));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p + lanes.inA), b);
}

#include "exact_four.inl"
#include "kernel_loops.inl"

}  // namespace

const Loops kAvx2Loops = {&closest,     &visit,    &visitSegment, &closestToSegment, &visitMinima, &clusterAngles,
                          &solidAngles, &seeCells, &boundCells,   &nearestOnCells,   &cutBrick};

}  // namespace enamel::kernel
