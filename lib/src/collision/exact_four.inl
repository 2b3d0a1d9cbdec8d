// closestOnTriangle() for four triangles at once on AVX2. Each lane does the same operations in the same order, so the
// results agree bit for bit. Included by the kernel files for machines with AVX2.

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
    for (int lane = 0; lane < 4; ++lane)
      row[lane] = _mm256_loadu_pd(reinterpret_cast<const double*>(t[lane]->corner) + i);
    const __m256d low01 = _mm256_unpacklo_pd(row[0], row[1]), high01 = _mm256_unpackhi_pd(row[0], row[1]);
    const __m256d low23 = _mm256_unpacklo_pd(row[2], row[3]), high23 = _mm256_unpackhi_pd(row[2], row[3]);
    v[i] = _mm256_permute2f128_pd(low01, low23, 0x20);
    v[i + 1] = _mm256_permute2f128_pd(high01, high23, 0x20);
    v[i + 2] = _mm256_permute2f128_pd(low01, low23, 0x31);
    v[i + 3] = _mm256_permute2f128_pd(high01, high23, 0x31);
  }
  v[8] = _mm256_setr_pd(t[0]->corner[2][2], t[1]->corner[2][2], t[2]->corner[2][2], t[3]->corner[2][2]);
}

static inline int smallestIndex(const Triangle* const* t, unsigned lanes) {
  int lane = __builtin_ctz(lanes | 8u);
  for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1)
    if (t[__builtin_ctz(lanes)]->index < t[lane]->index) lane = __builtin_ctz(lanes);
  return lane;
}

// The lane of the smallest number; of equal ones, the triangle with the smallest index.
static inline int nearestLane(const Triangle* const* t, __m256d squared) {
  const __m256d pairs = _mm256_min_pd(squared, _mm256_permute2f128_pd(squared, squared, 1));
  const __m256d least = _mm256_min_pd(pairs, _mm256_permute_pd(pairs, 5));
  const int equal = _mm256_movemask_pd(_mm256_cmp_pd(squared, least, _CMP_EQ_OQ));
  return smallestIndex(t, static_cast<unsigned>(equal));
}

// Find the nearest of four triangles; of equally near ones, that with the smallest index. None may be thin.
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
  const __m256d normalSquared = dot4(n, n), inverse = _mm256_div_pd(one, normalSquared);
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
      const __m256d at = _mm256_min_pd(_mm256_max_pd(along, zero), one);  // like the scalar code, also for NaN
      for (int k = 0; k < 3; ++k) d[k] = _mm256_sub_pd(from[i][k], _mm256_mul_pd(at, e[i][k]));
      const __m256d here = dot4(d, d);
      const __m256d nearer = _mm256_and_pd(outside[i], _mm256_cmp_pd(here, squared, _CMP_LT_OQ));
      squared = _mm256_blendv_pd(squared, here, nearer);
      u = _mm256_blendv_pd(u, at, nearer);
      part = _mm256_blendv_pd(part, _mm256_set1_pd(i), nearer);
    }
  }
  const int lane = nearestLane(t, squared);
  alignas(32) double column[6][4];
  _mm256_store_pd(column[0], part);
  _mm256_store_pd(column[1], u);
  _mm256_store_pd(column[2], w);
  _mm256_store_pd(column[3], squared);
  _mm256_store_pd(column[4], dot4(from[0], n));
  _mm256_store_pd(column[5], normalSquared);
  nearest->squared = column[3][lane];
  nearest->overPlane = column[4][lane];
  nearest->normalSquared = column[5][lane];
  placeOn(t[lane], static_cast<int32_t>(column[0][lane]), column[1][lane], column[2][lane], nearest);
  return lane;
}

static inline __m256d within01Of4(__m256d x) {  // like the scalar code, also for NaN
  return _mm256_min_pd(_mm256_max_pd(x, _mm256_setzero_pd()), _mm256_set1_pd(1.0));
}

