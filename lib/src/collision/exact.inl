// The closest point of a triangle in double: the only source of returned distances. Plain functions of internal
// linkage, included by every kernel file and compiled without contraction, so that all levels agree bit for bit.

static inline bool isThin(const Triangle* t) { return t->cone < 0.0f; }

static inline double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void subtract(const double* a, const double* b, double* c) {
  for (int k = 0; k < 3; ++k) c[k] = a[k] - b[k];
}

static inline void cross(const double* a, const double* b, double* c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double absolute(double v) { return v < 0.0 ? -v : v; }

static inline double squaredDistance(const double* a, const double* b) {
  double d[3];
  subtract(a, b, d);
  return dot(d, d);
}

// Location of the nearest point on a triangle: on edge 0, 1 or 2 at u of its length, or a + u ab + v ac on the face.
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

// Squared distance from the edge e. `fromStart` is the offset from its start.
static inline double nearEdge(const double* fromStart, const double* e, double* at) {
  double d[3];
  const double along = dot(fromStart, e) / dot(e, e);
  const double after = along > 0.0 ? along : 0.0;
  *at = after < 1.0 ? after : 1.0;
  for (int k = 0; k < 3; ++k) d[k] = fromStart[k] - *at * e[k];
  return dot(d, d);
}

// The edges of a triangle, and the offsets of a point from their starts.
static inline void edgesOf(const Triangle* t, const double* p, double (*e)[3], double (*from)[3]) {
  for (int i = 0; i < 3; ++i) {
    subtract(t->corner[(i + 1) % 3], t->corner[i], e[i]);
    subtract(p, t->corner[i], from[i]);
  }
}

// Try the edges with the point on their outer side. `part` is the present location of `best`: kPartFace, or kPart01 if
// it has no location yet.
static inline void tryEdges(const Triangle* t, const double (*e)[3], const double (*from)[3], const double* weight,
                            int32_t part, Candidate* best) {
  double u = 0.0;
  for (int i = 0; i < 3; ++i) {
    if (weight[i] > 0.0) continue;
    double at;
    const double squared = nearEdge(from[i], e[i], &at);
    if (!(squared < best->squared)) continue;
    best->squared = squared;
    part = i;
    u = at;
  }
  if (part != kPartFace) placeOn(t, part, u, 0.0, best);
}

// A long or flat triangle. The foot point on its plane is found by iterative refinement: each pass works on the
// remaining difference, so the error shrinks by 1e-16 length / height. Then the edges are compared. All candidates lie
// on the triangle, so a wrong choice costs no more than the difference of their distances.
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
  int32_t part = kPart01;
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
      part = kPartFace;
    }
  }
  const double outside[3] = {0.0, 0.0, 0.0};
  double e[3][3], from[3][3];
  edgesOf(t, p, e, from);
  tryEdges(t, e, from, outside, part, best);
}

// The foot point on the plane if inside; otherwise the nearest point of the edges with the point on their outer side.
static inline void closestOnTriangle(const Triangle* t, const double* p, Candidate* best) {
  best->overPlane = best->normalSquared = 0.0;
  if (isThin(t)) {
    closestOnThin(t, p, best);
    return;
  }
  double e[3][3], ac[3], from[3][3], n[3], s[3], weight[3];
  edgesOf(t, p, e, from);
  subtract(t->corner[2], t->corner[0], ac);
  cross(e[0], ac, n);
  best->overPlane = dot(from[0], n);
  best->normalSquared = dot(n, n);
  for (int i = 0; i < 3; ++i) {  // of the corner opposite to edge i
    cross(e[i], from[i], s);
    weight[i] = dot(s, n);
  }
  best->squared = 1e308;
  if (!(weight[0] > 0.0 && weight[1] > 0.0 && weight[2] > 0.0)) {
    tryEdges(t, e, from, weight, kPart01, best);
    return;
  }
  const double inverse = 1.0 / best->normalSquared;
  const double u = weight[2] * inverse, v = weight[0] * inverse;
  double d[3];
  for (int k = 0; k < 3; ++k) d[k] = from[0][k] - (u * e[0][k] + v * ac[k]);
  best->squared = dot(d, d);
  placeOn(t, kPartFace, u, v, best);
}

