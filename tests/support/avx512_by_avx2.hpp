// Replacements for the intrinsics in lib/src/collision/kernel_avx512.cpp, so that machines without AVX-512 can test
// that file. They follow Intel's intrinsics guide. Where it permits an error (the reciprocal root), they use the
// largest one.
#pragma once

#include <immintrin.h>
#include <stdint.h>
#include <string.h>

namespace enamel::test {

#include "collision/vector_avx2.inl"

using Floats16 = V;

struct Numbers16 {
  int32_t lane[16];
};

inline Floats16 roughInverseRoot(Floats16 x) {  // error 2^-14, alternately too large and too small
  float f[16];
  store(f, x);
  for (int i = 0; i < 16; ++i)
    f[i] = static_cast<float>((i % 2 == 0 ? 1.0 + 0x1p-14 : 1.0 - 0x1p-14) / __builtin_sqrt(static_cast<double>(f[i])));
  return load(f);
}
template <int kPredicate>
__mmask16 compare(Floats16 x, Floats16 y) {
  const int a = _mm256_movemask_ps(_mm256_cmp_ps(x.a, y.a, kPredicate));
  const int b = _mm256_movemask_ps(_mm256_cmp_ps(x.b, y.b, kPredicate));
  return static_cast<__mmask16>(a | b << 8);
}
inline Floats16 blend(__mmask16 mask, Floats16 x, Floats16 y) {
  float f[16], g[16];
  store(f, x);
  store(g, y);
  for (int i = 0; i < 16; ++i)
    if ((mask >> i & 1) != 0) f[i] = g[i];
  return load(f);
}
inline Floats16 compress(__mmask16 mask, Floats16 x) {
  float f[16], g[16] = {};
  store(f, x);
  for (int i = 0, count = 0; i < 16; ++i)
    if ((mask >> i & 1) != 0) g[count++] = f[i];
  return load(g);
}
inline Numbers16 compress(__mmask16 mask, Numbers16 x) {
  Numbers16 y = {};
  for (int i = 0, count = 0; i < 16; ++i)
    if ((mask >> i & 1) != 0) y.lane[count++] = x.lane[i];
  return y;
}
inline Numbers16 loadNumbers(const void* p) {
  Numbers16 x;
  memcpy(&x, p, sizeof x);
  return x;
}
inline void storeNumbers(void* p, Numbers16 x) { memcpy(p, &x, sizeof x); }
inline Numbers16 setNumbers(int32_t x) {
  Numbers16 y;
  for (int32_t& one : y.lane) one = x;
  return y;
}
inline Numbers16 addNumbers(Numbers16 x, Numbers16 y) {
  for (int i = 0; i < 16; ++i) x.lane[i] += y.lane[i];
  return x;
}

}  // namespace enamel::test

#undef _mm512_cmp_ps_mask
#undef _mm512_setr_epi32
#define __m512 enamel::test::Floats16
#define _mm512_loadu_ps enamel::test::load
#define _mm512_storeu_ps enamel::test::store
#define _mm512_set1_ps enamel::test::set
#define _mm512_add_ps(x, y) ((x) + (y))
#define _mm512_sub_ps(x, y) ((x) - (y))
#define _mm512_mul_ps(x, y) ((x) * (y))
#define _mm512_div_ps(x, y) ((x) / (y))
#define _mm512_max_ps enamel::test::maximum
#define _mm512_min_ps enamel::test::minimum
#define _mm512_sqrt_ps enamel::test::root
#define _mm512_fmadd_ps enamel::test::mad
#define _mm512_rsqrt14_ps enamel::test::roughInverseRoot
#define _mm512_reduce_min_ps enamel::test::smallest
#define _mm512_cmp_ps_mask(x, y, predicate) enamel::test::compare<predicate>(x, y)
#define _mm512_mask_blend_ps enamel::test::blend
#define _mm512_maskz_compress_ps enamel::test::compress
#define __m512i enamel::test::Numbers16
#define _mm512_maskz_compress_epi32 enamel::test::compress
#define _mm512_loadu_si512 enamel::test::loadNumbers
#define _mm512_storeu_si512 enamel::test::storeNumbers
#define _mm512_set1_epi32 enamel::test::setNumbers
#define _mm512_setr_epi32(...) \
  enamel::test::Numbers16 {    \
    { __VA_ARGS__ }            \
  }
#define _mm512_add_epi32 enamel::test::addNumbers