// The shortest distances so far, as in Shortest.
struct Shortest4 {
  __m256d squared, parameter, u, v, part;
};

static inline void take4(__m256d valid, __m256d squared, __m256d parameter, __m256d u, __m256d v, double part,
                         Shortest4* best) {
  const __m256d nearer = _mm256_and_pd(valid, _mm256_cmp_pd(squared, best->squared, _CMP_LT_OQ));
  best->squared = _mm256_blendv_pd(best->squared, squared, nearer);
  best->parameter = _mm256_blendv_pd(best->parameter, parameter, nearer);
  best->u = _mm256_blendv_pd(best->u, u, nearer);
  best->v = _mm256_blendv_pd(best->v, v, nearer);
  best->part = _mm256_blendv_pd(best->part, _mm256_set1_pd(part), nearer);
}

// Four triangles and an axis, relative to the ends of the axis.
struct AxisAndFour {
  __m256d span[3], e[3][3], ac[3], fromA[3][3], fromB[3][3];
};

static inline void seeFour(const Triangle* const* t, const Axis* axis, AxisAndFour* s) {
  __m256d v[9], a[3], b[3];
  loadCorners4(t, v);
  for (int k = 0; k < 3; ++k) {
    a[k] = _mm256_set1_pd(axis->a[k]);
    b[k] = _mm256_set1_pd(axis->b[k]);
    s->span[k] = _mm256_set1_pd(axis->span[k]);
  }
  for (int i = 0; i < 3; ++i) {
    subtract4(v + (i == 2 ? 0 : 3 * i + 3), v + 3 * i, s->e[i]);
    subtract4(a, v + 3 * i, s->fromA[i]);
    subtract4(b, v + 3 * i, s->fromB[i]);
  }
  subtract4(v + 6, v, s->ac);
}

// A bit for each triangle that the axis may cross; crossesAxis() decides.
static inline unsigned mayCross4(const AxisAndFour* s) {
  const __m256d zero = _mm256_setzero_pd(), one = _mm256_set1_pd(1.0), sign = _mm256_set1_pd(-0.0);
  __m256d h[3], q[3];
  cross4(s->span, s->ac, h);
  cross4(s->fromA[0], s->e[0], q);
  const __m256d det = dot4(s->e[0], h), size = _mm256_andnot_pd(sign, det), turn = _mm256_and_pd(sign, det);
  const __m256d border = _mm256_mul_pd(_mm256_set1_pd(-1e-12), size), at = _mm256_div_pd(dot4(s->ac, q), det);
  const __m256d inU = _mm256_xor_pd(dot4(s->fromA[0], h), turn), inV = _mm256_xor_pd(dot4(s->span, q), turn);
  __m256d crosses =
      _mm256_and_pd(_mm256_cmp_pd(size, zero, _CMP_GT_OQ), _mm256_cmp_pd(size, _mm256_set1_pd(1e308), _CMP_LT_OQ));
  crosses = _mm256_and_pd(
      crosses, _mm256_and_pd(_mm256_cmp_pd(inU, border, _CMP_GE_OQ), _mm256_cmp_pd(inV, border, _CMP_GE_OQ)));
  crosses = _mm256_and_pd(crosses, _mm256_cmp_pd(_mm256_add_pd(inU, inV), _mm256_sub_pd(size, border), _CMP_LE_OQ));
  crosses =
      _mm256_and_pd(crosses, _mm256_and_pd(_mm256_cmp_pd(at, zero, _CMP_GE_OQ), _mm256_cmp_pd(at, one, _CMP_LE_OQ)));
  return static_cast<unsigned>(_mm256_movemask_pd(crosses));
}