static inline double inverseOf(double x) { return x > 0.0 ? 1.0 / x : 0.0; }

static inline double within01(double x) {
  const double after = x > 0.0 ? x : 0.0;
  return after < 1.0 ? after : 1.0;
}

// A segment with the data that every triangle needs.
struct Axis {
  double a[3], b[3], span[3];  // span: from a to b
  double squared, perSquared;  // length^2, and its inverse or 0
};

static inline Axis axisBetween(const double* a, const double* b) {
  Axis axis;
  for (int k = 0; k < 3; ++k) {
    axis.a[k] = a[k];
    axis.b[k] = b[k];
  }
  subtract(b, a, axis.span);
  axis.squared = dot(axis.span, axis.span);
  axis.perSquared = inverseOf(axis.squared);
  return axis;
}

// Parameter at which a segment crosses a triangle, borders included (Moeller & Trumbore 1997); -1 if it does not.
static inline double crossing(const Triangle* t, const Axis* axis) {
  double e1[3], e2[3], h[3], o[3], q[3];
  subtract(t->corner[1], t->corner[0], e1);
  subtract(t->corner[2], t->corner[0], e2);
  subtract(axis->a, t->corner[0], o);
  cross(axis->span, e2, h);
  cross(o, e1, q);
  const double det = dot(e1, h), size = absolute(det), border = -1e-12 * size;
  const double u = dot(o, h), v = dot(axis->span, q), at = dot(e2, q) / det;
  const double inU = det > 0.0 ? u : -u, inV = det > 0.0 ? v : -v;
  const int crosses = size > 0.0 && size < 1e308 && inU >= border && inV >= border && inU + inV <= size - border &&
                      at >= 0.0 && at <= 1.0;
  return crosses != 0 ? at : -1.0;
}

// The nearest points of a segment and a triangle.
struct SegmentCandidate {
  double squared;
  double parameter;  // of the segment
  double point[3];   // on the triangle
  int32_t feature;   // of the triangle at the point
};

// If the segment lies almost in the plane, or the triangle is a needle, the crossing may be a rounding error. It counts
// only if its point lies on the triangle.
static inline int crossesAxis(const Triangle* t, const Axis* axis, SegmentCandidate* best) {
  const double at = crossing(t, axis);
  if (!(at >= 0.0)) return 0;
  double x[3], size = 0.0;
  for (int k = 0; k < 3; ++k) {
    x[k] = axis->a[k] + at * axis->span[k];
    size += absolute(axis->a[k]) + absolute(axis->b[k]);
  }
  Candidate c;
  closestOnTriangle(t, x, &c);
  if (!(c.squared <= 1e-28 * size * size)) return 0;
  best->squared = 0.0;
  best->parameter = at;
  for (int k = 0; k < 3; ++k) best->point[k] = c.point[k];
  best->feature = c.feature;
  return 1;
}

// sin^2 of the angle between lines
static const double kNearlyParallel = 1e-3;

// The shortest distance so far, from a point of the segment to a location on the triangle, as in placeOn().
struct Shortest {
  double squared, parameter, u, v;
  int32_t part;
};

// From an end of the segment to the face.
static inline void tryFace(const Triangle* t, const double (*e)[3], const double (*from)[3], double parameter,
                           Shortest* best) {
  double ac[3], n[3], m[3], weight[3], d[3];
  subtract(t->corner[2], t->corner[0], ac);
  cross(e[0], ac, n);
  for (int i = 0; i < 3; ++i) {
    cross(n, e[i], m);
    weight[i] = dot(from[i], m);
  }
  if (!(weight[0] > 0.0 && weight[1] > 0.0 && weight[2] > 0.0)) return;
  const double inverse = 1.0 / dot(n, n);
  const double u = weight[2] * inverse, v = weight[0] * inverse;
  for (int k = 0; k < 3; ++k) d[k] = from[0][k] - (u * e[0][k] + v * ac[k]);
  const double squared = dot(d, d);
  if (squared < best->squared) *best = {squared, parameter, u, v, kPartFace};
}

// Between a point of the segment and a point of an edge e. `from` leads from the start of e to that of the segment.
static inline void tryPair(const Axis* axis, const double* from, const double* e, double parameter, double u,
                           int32_t part, Shortest* best) {
  double d[3];
  for (int k = 0; k < 3; ++k) d[k] = (from[k] + parameter * axis->span[k]) - u * e[k];
  const double squared = dot(d, d);
  if (squared < best->squared) *best = {squared, parameter, u, 0.0, part};
}

