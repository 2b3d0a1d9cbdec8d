// The closest point of a triangle in double: the one place where answered distances come from. Plain functions of
// internal linkage, included by every kernel file and compiled without contraction, so that all agree bit for bit.

struct Candidate {
  double squared;
  double point[3];
  int32_t feature;
};

static inline double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void subtract(const double* a, const double* b, double* c) {
  for (int k = 0; k < 3; ++k) c[k] = a[k] - b[k];
}

static inline void cross(const double* a, const double* b, double* c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double squaredDistance(const double* a, const double* b) {
  double d[3];
  subtract(a, b, d);
  return dot(d, d);
}

// x = a + t e, t = clamp((p - a).e / e.e, 0, 1): well conditioned for edges of any length, also of none.
static inline void tryEdge(const double* p, const double* a, const double* b, int32_t featureA, int32_t featureB,
                           int32_t featureEdge, Candidate* best) {
  double e[3], ap[3], x[3];
  subtract(b, a, e);
  subtract(p, a, ap);
  const double along = dot(ap, e), length = dot(e, e);
  int32_t feature = featureEdge;
  if (!(along > 0.0)) {
    feature = featureA;
    for (int k = 0; k < 3; ++k) x[k] = a[k];
  } else if (!(along < length)) {
    feature = featureB;
    for (int k = 0; k < 3; ++k) x[k] = b[k];
  } else {
    const double t = along / length;
    for (int k = 0; k < 3; ++k) x[k] = a[k] + t * e[k];
  }
  const double squared = squaredDistance(p, x);
  if (squared < best->squared) {
    best->squared = squared;
    for (int k = 0; k < 3; ++k) best->point[k] = x[k];
    best->feature = feature;
  }
}

// A long or flat triangle: its plane's foot point by iterative refinement (each pass works on the remaining
// difference, so that the error shrinks by 1e-16 length / height), against the edges. All candidates lie on the
// triangle, so a wrong decision between them can only cost what they differ by.
static inline void closestOnThin(const Triangle* t, const double* p, Candidate* best) {
  double length[3];  // of the edge opposite to the corner
  for (int i = 0; i < 3; ++i) length[i] = squaredDistance(t->corner[(i + 1) % 3], t->corner[(i + 2) % 3]);
  const int first = length[0] >= length[1] && length[0] >= length[2] ? 0 : length[1] >= length[2] ? 1 : 2;
  const double* a = t->corner[first];  // the two shorter edges meet here
  double u[3], v[3], n[3], r[3];
  subtract(t->corner[(first + 1) % 3], a, u);
  subtract(t->corner[(first + 2) % 3], a, v);
  cross(u, v, n);
  const double nn = dot(n, n);
  best->squared = 1e308;
  for (int k = 0; k < 3; ++k) best->point[k] = a[k];
  best->feature = kCorner0 + first;
  if (nn > 0.0) {
    double wu = 0.0, wv = 0.0, x[3], c[3];
    subtract(p, a, r);
    for (int pass = 0; pass < 4; ++pass) {
      cross(r, v, c);
      wu += dot(c, n) / nn;
      cross(u, r, c);
      wv += dot(c, n) / nn;
      for (int k = 0; k < 3; ++k) x[k] = a[k] + (wu * u[k] + wv * v[k]);
      subtract(p, x, r);
    }
    if (wu > 0.0 && wv > 0.0 && wu + wv < 1.0) {
      best->squared = dot(r, r);
      for (int k = 0; k < 3; ++k) best->point[k] = x[k];
      best->feature = kFace;
    }
  }
  tryEdge(p, t->corner[0], t->corner[1], kCorner0, kCorner1, kEdge01, best);
  tryEdge(p, t->corner[1], t->corner[2], kCorner1, kCorner2, kEdge12, best);
  tryEdge(p, t->corner[2], t->corner[0], kCorner2, kCorner0, kEdge20, best);
}

// The foot point on the plane where it lies inside, else the nearest point of the edges that it lies outside of.
static inline void closestOnTriangle(const Triangle* t, const double* p, Candidate* best) {
  if (t->thin != 0) {
    closestOnThin(t, p, best);
    return;
  }
  const double *a = t->corner[0], *b = t->corner[1], *c = t->corner[2];
  double ab[3], ac[3], ap[3], bp[3], bc[3], n[3], s[3];
  subtract(b, a, ab);
  subtract(c, a, ac);
  subtract(c, b, bc);
  subtract(p, a, ap);
  subtract(p, b, bp);
  cross(ab, ac, n);
  cross(ab, ap, s);
  const double weightC = dot(s, n);
  cross(bc, bp, s);
  const double weightA = dot(s, n);
  cross(ap, ac, s);
  const double weightB = dot(s, n);
  if (weightA > 0.0 && weightB > 0.0 && weightC > 0.0) {
    const double inverse = 1.0 / dot(n, n);
    const double wb = weightB * inverse, wc = weightC * inverse;
    for (int k = 0; k < 3; ++k) best->point[k] = a[k] + (wb * ab[k] + wc * ac[k]);
    best->squared = squaredDistance(p, best->point);
    best->feature = kFace;
    return;
  }
  best->squared = 1e308;
  for (int k = 0; k < 3; ++k) best->point[k] = a[k];
  best->feature = kCorner0;
  if (!(weightC > 0.0)) tryEdge(p, a, b, kCorner0, kCorner1, kEdge01, best);
  if (!(weightA > 0.0)) tryEdge(p, b, c, kCorner1, kCorner2, kEdge12, best);
  if (!(weightB > 0.0)) tryEdge(p, c, a, kCorner2, kCorner0, kEdge20, best);
}