// The ends of the axis against the faces.
static inline void takeFaces4(const AxisAndFour* s, Shortest4* best) {
  const __m256d zero = _mm256_setzero_pd(), one = _mm256_set1_pd(1.0);
  __m256d n[3], m[3][3];
  cross4(s->e[0], s->ac, n);
  for (int i = 0; i < 3; ++i) cross4(n, s->e[i], m[i]);
  const __m256d inverse = _mm256_div_pd(one, dot4(n, n));
  for (int end = 1; end >= 0; --end) {
    const __m256d(*from)[3] = end == 1 ? s->fromB : s->fromA;
    const __m256d w0 = dot4(from[0], m[0]), w1 = dot4(from[1], m[1]), w2 = dot4(from[2], m[2]);
    const __m256d inside =
        _mm256_and_pd(_mm256_and_pd(_mm256_cmp_pd(w0, zero, _CMP_GT_OQ), _mm256_cmp_pd(w1, zero, _CMP_GT_OQ)),
                      _mm256_cmp_pd(w2, zero, _CMP_GT_OQ));
    if (_mm256_movemask_pd(inside) == 0) continue;
    const __m256d u = _mm256_mul_pd(w2, inverse), w = _mm256_mul_pd(w0, inverse);
    __m256d d[3];
    for (int k = 0; k < 3; ++k)
      d[k] = _mm256_sub_pd(from[0][k], _mm256_add_pd(_mm256_mul_pd(u, s->e[0][k]), _mm256_mul_pd(w, s->ac[k])));
    take4(inside, dot4(d, d), end == 1 ? one : zero, u, w, kPartFace, best);
  }
}

// The axis and edge i, with the ends of both.
static inline void takeEdge4(const AxisAndFour* s, const Axis* axis, int i, Shortest4* best) {
  const __m256d zero = _mm256_setzero_pd(), one = _mm256_set1_pd(1.0), sign = _mm256_set1_pd(-0.0);
  const __m256d all = _mm256_cmp_pd(zero, zero, _CMP_EQ_OQ);
  const __m256d spanSquared = _mm256_set1_pd(axis->squared), perSpan = _mm256_set1_pd(axis->perSquared);
  const __m256d *span = s->span, *e = s->e[i], *from = s->fromA[i];
  const __m256d length = dot4(e, e), perLength = _mm256_div_pd(one, length), along = dot4(span, e);
  const __m256d alongEdge = dot4(e, from), across = dot4(span, from);
  const auto tryPair4 = [&](__m256d parameter, __m256d u) {
    __m256d d[3];
    for (int k = 0; k < 3; ++k)
      d[k] = _mm256_sub_pd(_mm256_add_pd(from[k], _mm256_mul_pd(parameter, span[k])), _mm256_mul_pd(u, e[k]));
    take4(all, dot4(d, d), parameter, u, zero, i, best);
  };
  tryPair4(zero, within01Of4(_mm256_mul_pd(alongEdge, perLength)));
  tryPair4(one, within01Of4(_mm256_mul_pd(_mm256_add_pd(alongEdge, along), perLength)));
  tryPair4(within01Of4(_mm256_mul_pd(_mm256_xor_pd(across, sign), perSpan)), zero);
  // As in tryEdgeOnAxis().
  const __m256d both = _mm256_mul_pd(spanSquared, length), lines = _mm256_sub_pd(both, _mm256_mul_pd(along, along));
  __m256d parameter =
      within01Of4(_mm256_div_pd(_mm256_sub_pd(_mm256_mul_pd(along, alongEdge), _mm256_mul_pd(length, across)), lines));
  const __m256d isApart = _mm256_cmp_pd(lines, _mm256_mul_pd(_mm256_set1_pd(kNearlyParallel), both), _CMP_GT_OQ);
  if (_mm256_movemask_pd(isApart) != 15) {
    __m256d common[3], moment[3];
    cross4(span, e, common);
    cross4(e, from, moment);
    const __m256d square = dot4(common, common);
    const __m256d parallel = _mm256_and_pd(within01Of4(_mm256_div_pd(dot4(moment, common), square)),
                                           _mm256_cmp_pd(square, zero, _CMP_GT_OQ));
    parameter = _mm256_blendv_pd(parallel, parameter, isApart);
  }
  const __m256d u = within01Of4(_mm256_mul_pd(_mm256_add_pd(alongEdge, _mm256_mul_pd(parameter, along)), perLength));
  parameter = within01Of4(_mm256_mul_pd(_mm256_sub_pd(_mm256_mul_pd(u, along), across), perSpan));
  tryPair4(parameter, u);
}

