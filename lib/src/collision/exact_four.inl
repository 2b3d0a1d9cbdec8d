// closestOnTriangle() for four triangles at once on AVX2: the same operations in the same order in each lane, so that
// the answers agree bit for bit. Included by the kernel files whose machines have AVX2.

#include "exact.inl"

static inline __m256d dot4(const __m256d* a, const __m256d* b) {
  return _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1])), _mm256_mul_pd(a[2], b[2]));
}

static inline void cross4(const __m256d* a, const __m256d* b, __m256d* c) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    c[k] = _mm256_sub_pd(_mm256_mul_pd(a[i], b[j]), _mm256_mul_pd(a[j], b[i]));
  }
}

static inline void subtract4(const __m256d* a, const __m256d* b, __m256d* c) {
  for (int k = 0; k < 3; ++k) c[k] = _mm256_sub_pd(a[k], b[k]);
}

// Corners of four triangles as 3 * corner + coordinate.
static inline void loadCorners4(const Triangle* const* t, __m256d* v) {
  for (int i = 0; i < 8; i += 4) {
    __m256d row[4];
    for (int lane = 0; lane < 4; ++lane) row[lane] = _mm256_loadu_pd(t[lane]->corner[0] + i);
    const __m256d low01 = _mm256_unpacklo_pd(row[0], row[1]), high01 = _mm256_unpackhi_pd(row[0], row[1]);
    const __m256d low23 = _mm256_unpacklo_pd(row[2], row[3]), high23 = _mm256_unpackhi_pd(row[2], row[3]);
    v[i] = _mm256_permute2f128_pd(low01, low23, 0x20);
    v[i + 1] = _mm256_permute2f128_pd(high01, high23, 0x20);
    v[i + 2] = _mm256_permute2f128_pd(low01, low23, 0x31);
    v[i + 3] = _mm256_permute2f128_pd(high01, high23, 0x31);
  }
  v[8] = _mm256_setr_pd(t[0]->corner[2][2], t[1]->corner[2][2], t[2]->corner[2][2], t[3]->corner[2][2]);
}

// Which of four triangles is nearest; of equally near ones the one of smallest index. None of them is thin.
static inline int closestOfFour(const Triangle* const* t, const double* point, Candidate* nearest) {
  const __m256d zero = _mm256_setzero_pd(), one = _mm256_set1_pd(1.0);
  __m256d v[9], p[3], e[3][3], ac[3], from[3][3], n[3], s[3], d[3], weight[3], outside[3];
  loadCorners4(t, v);
  for (int k = 0; k < 3; ++k) p[k] = _mm256_set1_pd(point[k]);
  for (int i = 0; i < 3; ++i) {
    subtract4(v + (i == 2 ? 0 : 3 * i + 3), v + 3 * i, e[i]);
    subtract4(p, v + 3 * i, from[i]);
  }
  subtract4(v + 6, v, ac);
  cross4(e[0], ac, n);
  for (int i = 0; i < 3; ++i) {
    cross4(e[i], from[i], s);
    weight[i] = dot4(s, n);
    outside[i] = _mm256_cmp_pd(weight[i], zero, _CMP_NGT_UQ);
  }
  const __m256d inverse = _mm256_div_pd(one, dot4(n, n));
  __m256d u = _mm256_mul_pd(weight[2], inverse);
  const __m256d w = _mm256_mul_pd(weight[0], inverse);
  for (int k = 0; k < 3; ++k)
    d[k] = _mm256_sub_pd(from[0][k], _mm256_add_pd(_mm256_mul_pd(u, e[0][k]), _mm256_mul_pd(w, ac[k])));
  __m256d squared = dot4(d, d), part = _mm256_set1_pd(kPartFace);
  const __m256d onEdge = _mm256_or_pd(_mm256_or_pd(outside[0], outside[1]), outside[2]);
  if (_mm256_movemask_pd(onEdge) != 0) {
    squared = _mm256_blendv_pd(squared, _mm256_set1_pd(1e308), onEdge);
    for (int i = 0; i < 3; ++i) {
      const __m256d along = _mm256_div_pd(dot4(from[i], e[i]), dot4(e[i], e[i]));
      const __m256d at = _mm256_min_pd(_mm256_max_pd(along, zero), one);  // as the scalar code also for NaN
      for (int k = 0; k < 3; ++k) d[k] = _mm256_sub_pd(from[i][k], _mm256_mul_pd(at, e[i][k]));
      const __m256d here = dot4(d, d);
      const __m256d nearer = _mm256_and_pd(outside[i], _mm256_cmp_pd(here, squared, _CMP_LT_OQ));
      squared = _mm256_blendv_pd(squared, here, nearer);
      u = _mm256_blendv_pd(u, at, nearer);
      part = _mm256_blendv_pd(part, _mm256_set1_pd(i), nearer);
    }
  }
  const __m256d pairs = _mm256_min_pd(squared, _mm256_permute2f128_pd(squared, squared, 1));
  const __m256d least = _mm256_min_pd(pairs, _mm256_permute_pd(pairs, 5));
  unsigned lanes = static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(squared, least, _CMP_EQ_OQ)));
  int lane = __builtin_ctz(lanes | 8u);
  for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1)
    if (t[__builtin_ctz(lanes)]->index < t[lane]->index) lane = __builtin_ctz(lanes);
  alignas(32) double column[3][4];
  _mm256_store_pd(column[0], part);
  _mm256_store_pd(column[1], u);
  _mm256_store_pd(column[2], w);
  nearest->squared = _mm256_cvtsd_f64(least);
  placeOn(t[lane], static_cast<int32_t>(column[0][lane]), column[1][lane], column[2][lane], nearest);
  return lane;
}
