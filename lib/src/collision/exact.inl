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

// Where on a triangle the nearest point is: on edge 0, 1 or 2 at u of its length, or as a + u ab + v ac on the face.
enum Part : int32_t { kPart01, kPart12, kPart20, kPartFace };

static inline void placeOn(const Triangle* t, int32_t part, double u, double v, Candidate* best) {
  const int32_t next = part == kPart20 ? 0 : part + 1;
  const double* a = part == kPartFace ? t->corner[0] : t->corner[part];
  const double* b = part == kPartFace ? t->corner[1] : t->corner[next];
  double ab[3], ac[3];
  subtract(b, a, ab);
  if (part == kPartFace) {
    subtract(t->corner[2], a, ac);
    for (int k = 0; k < 3; ++k) best->point[k] = a[k] + (u * ab[k] + v * ac[k]);
    best->feature = kFace;
  } else if (u > 0.0 && u < 1.0) {
    for (int k = 0; k < 3; ++k) best->point[k] = a[k] + u * ab[k];
    best->feature = kEdge01 + part;
  } else {
    for (int k = 0; k < 3; ++k) best->point[k] = u > 0.0 ? b[k] : a[k];
    best->feature = kCorner0 + (u > 0.0 ? next : part);
  }
}

// Squared distance from the edge e, seen from its start.
static inline double nearEdge(const double* fromStart, const double* e, double* at) {
  double d[3];
  const double along = dot(fromStart, e) / dot(e, e);
  const double after = along > 0.0 ? along : 0.0;
  *at = after < 1.0 ? after : 1.0;
  for (int k = 0; k < 3; ++k) d[k] = fromStart[k] - *at * e[k];
  return dot(d, d);
}

// The foot point on the plane where it lies inside, else the nearest point of the edges that it lies outside of.
static inline void closestOnTriangle(const Triangle* t, const double* p, Candidate* best) {
  if (t->thin != 0) {
    closestOnThin(t, p, best);
    return;
  }
  const double *a = t->corner[0], *b = t->corner[1], *c = t->corner[2];
  double e[3][3], ac[3], from[3][3], n[3], s[3], weight[3];
  subtract(b, a, e[0]);
  subtract(c, b, e[1]);
  subtract(a, c, e[2]);
  subtract(c, a, ac);
  subtract(p, a, from[0]);
  subtract(p, b, from[1]);
  subtract(p, c, from[2]);
  cross(e[0], ac, n);
  for (int i = 0; i < 3; ++i) {  // of the corner opposite to edge i
    cross(e[i], from[i], s);
    weight[i] = dot(s, n);
  }
  if (weight[0] > 0.0 && weight[1] > 0.0 && weight[2] > 0.0) {
    const double inverse = 1.0 / dot(n, n);
    const double u = weight[2] * inverse, v = weight[0] * inverse;
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = from[0][k] - (u * e[0][k] + v * ac[k]);
    best->squared = dot(d, d);
    placeOn(t, kPartFace, u, v, best);
    return;
  }
  int32_t part = kPart01;
  double u = 0.0;
  best->squared = 1e308;
  for (int i = 0; i < 3; ++i) {
    if (weight[i] > 0.0) continue;
    double at;
    const double squared = nearEdge(from[i], e[i], &at);
    if (!(squared < best->squared)) continue;
    best->squared = squared;
    part = i;
    u = at;
  }
  placeOn(t, part, u, 0.0, best);
}