// closestToAxis() for four triangles, none of them thin: the nearest; of equal ones, that with the smallest index.
static inline int closestToAxisOfFour(const Triangle* const* t, const Axis* axis, SegmentCandidate* nearest) {
  constexpr double kCrossed = kPartFace + 1;
  const __m256d zero = _mm256_setzero_pd();
  AxisAndFour seen;
  seeFour(t, axis, &seen);
  alignas(32) double column[5][4] = {{1e308, 1e308, 1e308, 1e308}};
  SegmentCandidate crossed[4];
  for (unsigned lanes = mayCross4(&seen); lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    if (crossesAxis(t[lane], axis, crossed + lane) == 0) continue;
    column[0][lane] = 0.0;
    column[4][lane] = kCrossed;
  }
  Shortest4 best = {_mm256_load_pd(column[0]), zero, zero, zero, _mm256_load_pd(column[4])};
  takeFaces4(&seen, &best);
  for (int i = 0; i < 3; ++i) takeEdge4(&seen, axis, i, &best);
  const int lane = nearestLane(t, best.squared);
  _mm256_store_pd(column[0], best.squared);
  _mm256_store_pd(column[1], best.parameter);
  _mm256_store_pd(column[2], best.u);
  _mm256_store_pd(column[3], best.v);
  _mm256_store_pd(column[4], best.part);
  if (column[4][lane] == kCrossed) {
    *nearest = crossed[lane];
    return lane;
  }
  const Shortest found = {column[0][lane], column[1][lane], column[2][lane], column[3][lane],
                          static_cast<int32_t>(column[4][lane])};
  finishOnAxis(t[lane], &found, nearest);
  return lane;
}

// solidAngle() for the triangles of a leaf.
static inline void solidAngles(const Triangle* triangles, const double* point, double* re, double* im) {
  const __m256d sign = _mm256_set1_pd(-0.0), zero = _mm256_setzero_pd(), one = _mm256_set1_pd(1.0);
  for (int first = 0; first < kWidth; first += 4) {
    const Triangle* const t = triangles + first;
    const Triangle* const four[4] = {t, t + 1, t + 2, t + 3};
    __m256d v[9], length[3], normal[3];
    loadCorners4(four, v);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) v[3 * i + k] = _mm256_sub_pd(v[3 * i + k], _mm256_set1_pd(point[k]));
      length[i] = _mm256_sqrt_pd(dot4(v + 3 * i, v + 3 * i));
    }
    cross4(v + 3, v + 6, normal);
    const __m256d y = dot4(v, normal);
    __m256d x = _mm256_mul_pd(_mm256_mul_pd(length[0], length[1]), length[2]);
    for (int i = 0; i < 3; ++i)
      x = _mm256_add_pd(x, _mm256_mul_pd(dot4(v + 3 * i, v + (3 * i + 3) % 9), length[(i + 2) % 3]));
    const __m256d size = _mm256_add_pd(_mm256_andnot_pd(sign, x), _mm256_andnot_pd(sign, y));
    const __m256d index = _mm256_setr_pd(t[0].index, t[1].index, t[2].index, t[3].index);
    const __m256d isSeen = _mm256_and_pd(_mm256_cmp_pd(index, zero, _CMP_GE_OQ), _mm256_cmp_pd(size, zero, _CMP_GT_OQ));
    _mm256_storeu_pd(re + first, _mm256_blendv_pd(one, _mm256_div_pd(x, size), isSeen));
    _mm256_storeu_pd(im + first, _mm256_and_pd(_mm256_div_pd(y, size), isSeen));
  }
}
