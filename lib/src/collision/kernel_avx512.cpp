// The query loops for AVX-512. Fused products are used in float bounds only, never in a result.
#include <immintrin.h>

#include "kernel.hpp"

namespace enamel::kernel {
namespace {

struct V {
  __m512 v;
};

inline V load(const float* p) { return {_mm512_loadu_ps(p)}; }
inline void store(float* p, V x) { _mm512_storeu_ps(p, x.v); }
inline V set(float x) { return {_mm512_set1_ps(x)}; }
inline V operator+(V x, V y) { return {_mm512_add_ps(x.v, y.v)}; }
inline V operator-(V x, V y) { return {_mm512_sub_ps(x.v, y.v)}; }
inline V operator*(V x, V y) { return {_mm512_mul_ps(x.v, y.v)}; }
inline V mad(V x, V y, V z) { return {_mm512_fmadd_ps(x.v, y.v, z.v)}; }
inline V operator/(V x, V y) { return {_mm512_div_ps(x.v, y.v)}; }
inline V root(V x) { return {_mm512_sqrt_ps(x.v)}; }
inline V inverseRoot(V x) { return {_mm512_rsqrt14_ps(x.v)}; }
inline V maximum(V x, V y) { return {_mm512_max_ps(x.v, y.v)}; }
inline V minimum(V x, V y) { return {_mm512_min_ps(x.v, y.v)}; }
inline float smallest(V x) { return _mm512_reduce_min_ps(x.v); }
inline unsigned lessOrEqualMask(V x, V y) { return _mm512_cmp_ps_mask(x.v, y.v, _CMP_LE_OQ); }
inline V selectGreater(V x, V y, V p, V q) {
  return {_mm512_mask_blend_ps(_mm512_cmp_ps_mask(x.v, y.v, _CMP_GT_OQ), q.v, p.v)};
}
using Chosen = __mmask16;
inline Chosen choose(unsigned mask) { return static_cast<Chosen>(mask); }
inline void compress(V x, Chosen lanes, float* p) { _mm512_storeu_ps(p, _mm512_maskz_compress_ps(lanes, x.v)); }
inline void compress(const int32_t* x, Chosen lanes, int32_t* p) {
  _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(lanes, _mm512_loadu_si512(x)));
}
inline void compressNumbers(int32_t first, Chosen lanes, int32_t* p) {
  const __m512i number = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(lanes, _mm512_add_epi32(number, _mm512_set1_epi32(first))));
}

#include "exact_four.inl"
#include "kernel_loops.inl"

}  // namespace

const Loops kAvx512Loops = {&closest,     &visit,    &visitSegment, &closestToSegment, &visitMinima, &clusterAngles,
                            &solidAngles, &seeCells, &boundCells,   &nearestOnCells,   &cutBrick};

}  // namespace enamel::kernel