// Edge i: from both ends of the segment, to the start of the edge, and between the interiors where the lines are
// nearest. For nearly parallel lines the small determinant would lose digits; cross products do not.
static inline void tryEdgeOnAxis(const Axis* axis, const double* from, const double* e, int32_t i, Shortest* best) {
  const double length = dot(e, e), perLength = inverseOf(length), along = dot(axis->span, e);
  const double alongEdge = dot(e, from), across = dot(axis->span, from);
  tryPair(axis, from, e, 0.0, within01(alongEdge * perLength), i, best);
  tryPair(axis, from, e, 1.0, within01((alongEdge + along) * perLength), i, best);
  tryPair(axis, from, e, within01(-across * axis->perSquared), 0.0, i, best);
  const double both = axis->squared * length, lines = both - along * along;
  double parameter = 0.0;
  if (lines > kNearlyParallel * both) {
    parameter = within01((along * alongEdge - length * across) / lines);
  } else {
    double common[3], moment[3];
    cross(axis->span, e, common);
    cross(e, from, moment);
    const double square = dot(common, common);
    if (square > 0.0) parameter = within01(dot(moment, common) / square);
  }
  const double u = within01((alongEdge + parameter * along) * perLength);
  parameter = within01((u * along - across) * axis->perSquared);
  tryPair(axis, from, e, parameter, u, i, best);
}

static inline void finishOnAxis(const Triangle* t, const Shortest* found, SegmentCandidate* best) {
  Candidate place;
  placeOn(t, found->part, found->u, found->v, &place);
  best->squared = found->squared;
  best->parameter = found->parameter;
  for (int k = 0; k < 3; ++k) best->point[k] = place.point[k];
  best->feature = place.feature;
}

// The shortest line connects an end and the face, or the segment and an edge (Lumelsky 1985). An edge has three cases:
// an end of the segment, a corner, or the interiors of both. If they cross, the length is zero. All candidates are
// points of both, so rounding costs no more than the difference of their distances.
static inline void closestToAxis(const Triangle* t, const Axis* axis, SegmentCandidate* best) {
  if (crossesAxis(t, axis, best) != 0) return;
  Shortest found = {1e308, 0.0, 0.0, 0.0, kPart01};
  double e[3][3], from[3][3];
  if (!isThin(t)) {
    edgesOf(t, axis->b, e, from);
    tryFace(t, e, from, 1.0, &found);
  }
  edgesOf(t, axis->a, e, from);
  if (!isThin(t)) tryFace(t, e, from, 0.0, &found);
  for (int i = 0; i < 3; ++i) tryEdgeOnAxis(axis, from[i], e[i], i, &found);
  finishOnAxis(t, &found, best);
  if (!isThin(t)) return;
  for (int end = 0; end < 2; ++end) {
    Candidate c;
    closestOnThin(t, end == 0 ? axis->a : axis->b, &c);
    if (!(c.squared < best->squared)) continue;
    best->squared = c.squared;
    best->parameter = end;
    for (int k = 0; k < 3; ++k) best->point[k] = c.point[k];
    best->feature = c.feature;
  }
}

// Half the solid angle of a triangle is the argument of this complex number (van Oosterom & Strackee 1983, eq. 8).
static inline void solidAngle(const Triangle* t, const double* p, double* re, double* im) {
  double v[3][3], length[3], normal[3];
  for (int i = 0; i < 3; ++i) {
    subtract(t->corner[i], p, v[i]);
    length[i] = __builtin_sqrt(dot(v[i], v[i]));
  }
  cross(v[1], v[2], normal);
  const double y = dot(v[0], normal);
  const double x = length[0] * length[1] * length[2] + dot(v[0], v[1]) * length[2] + dot(v[1], v[2]) * length[0] +
                   dot(v[2], v[0]) * length[1];
  const double size = absolute(x) + absolute(y);
  const bool isSeen = t->index >= 0 && size > 0.0;
  *re = isSeen ? x / size : 1.0;
  *im = isSeen ? y / size : 0.0;
}
