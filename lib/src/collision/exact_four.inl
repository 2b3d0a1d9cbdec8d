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

struct Candidate4 {
  __m256d squared, point[3], feature;
};

// Where `chosen` and nearer, the candidate becomes (squared, x, feature).
static inline void keepNearer4(__m256d chosen, __m256d squared, const __m256d* x, __m256d feature, Candidate4* best) {
  const __m256d nearer = _mm256_and_pd(chosen, _mm256_cmp_pd(squared, best->squared, _CMP_LT_OQ));
  best->squared = _mm256_blendv_pd(best->squared, squared, nearer);
  for (int k = 0; k < 3; ++k) best->point[k] = _mm256_blendv_pd(best->point[k], x[k], nearer);
  best->feature = _mm256_blendv_pd(best->feature, feature, nearer);
}

static inline void tryEdge4(__m256d chosen, const __m256d* p, const __m256d* a, const __m256d* b, Feature featureA,
                            Feature featureB, Feature featureEdge, Candidate4* best) {
  __m256d e[3], ap[3], x[3], d[3];
  subtract4(b, a, e);
  subtract4(p, a, ap);
  const __m256d along = dot4(ap, e), length = dot4(e, e), t = _mm256_div_pd(along, length);
  const __m256d afterA = _mm256_cmp_pd(along, _mm256_setzero_pd(), _CMP_GT_OQ);
  const __m256d beforeB = _mm256_cmp_pd(along, length, _CMP_LT_OQ);
  for (int k = 0; k < 3; ++k) {
    const __m256d between = _mm256_add_pd(a[k], _mm256_mul_pd(t, e[k]));
    x[k] = _mm256_blendv_pd(a[k], _mm256_blendv_pd(b[k], between, beforeB), afterA);
  }
  const __m256d atEnd = _mm256_blendv_pd(_mm256_set1_pd(featureB), _mm256_set1_pd(featureEdge), beforeB);
  subtract4(p, x, d);
  keepNearer4(chosen, dot4(d, d), x, _mm256_blendv_pd(_mm256_set1_pd(featureA), atEnd, afterA), best);
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
  const __m256d zero = _mm256_setzero_pd();
  __m256d v[9], p[3], ab[3], ac[3], bc[3], ap[3], bp[3], n[3], s[3], d[3];
  loadCorners4(t, v);
  const __m256d *a = v, *b = v + 3, *c = v + 6;
  for (int k = 0; k < 3; ++k) p[k] = _mm256_set1_pd(point[k]);
  subtract4(b, a, ab);
  subtract4(c, a, ac);
  subtract4(c, b, bc);
  subtract4(p, a, ap);
  subtract4(p, b, bp);
  cross4(ab, ac, n);
  cross4(ab, ap, s);
  const __m256d weightC = dot4(s, n);
  cross4(bc, bp, s);
  const __m256d weightA = dot4(s, n);
  cross4(ap, ac, s);
  const __m256d weightB = dot4(s, n);
  const __m256d outA = _mm256_cmp_pd(weightA, zero, _CMP_NGT_UQ), outB = _mm256_cmp_pd(weightB, zero, _CMP_NGT_UQ),
                outC = _mm256_cmp_pd(weightC, zero, _CMP_NGT_UQ);
  const __m256d outside = _mm256_or_pd(_mm256_or_pd(outA, outB), outC);
  const __m256d inverse = _mm256_div_pd(_mm256_set1_pd(1.0), dot4(n, n));
  const __m256d wb = _mm256_mul_pd(weightB, inverse), wc = _mm256_mul_pd(weightC, inverse);
  Candidate4 best;
  for (int k = 0; k < 3; ++k)
    best.point[k] = _mm256_add_pd(a[k], _mm256_add_pd(_mm256_mul_pd(wb, ab[k]), _mm256_mul_pd(wc, ac[k])));
  subtract4(p, best.point, d);
  best.squared = dot4(d, d);
  best.feature = _mm256_set1_pd(kFace);
  if (_mm256_movemask_pd(outside) != 0) {
    best.squared = _mm256_blendv_pd(best.squared, _mm256_set1_pd(1e308), outside);
    for (int k = 0; k < 3; ++k) best.point[k] = _mm256_blendv_pd(best.point[k], a[k], outside);
    best.feature = _mm256_blendv_pd(best.feature, _mm256_set1_pd(kCorner0), outside);
    tryEdge4(outC, p, a, b, kCorner0, kCorner1, kEdge01, &best);
    tryEdge4(outA, p, b, c, kCorner1, kCorner2, kEdge12, &best);
    tryEdge4(outB, p, c, a, kCorner2, kCorner0, kEdge20, &best);
  }
  const __m256d pairs = _mm256_min_pd(best.squared, _mm256_permute2f128_pd(best.squared, best.squared, 1));
  const __m256d least = _mm256_min_pd(pairs, _mm256_permute_pd(pairs, 5));
  unsigned lanes = static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(best.squared, least, _CMP_EQ_OQ)));
  int lane = __builtin_ctz(lanes | 8u);
  for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1)
    if (t[__builtin_ctz(lanes)]->index < t[lane]->index) lane = __builtin_ctz(lanes);
  alignas(32) double column[4][4];
  for (int k = 0; k < 3; ++k) _mm256_store_pd(column[k], best.point[k]);
  _mm256_store_pd(column[3], best.feature);
  nearest->squared = _mm256_cvtsd_f64(least);
  for (int k = 0; k < 3; ++k) nearest->point[k] = column[k][lane];
  nearest->feature = static_cast<int32_t>(column[3][lane]);
  return lane;
}
