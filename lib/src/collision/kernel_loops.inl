// The search loops, written on a vector `V` of 16 floats that the including file defines together with
// load, store, set, add, sub, mul, divide, mad, root, inverseRoot (to 2^-11), maximum, minimum, smallest,
// lessOrEqualMask, selectGreater, compress and compressNumbers (the lanes that choose() made of a mask to consecutive
// places; up to 16 are written), closestOfFour and closestToAxisOfFour. Everything has internal linkage.

// Error of the float distances, with room to spare: at most 20 roundings of numbers not larger than |q|_1 + 2 extent
// enter, 2^-24 each, and a triangle that is represented by its edges alone is lower than 2^-20.
static const double kBoundError = 0x1p-19;
// Beyond this many mesh sizes float boxes no longer tell triangles apart; doubles take over.
static const double kFar = 64.0;
static const double kHuge = 1e300;
// A list is begun when the tool, going on as it does, leaves the last one within this many queries; its ball is at
// least kLeastReach queries wide and lies kLead radii ahead of the place where it is needed first.
static const double kAhead = 3.0;
static const double kLeastReach = 3.0;
static const double kLead = 0.9;
// The work on a list. One query does kWorkPerQuery at most, unless it needs a list that is not complete. A list that
// took less than kLeastWork was too small, one above kMostWork too large; beyond kNoList it is given up, and no other
// begun for a while: kPause queries, twice as many each time up to kLongPause.
enum { kNodeWork = 2, kLeafWork = 3, kWorkPerQuery = 16, kLeastWork = 18, kMostWork = 25, kNoList = 64 };
enum { kPause = 32, kLongPause = 1024 };
// Of the clearance of a segment beyond its reach this much is worth knowing.
static const float kEnough = 0.5f;
// More triangles of a leaf than these that may be nearest to a segment are worth better bounds.
enum { kFewOfLeaf = 3, kManyOfLeaf = 6 };

enum { kMostCandidates = 64 };
// Cache lines: of a node, of the frames of a leaf, of all of a leaf.
enum {
  kLine = 64,
  kNodeLines = sizeof(Node) / kLine,
  kFrameLines = sizeof(Leaf::row) / kLine,
  kLeafLines = sizeof(Leaf) / kLine
};

struct Search {
  const Mesh* mesh;
  const double* point;  // original coordinates
  double local[3];
  float x, y, z;  // local, rounded
  double slack;   // absolute error of a float distance
  float slackUp;  // the same, not smaller
  float least;    // smallest squared float distance so far
  float limit;    // largest squared float distance that may still matter
  // Triangles whose exact distance has yet to be looked at.
  int candidates;
  int32_t candidate[kMostCandidates];
  float candidateBound[kMostCandidates];
  // The best exact answer so far.
  double squared;
  int32_t slot;
  int32_t index;
  Candidate best;
};

static inline float upward(double value) {
  return value < 3e38 ? static_cast<float>(value) * 1.000001f + 1e-37f : 3.4e38f;
}

static inline float limitOf(double distance, double slack) {
  const double d = distance + slack;
  return upward(d * d);
}

static inline void lowerLimit(Search* s, float limit) {
  if (limit < s->limit) s->limit = limit;
}

// No triangle whose float distance is above the limit can be nearest: within `slack` of their float distances, the
// nearest so far lies below it.
static inline void tightenToFloat(Search* s, float least) {
  s->least = least;
  const float d = __builtin_sqrtf(least) + 2.0f * s->slackUp;
  lowerLimit(s, d * d * 1.000002f);
}

static inline void tightenToExact(Search* s) {
  lowerLimit(s, limitOf(__builtin_sqrt(s->squared) * s->mesh->scale, s->slack));
}

static inline int isFar(const double* local) {
  return !(local[0] < kFar && local[0] > -kFar && local[1] < kFar && local[1] > -kFar && local[2] < kFar &&
           local[2] > -kFar);
}

static inline double slackOf(const Mesh* mesh, const double* local) {
  return kBoundError * (absolute(local[0]) + absolute(local[1]) + absolute(local[2]) + 2.0 * mesh->extent);
}

static inline void startSearch(Search* s, const Mesh* mesh, const double* point, double limitSquared) {
  s->mesh = mesh;
  s->point = point;
  for (int k = 0; k < 3; ++k) s->local[k] = (point[k] - mesh->centre[k]) * mesh->scale;
  s->x = static_cast<float>(s->local[0]);
  s->y = static_cast<float>(s->local[1]);
  s->z = static_cast<float>(s->local[2]);
  s->slack = slackOf(mesh, s->local);
  s->slackUp = static_cast<float>(s->slack) * 1.000001f;
  s->squared = limitSquared < kHuge ? limitSquared : kHuge;
  s->slot = -1;
  s->index = 0x7fffffff;
  s->least = 3.4e38f;
  s->limit = 3.4e38f;
  s->candidates = 0;
  if (limitSquared < kHuge) tightenToExact(s);
}

// Smaller distance wins; at the same distance the smaller index.
static inline void keepNearer(Search* s, const Triangle* t, const Candidate* c) {
  if (!(c->squared < s->squared || (c->squared == s->squared && t->index < s->index))) return;
  s->squared = c->squared;
  s->slot = static_cast<int32_t>(t - s->mesh->triangles);
  s->index = t->index;
  s->best = *c;
}

static inline void tryTriangle(Search* s, int32_t slot) {
  const Triangle* t = s->mesh->triangles + slot;
  if (t->index < 0) return;
  Candidate c;
  closestOnTriangle(t, s->point, &c);
  keepNearer(s, t, &c);
}

// Up to four.
static inline void tryTriangles(Search* s, const int32_t* slot, int count) {
  if (count == 1) {
    tryTriangle(s, slot[0]);
    return;
  }
  const Triangle* t[4];
  int odd = 0;
  for (int i = 0; i < 4; ++i) {
    t[i] = s->mesh->triangles + slot[i < count ? i : 0];
    odd |= static_cast<int>(t[i]->index < 0) | static_cast<int>(isThin(t[i]));
  }
  if (odd != 0) {
    for (int i = 0; i < count; ++i) tryTriangle(s, slot[i]);
    return;
  }
  Candidate c;
  keepNearer(s, t[closestOfFour(t, s->point, &c)], &c);
}

// 16 lanes of rows: of a leaf, of the boxes of a node, of a list.
struct Lanes {
  const float* first;
  int stride;
  V row(int i) const { return load(first + i * stride); }
};

static inline Lanes lanesOf(const Leaf* leaf) { return {leaf->row[0], kWidth}; }
static inline Lanes lanesOf(const Node* node) { return {node->row[0], kWidth}; }

// Squared distances of 16 triangles from points in their frames: to the plane where the point lies over the triangle,
// else to the nearest edge (along the edge beyond its ends, across it in the plane, and the height over the plane).
// `from`: the offsets in the plane (u, v) from the nearest points of the triangles.
static inline V frameDistances(const Lanes& frames, V u, V v, V h, V* from = nullptr) {
  const V zero = set(0.0f);
  const V length0 = frames.row(kLength), length1 = frames.row(kLength + 1), length2 = frames.row(kLength + 2);
  const V c1 = frames.row(kCosine), s1 = frames.row(kSine), c2 = frames.row(kCosine + 1), s2 = frames.row(kSine + 1);
  const V inside = frames.row(kInside);
  const V beyond = sub(u, length0);
  // Across: positive outside. Along: from the start of the edge.
  const V across0 = sub(zero, v);
  const V across1 = sub(mul(s1, beyond), mul(c1, v)), along1 = mad(c1, beyond, mul(s1, v));
  const V across2 = sub(mul(c2, v), mul(s2, u)), along2 = mad(c2, u, mul(s2, v));
  const V end0 = sub(u, maximum(minimum(u, length0), zero));
  const V end1 = sub(along1, maximum(minimum(along1, length1), zero));
  const V end2 = sub(along2, maximum(minimum(along2, length2), zero));
  const V edge0 = mad(v, v, mul(end0, end0));
  const V edge1 = mad(across1, across1, mul(end1, end1));
  const V edge2 = mad(across2, across2, mul(end2, end2));
  const V edges = minimum(minimum(edge0, edge1), edge2);
  const V out = maximum(maximum(across0, across1), across2);
  if (from != nullptr) {
    const V first[2] = {end0, v};
    const V second[2] = {mad(end1, c1, mul(across1, s1)), sub(mul(end1, s1), mul(across1, c1))};
    const V third[2] = {sub(mul(end2, c2), mul(across2, s2)), mad(end2, s2, mul(across2, c2))};
    for (int i = 0; i < 2; ++i) {
      const V of01 = selectGreater(edge0, edge1, second[i], first[i]);
      const V ofEdges = selectGreater(minimum(edge0, edge1), edge2, third[i], of01);
      from[i] = selectGreater(out, inside, ofEdges, zero);
    }
  }
  return mad(h, h, selectGreater(out, inside, edges, zero));
}

static inline void toFrames(const Lanes& frames, V x, V y, V z, V* f) {
  for (int i = 0; i < 3; ++i)
    f[i] = mad(frames.row(3 * i), x,
               mad(frames.row(3 * i + 1), y, mad(frames.row(3 * i + 2), z, frames.row(kOffset + i))));
}

static inline void turnToFrames(const Lanes& frames, const V* direction, V* f) {
  for (int i = 0; i < 3; ++i)
    f[i] = mad(frames.row(3 * i), direction[0],
               mad(frames.row(3 * i + 1), direction[1], mul(frames.row(3 * i + 2), direction[2])));
}

static inline V triangleDistances(const Lanes& frames, V x, V y, V z, V* height = nullptr) {
  V f[3];
  toFrames(frames, x, y, z, f);
  if (height != nullptr) *height = f[2];
  return frameDistances(frames, f[0], f[1], f[2]);
}

// Looks at the exact distances of the candidates and forgets them. They are few: all lie within the error of the float
// distances.
static inline void settle(Search* s) {
  int32_t slot[kMostCandidates];
  int count = 0;
  for (int i = 0; i < s->candidates; ++i)
    if (s->candidateBound[i] <= s->limit) slot[count++] = s->candidate[i];
  for (int i = 0; i < count; i += 4) tryTriangles(s, slot + i, count - i < 4 ? count - i : 4);
  s->candidates = 0;
}

// To the second cache: the first one has no room for all that may be asked for.
static inline void fetch(const void* address, int lines) {
  for (int i = 0; i < lines; ++i) __builtin_prefetch(static_cast<const char*>(address) + kLine * i, 0, 2);
}

static inline void fetchChild(const Mesh* mesh, int32_t child, int leafLines = kFrameLines) {
  if (child < 0) {
    fetch(mesh->leaves + ~child, leafLines);
  } else {
    fetch(mesh->nodes + child, kNodeLines);
  }
}

static inline void keepCandidate(Search* s, int32_t slot, float bound) {
  if (s->candidates == kMostCandidates) {
    int kept = 0;
    for (int i = 0; i < s->candidates; ++i) {
      if (!(s->candidateBound[i] <= s->limit)) continue;
      s->candidate[kept] = s->candidate[i];
      s->candidateBound[kept++] = s->candidateBound[i];
    }
    s->candidates = kept;
    if (kept > kMostCandidates / 2) {
      settle(s);
      tightenToExact(s);
    }
  }
  fetch(s->mesh->triangles + slot, 2);
  s->candidate[s->candidates] = slot;
  s->candidateBound[s->candidates++] = bound;
}

static inline void searchLeaf(Search* s, int32_t leaf) {
  const V b = triangleDistances(lanesOf(s->mesh->leaves + leaf), set(s->x), set(s->y), set(s->z));
  unsigned mask = lessOrEqualMask(b, set(s->limit));
  if (mask == 0) return;
  const float least = smallest(b);
  if (least < s->least) {
    tightenToFloat(s, least);
    mask = lessOrEqualMask(b, set(s->limit));
  }
  float bounds[kWidth];
  store(bounds, b);
  for (; mask != 0; mask &= mask - 1) {
    const int lane = __builtin_ctz(mask);
    keepCandidate(s, leaf * kWidth + lane, bounds[lane]);
  }
}

// How far a point lies from the middles of the boxes of a node, along axis i.
static inline V alongAxis(const Lanes& boxes, int i, V x, V y, V z) {
  const V a = mad(boxes.row(3 * i), x, mad(boxes.row(3 * i + 1), y, mad(boxes.row(3 * i + 2), z, boxes.row(9 + i))));
  return maximum(a, sub(set(0.0f), a));
}

// Squared distances of the boxes of a node from a point.
static inline V boxBounds(const Node* node, V x, V y, V z) {
  const Lanes boxes = lanesOf(node);
  V squared = set(0.0f);
  for (int i = 0; i < 3; ++i) {
    const V d = maximum(sub(alongAxis(boxes, i, x, y, z), boxes.row(12 + i)), set(0.0f));
    squared = mad(d, d, squared);
  }
  return squared;
}

// Every box holds a triangle, which is no farther than the farthest corner of the box.
static inline void tightenToBoxes(Search* s, const Node* node, V x, V y, V z) {
  const Lanes boxes = lanesOf(node);
  V squared = set(0.0f);
  for (int i = 0; i < 3; ++i) {
    const V d = add(alongAxis(boxes, i, x, y, z), boxes.row(12 + i));
    squared = mad(d, d, squared);
  }
  const float d = __builtin_sqrtf(smallest(squared)) + s->slackUp;
  lowerLimit(s, d * d * 1.000002f);
}

// Nodes and leaves that have yet to be looked at, and no nearer than their bounds.
struct Stack {
  int top = 0;
  float bound[kStackSize + kWidth];
  int32_t child[kStackSize + kWidth];
};

// Of the children in the mask the nearest one comes next, at once; the others wait.
static inline int32_t goDown(const Mesh* mesh, V bounds, const int32_t* child, unsigned mask, Stack* stack) {
  const unsigned least = mask & lessOrEqualMask(bounds, set(smallest(bounds)));
  const int nearest = __builtin_ctz(least != 0 ? least : mask);
  mask &= ~(1u << nearest);
  if (mask != 0) {
    const int bottom = stack->top;
    stack->top += __builtin_popcount(mask);
    const Chosen lanes = choose(mask);
    compress(bounds, lanes, stack->bound + bottom);
    compress(child, lanes, stack->child + bottom);
    for (int i = bottom; i < stack->top; ++i) fetchChild(mesh, stack->child[i]);
  }
  return child[nearest];
}

// Depth first, the nearest child first.
static inline void searchTree(Search* s, int cold) {
  Stack stack;
  int32_t current = s->mesh->root;
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  for (;;) {
    if (current < 0) {
      searchLeaf(s, ~current);
    } else {
      const Node* node = s->mesh->nodes + current;
      const V b = boxBounds(node, x, y, z);
      if (cold != 0 && s->least > 3e38f) tightenToBoxes(s, node, x, y, z);
      const unsigned mask = node->lanes & lessOrEqualMask(b, set(s->limit));
      if (mask != 0) {
        current = goDown(s->mesh, b, node->child, mask, &stack);
        continue;
      }
    }
    do {
      if (stack.top == 0) return;
      --stack.top;
    } while (!(stack.bound[stack.top] <= s->limit));
    current = stack.child[stack.top];
  }
}

// Far away: the same search with distances to the boxes in double.
static inline double boxDistance(const AlignedBoxes* boxes, int lane, const double* q) {
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double below = static_cast<double>(boxes->low[k][lane]) - q[k];
    const double above = q[k] - static_cast<double>(boxes->high[k][lane]);
    const double d = below > above ? below : above;
    if (d > 0.0) squared += d * d;
  }
  return squared;
}

static inline void searchFar(Search* s) {
  struct FarEntry {
    double squared;
    int32_t child;
  } stack[kStackSize];
  const double shrink = 1.0 - 1e-12;
  const double unit = s->mesh->scale * s->mesh->scale;
  int top = 0;
  stack[top].squared = 0.0;
  stack[top++].child = s->mesh->root;
  while (top > 0) {
    const FarEntry entry = stack[--top];
    if (entry.squared * shrink > s->squared * unit) continue;
    if (entry.child < 0) {
      for (int lane = 0; lane < kWidth; ++lane) tryTriangle(s, ~entry.child * kWidth + lane);
      continue;
    }
    const Node* node = s->mesh->nodes + entry.child;
    const AlignedBoxes* boxes = s->mesh->boxes + entry.child;
    const int bottom = top;
    for (int lane = 0; lane < kWidth; ++lane) {
      if (boxes->low[0][lane] > boxes->high[0][lane]) continue;
      const double squared = boxDistance(boxes, lane, s->local);
      if (squared * shrink > s->squared * unit) continue;
      int place = top++;
      for (; place > bottom && stack[place - 1].squared < squared; --place) stack[place] = stack[place - 1];
      stack[place].squared = squared;
      stack[place].child = node->child[lane];
    }
  }
}

using List = Cache::List;

// Each triangle lies behind a plane across the line to its nearest point; from a point e farther on it is no nearer
// than height + normal.e. That holds for any normal not longer than 1, as the height is taken over the corners: a point
// close to the nearest one does.
struct Planes {
  V normal[3], height;
};

static inline Planes planesBefore(const Lanes& frames, V x, V y, V z) {
  const V zero = set(0.0f);
  const V c1 = frames.row(kCosine), s1 = frames.row(kSine), c2 = frames.row(kCosine + 1), s2 = frames.row(kSine + 1);
  const V length0 = frames.row(kLength), length2 = frames.row(kLength + 2);
  V q[3], n[3];
  toFrames(frames, x, y, z, q);
  // Into the triangle: back over one edge, then over the other, then into its box.
  const V over1 = maximum(sub(mul(s1, sub(q[0], length0)), mul(c1, q[1])), zero);
  const V u1 = sub(q[0], mul(s1, over1)), v1 = mad(c1, over1, q[1]);
  const V over2 = maximum(sub(mul(c2, v1), mul(s2, u1)), zero);
  const V top = mul(length2, s2);
  n[0] = sub(q[0], maximum(minimum(mad(s2, over2, u1), length0), zero));
  n[1] = sub(q[1], maximum(minimum(sub(v1, mul(c2, over2)), top), zero));
  n[2] = q[2];
  const V squared = mad(n[0], n[0], mad(n[1], n[1], mul(n[2], n[2])));
  const V inverse = divide(set(1.0f), root(maximum(squared, set(1e-30f))));
  for (V& component : n) component = mul(component, inverse);
  const V corners = maximum(maximum(zero, mul(n[0], length0)), mad(n[1], top, mul(n[0], mul(length2, c2))));
  Planes planes;
  planes.height = sub(mad(n[0], q[0], mad(n[1], q[1], mul(n[2], q[2]))), corners);
  for (int i = 0; i < 3; ++i)
    planes.normal[i] = mad(frames.row(i), n[0], mad(frames.row(3 + i), n[1], mul(frames.row(6 + i), n[2])));
  return planes;
}

// Which convex bodies can be nearest within r of the origin o. Let x be a point of the mesh, D its distance from o and
// m its direction: at o + e it is at most D + m.e + r^2 / 2D away, and a body behind a plane of normal n and height f
// is at least f + n.e away. Hence only bodies with f - D <= r |m - n| + r^2 / 2D matter, besides the plain
// f - D <= 2 r.
struct Reach {
  V plain;   // D + 2 r
  V square;  // its square
  V start;   // D + r^2 / 2D
  V turn;    // r^2
  V m[3];
};

static inline Reach reachOf(const double* origin, const double* x, double r, double slack) {
  double m[3];
  subtract(origin, x, m);
  const double D = __builtin_sqrt(dot(m, m));
  const double inverse = D > slack ? 1.0 / D : 0.0;
  Reach reach;
  reach.plain = set(upward(D + 2.0 * (r + slack)));
  reach.square = set(limitOf(D + 2.0 * r, 2.0 * slack));
  reach.start = set(D > slack ? upward(D + 0.5 * r * r * inverse + 2.0 * slack) : 3e38f);
  reach.turn = set(upward(1.0001 * r * r));
  for (int k = 0; k < 3; ++k) reach.m[k] = set(static_cast<float>(m[k] * inverse));
  return reach;
}

static inline unsigned planesWithin(const Reach& reach, const Planes& planes) {
  V squared = set(0.0f);
  for (int k = 0; k < 3; ++k) {
    const V d = sub(reach.m[k], planes.normal[k]);
    squared = mad(d, d, squared);
  }
  const V more = maximum(sub(planes.height, reach.start), set(0.0f));
  return lessOrEqualMask(planes.height, reach.plain) & lessOrEqualMask(mul(more, more), mul(reach.turn, squared));
}

// The plane of a box is as far away as its nearest point.
static inline unsigned boxesWithin(const Reach& reach, const Lanes& boxes, V x, V y, V z) {
  const V zero = set(0.0f);
  V squared = zero, ahead = zero;
  for (int i = 0; i < 3; ++i) {
    const V ax = boxes.row(3 * i), ay = boxes.row(3 * i + 1), az = boxes.row(3 * i + 2), half = boxes.row(12 + i);
    const V a = mad(ax, x, mad(ay, y, mad(az, z, boxes.row(9 + i))));
    const V d = sub(a, maximum(minimum(a, half), sub(zero, half)));
    squared = mad(d, d, squared);
    ahead = mad(d, mad(ax, reach.m[0], mad(ay, reach.m[1], mul(az, reach.m[2]))), ahead);
  }
  const V f = root(squared), more = maximum(sub(f, reach.start), zero);
  // f |m - n|^2 = 2 (f - m.d), rounded up
  const V turn = sub(mul(f, set(2.00002f)), add(ahead, ahead));
  return lessOrEqualMask(squared, reach.square) & lessOrEqualMask(mul(mul(more, more), f), mul(reach.turn, turn));
}

static inline int holds(const List* list, const double* q) {
  return list->radius >= 0.0 && squaredDistance(q, list->origin) <= list->radius * list->radius;
}

// Lower bounds of the distances of 16 entries of a list from its origin plus e.
static inline V boundsOf(const List* list, int first, const V* e) {
  V bound = load(list->height + first);
  for (int k = 0; k < 3; ++k) bound = mad(load(list->normal[k] + first), e[k], bound);
  return bound;
}

static inline void fromOrigin(const List* list, const double* q, V* e) {
  for (int k = 0; k < 3; ++k) e[k] = set(static_cast<float>(q[k] - list->origin[k]));
}

// The exact distances of the triangles that the planes do not rule out, four at a time.
static inline void searchList(Search* s, const List* list, float most) {
  int32_t slot[Cache::kTriangles + kWidth];
  int count = 0;
  V e[3];
  fromOrigin(list, s->local, e);
  for (int first = 0; first < list->count; first += kWidth) {
    const unsigned mask = lessOrEqualMask(boundsOf(list, first, e), set(most));
    compress(list->slot + first, choose(mask), slot + count);
    count += __builtin_popcount(mask);
  }
  for (int i = 0; i < count; i += 4) tryTriangles(s, slot + i, count - i < 4 ? count - i : 4);
}

// The witness moves to the triangle that seems nearest to the origin, if that is nearer.
static inline void improveWitness(const Mesh* mesh, const List* list, const double* origin, double* witness) {
  V e[3];
  fromOrigin(list, origin, e);
  float least = 3.4e38f;
  int32_t slot = -1;
  for (int first = 0; first < list->count; first += kWidth) {
    const V bound = boundsOf(list, first, e);
    const float here = smallest(bound);
    if (!(here < least)) continue;
    least = here;
    slot = list->slot[first + __builtin_ctz(lessOrEqualMask(bound, set(here)))];
  }
  if (slot < 0) return;
  double p[3], x[3];
  for (int k = 0; k < 3; ++k) p[k] = origin[k] / mesh->scale + mesh->centre[k];
  Candidate c;
  closestOnTriangle(mesh->triangles + slot, p, &c);
  for (int k = 0; k < 3; ++k) x[k] = (c.point[k] - mesh->centre[k]) * mesh->scale;
  if (!(squaredDistance(x, origin) < squaredDistance(witness, origin))) return;
  for (int k = 0; k < 3; ++k) witness[k] = x[k];
}

// For a tool that goes on by `motion` a query and needs the list from `start` on.
static inline void beginList(const Mesh* mesh, const double* start, const double* motion, Cache* cache) {
  List* list = &cache->list[1 - cache->active];
  const double step = __builtin_sqrt(dot(motion, motion));
  const double r = cache->margin > kLeastReach * step ? cache->margin : kLeastReach * step;
  const double lead = step > 1e-3 * r ? kLead * r / step : 0.0;
  for (int k = 0; k < 3; ++k) {
    list->origin[k] = start[k] + lead * motion[k];
    cache->witness[k] = cache->surface[k];
  }
  const List* last = &cache->list[cache->active];
  if (last->radius >= 0.0) improveWitness(mesh, last, list->origin, cache->witness);
  list->radius = -1.0;
  list->count = 0;
  list->slack = static_cast<float>(slackOf(mesh, list->origin)) * 1.000001f;
  cache->ball = r;
  cache->work = 0;
  cache->firstNode = cache->firstLeaf = cache->leaves = 0;
  cache->node[0] = mesh->root;
  cache->nodes = 1;
}

static inline void dropList(Cache* cache) { cache->firstNode = cache->nodes = cache->firstLeaf = cache->leaves = 0; }

// The ball may be larger than the margin where the tool has jumped: that is no reason for larger ones from now on.
static inline void lowerMargin(Cache* cache, double margin) {
  if (margin < cache->margin) cache->margin = margin;
}

static inline void giveUpList(Cache* cache) {
  dropList(cache);
  lowerMargin(cache, 0.6 * cache->ball);
  cache->rest = cache->pause;
  if (cache->pause < kLongPause) cache->pause *= 2;
}

static inline bool isListOpen(const Cache* cache) {
  return cache->firstNode < cache->nodes || cache->firstLeaf < cache->leaves;
}

// Goes on with the list until it is complete or the work is done: the nodes first, level by level, so that memory has
// time to bring them, then the leaves.
static inline void extendList(const Mesh* mesh, int work, Cache* cache) {
  List* list = &cache->list[1 - cache->active];
  const Reach reach = reachOf(list->origin, cache->witness, cache->ball, slackOf(mesh, list->origin));
  const V x = set(static_cast<float>(list->origin[0])), y = set(static_cast<float>(list->origin[1])),
          z = set(static_cast<float>(list->origin[2]));
  int first = cache->firstNode, nodes = cache->nodes, leaves = cache->leaves, count = list->count, left = work;
  for (; first < nodes && left > 0; left -= kNodeWork) {
    const Node* node = mesh->nodes + cache->node[first++];
    const unsigned near = node->lanes & boxesWithin(reach, lanesOf(node), x, y, z);
    const unsigned nearLeaves = near & node->leaves, nearNodes = near & ~node->leaves;
    const int before = leaves, nodesBefore = nodes;
    leaves += __builtin_popcount(nearLeaves);
    nodes += __builtin_popcount(nearNodes);
    if (leaves > Cache::kLeaves || nodes > Cache::kNodes) return giveUpList(cache);
    compress(node->child, choose(nearLeaves), cache->leaf + before);
    compress(node->child, choose(nearNodes), cache->node + nodesBefore);
    for (int i = before; i < leaves; ++i) fetchChild(mesh, cache->leaf[i]);
    for (int i = nodesBefore; i < nodes; ++i) fetchChild(mesh, cache->node[i]);
  }
  cache->firstNode = first;
  cache->nodes = nodes;
  for (first = cache->firstLeaf; first < leaves && left > 0; left -= kLeafWork) {
    const int32_t leaf = ~cache->leaf[first++];
    const Planes planes = planesBefore(lanesOf(mesh->leaves + leaf), x, y, z);
    const unsigned near = planesWithin(reach, planes);
    const int before = count;
    count += __builtin_popcount(near);
    if (count > Cache::kTriangles) return giveUpList(cache);
    const Chosen lanes = choose(near);
    for (int k = 0; k < 3; ++k) compress(planes.normal[k], lanes, list->normal[k] + before);
    compress(planes.height, lanes, list->height + before);
    compressNumbers(leaf * kWidth, lanes, list->slot + before);
    for (int i = before; i < count; ++i) fetch(mesh->triangles + list->slot[i], 2);
  }
  cache->firstLeaf = first;
  cache->leaves = leaves;
  list->count = count;
  cache->work += work - left;
  if (isListOpen(cache)) {
    if (cache->work > kNoList) giveUpList(cache);
    return;
  }
  for (int k = 0; k < 3; ++k) store(list->normal[k] + count, set(0.0f));
  store(list->height + count, set(3e38f));
  list->radius = cache->ball * (1.0 - 1e-6);
  cache->pause = kPause;
  if (cache->work < kLeastWork) cache->margin = 1.08 * cache->ball;
  if (cache->work > kMostWork) lowerMargin(cache, 0.92 * cache->ball);
}

// The previous answer is on the mesh, so its distance bounds the new one. Where a list holds, it answers; else the tree
// is searched.
static inline void searchWithCache(Search* s, Cache* cache) {
  const float surface = __builtin_sqrtf(static_cast<float>(squaredDistance(s->local, cache->surface))) * 1.000001f;
  if (!holds(&cache->list[cache->active], s->local)) {
    List* next = &cache->list[1 - cache->active];
    if (isListOpen(cache) && squaredDistance(s->local, next->origin) <= cache->ball * cache->ball * (1.0 - 4e-6))
      extendList(s->mesh, kNoList, cache);
    if (!holds(next, s->local)) {
      lowerLimit(s, (surface + s->slackUp) * (surface + s->slackUp) * 1.000002f);
      searchTree(s, 0);
      return;
    }
    cache->active = 1 - cache->active;
  }
  // The planes of the list are as exact as numbers of the size of its origin, which may be farther out than the point.
  const List* list = &cache->list[cache->active];
  const float slack = s->slackUp > list->slack ? s->slackUp : list->slack;
  float most = surface + 3.0f * slack;
  if (s->limit < most * most) most = __builtin_sqrtf(s->limit) * 1.000001f + 2.0f * slack;
  searchList(s, list, most);
}

// A list is made before it is needed, over some queries, so that none of them takes long.
static inline void workAhead(const Mesh* mesh, const double* local, const double* motion, Cache* cache) {
  if (!isListOpen(cache)) {
    if (cache->rest > 0) {
      --cache->rest;
      return;
    }
    double start[3];
    for (int k = 0; k < 3; ++k) start[k] = local[k] + kAhead * motion[k];
    if (isFar(start)) return;  // a jump, not the tool's motion
    if (holds(&cache->list[cache->active], start) || holds(&cache->list[1 - cache->active], start)) return;
    beginList(mesh, start, motion, cache);
  }
  extendList(mesh, kWorkPerQuery, cache);
}

static void closest(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer) {
  Search s;
  startSearch(&s, &mesh, point, limitSquared);
  const int known = cache != nullptr && cache->revision == mesh.revision;
  if (cache != nullptr && !known) {
    cache->revision = 0;
    cache->list[0].radius = cache->list[1].radius = -1.0;
    dropList(cache);
    cache->rest = 0;
    cache->pause = kPause;
    cache->margin = 1.0 / 512.0;
  }
  if (isFar(s.local)) {
    searchFar(&s);
  } else if (known) {
    searchWithCache(&s, cache);
  } else {
    searchTree(&s, mesh.tight);
  }
  settle(&s);
  if (cache != nullptr && s.slot >= 0) {
    double motion[3];
    subtract(s.local, cache->query, motion);
    cache->revision = mesh.revision;
    for (int k = 0; k < 3; ++k) {
      cache->query[k] = s.local[k];
      cache->surface[k] = (s.best.point[k] - mesh.centre[k]) * mesh.scale;
    }
    if (known && !isFar(s.local)) workAhead(&mesh, s.local, motion, cache);
  }
  answer->slot = s.slot;
  answer->nearest = s.slot >= 0 ? s.best : Candidate{s.squared, {point[0], point[1], point[2]}, kFace, 0.0, 0.0};
}

// Boxes against the box of the segment, grown by the reach: floats for the choice, the visitor decides exactly.
static void visit(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visitor,
                  void* context) {
  int32_t stack[kStackSize];
  int top = 0;
  double low[3], high[3], size = 2.0 * mesh.extent;
  for (int k = 0; k < 3; ++k) {
    const double a = (from[k] - mesh.centre[k]) * mesh.scale, b = (to[k] - mesh.centre[k]) * mesh.scale;
    low[k] = a < b ? a : b;
    high[k] = a < b ? b : a;
    size += absolute(low[k]) > absolute(high[k]) ? absolute(low[k]) : absolute(high[k]);
  }
  const double slack = kBoundError * size;
  double middle[3], extent[3];
  for (int k = 0; k < 3; ++k) {
    middle[k] = 0.5 * (low[k] + high[k]);
    extent[k] = 0.5 * (high[k] - low[k]);
  }
  const double half = __builtin_sqrt(dot(extent, extent));
  stack[top++] = mesh.root;
  while (top > 0) {
    const int32_t current = stack[--top];
    if (current < 0) {
      // Within reach of the segment is within reach of its middle, half its length added.
      unsigned near = 0xffffu;
      if (!isFar(middle)) {
        const V d = triangleDistances(lanesOf(mesh.leaves + ~current), set(static_cast<float>(middle[0])),
                                      set(static_cast<float>(middle[1])), set(static_cast<float>(middle[2])));
        near = lessOrEqualMask(d, set(limitOf(reach * mesh.scale + half, slack)));
      }
      for (; near != 0; near &= near - 1) {
        const int32_t slot = ~current * kWidth + __builtin_ctz(near);
        if (mesh.triangles[slot].index >= 0) reach = visitor(context, slot, reach);
      }
      continue;
    }
    const Node* node = mesh.nodes + current;
    const AlignedBoxes* boxes = mesh.boxes + current;
    const V zero = set(0.0f);
    V squared = zero;
    for (int k = 0; k < 3; ++k) {
      const V below = sub(load(boxes->low[k]), set(static_cast<float>(high[k])));
      const V above = sub(set(static_cast<float>(low[k])), load(boxes->high[k]));
      const V d = maximum(maximum(below, above), zero);
      squared = mad(d, d, squared);
    }
    unsigned mask = node->lanes & lessOrEqualMask(squared, set(limitOf(reach * mesh.scale, slack)));
    for (; mask != 0; mask &= mask - 1) stack[top++] = node->child[__builtin_ctz(mask)];
  }
}

// A segment in local coordinates: start, unit direction, length.
struct LocalSegment {
  V start[3], direction[3], length;
  double slack;  // absolute error of a float distance
};

// 0: it lies too far away for floats.
static inline int toLocal(const Mesh& mesh, const double from[3], const double to[3], LocalSegment* segment) {
  double a[3], b[3], span[3], size = 2.0 * mesh.extent;
  for (int k = 0; k < 3; ++k) {
    a[k] = (from[k] - mesh.centre[k]) * mesh.scale;
    b[k] = (to[k] - mesh.centre[k]) * mesh.scale;
    span[k] = b[k] - a[k];
    size += absolute(a[k]) > absolute(b[k]) ? absolute(a[k]) : absolute(b[k]);
  }
  if (isFar(a) || isFar(b)) return 0;
  const double length = __builtin_sqrt(dot(span, span));
  for (int k = 0; k < 3; ++k) {
    segment->start[k] = set(static_cast<float>(a[k]));
    segment->direction[k] = set(length > 0.0 ? static_cast<float>(span[k] / length) : 0.0f);
  }
  segment->length = set(static_cast<float>(length));
  segment->slack = kBoundError * size;
  return 1;
}

static inline V between(V x, V low, V high) { return maximum(minimum(x, high), low); }

// Squared distances of the boxes of a node from a segment, from below. Only the feet of a box on the segment can be
// nearest to it. The plane across the line from the middle of the feet to the box keeps the box away; along the segment
// the height over it falls by no more than its slope.
static inline V segmentBounds(const Node* node, const LocalSegment* segment) {
  const Lanes boxes = lanesOf(node);
  const V zero = set(0.0f), middleOf = set(0.5f);
  V start[3], direction[3], half[3], foot = zero, extent = zero;
  for (int i = 0; i < 3; ++i) {
    const V x = boxes.row(3 * i), y = boxes.row(3 * i + 1), z = boxes.row(3 * i + 2);
    start[i] = mad(x, segment->start[0], mad(y, segment->start[1], mad(z, segment->start[2], boxes.row(9 + i))));
    direction[i] = mad(x, segment->direction[0], mad(y, segment->direction[1], mul(z, segment->direction[2])));
    half[i] = boxes.row(12 + i);
    foot = mad(start[i], direction[i], foot);
    extent = mad(maximum(direction[i], sub(zero, direction[i])), half[i], extent);
  }
  const V first = between(sub(sub(zero, foot), extent), zero, segment->length);
  const V last = between(sub(extent, foot), zero, segment->length);
  const V middle = mul(add(first, last), middleOf), halfLength = mul(sub(last, first), middleOf);
  V squared = zero, ahead = zero;
  for (int i = 0; i < 3; ++i) {
    const V v = mad(direction[i], middle, start[i]);
    const V d = sub(v, maximum(minimum(v, half[i]), sub(zero, half[i])));
    squared = mad(d, d, squared);
    ahead = mad(d, direction[i], ahead);
  }
  const V height = maximum(sub(squared, mul(maximum(ahead, sub(zero, ahead)), halfLength)), zero);
  return divide(mul(height, height), maximum(squared, set(1e-30f)));
}

// A segment as the frames of the triangles of a leaf see it, and their feet on it: `halfLength` to both sides of the
// middle.
struct Feet {
  V start[3], direction[3], middle, halfLength;
};

static inline Feet feetOn(const Lanes& frames, const LocalSegment* segment) {
  const V zero = set(0.0f), half = set(0.5f);
  Feet feet;
  toFrames(frames, segment->start[0], segment->start[1], segment->start[2], feet.start);
  turnToFrames(frames, segment->direction, feet.direction);
  const V *start = feet.start, *direction = feet.direction;
  const V a = sub(zero, mad(start[0], direction[0], mad(start[1], direction[1], mul(start[2], direction[2]))));
  const V b = mad(frames.row(kLength), direction[0], a);
  const V c = mad(frames.row(kLength + 2),
                  mad(frames.row(kCosine + 1), direction[0], mul(frames.row(kSine + 1), direction[1])), a);
  const V first = between(minimum(minimum(a, b), c), zero, segment->length);
  const V last = between(maximum(maximum(a, b), c), zero, segment->length);
  feet.middle = mul(add(first, last), half);
  feet.halfLength = mul(sub(last, first), half);
  return feet;
}

// Squared distances of the triangles from places of the segment, and planes that the triangles lie behind: so far are
// the places in front of them, and so much more, for each step along the segment, are others. Any normal does that is
// not longer than 1; that of the offset from the nearest point is the best.
struct InFront {
  V squared, height, slope;
};

static inline InFront inFrontAt(const Lanes& frames, const Feet& feet, V at) {
  const V zero = set(0.0f);
  V p[3], n[3];
  for (int i = 0; i < 3; ++i) p[i] = mad(feet.direction[i], at, feet.start[i]);
  InFront front;
  front.squared = frameDistances(frames, p[0], p[1], p[2], n);
  n[2] = p[2];
  const V inverse = mul(set(0.9995f), inverseRoot(maximum(front.squared, set(1e-12f))));
  const V toB = mul(n[0], frames.row(kLength));
  const V toC = mul(frames.row(kLength + 2), mad(n[0], frames.row(kCosine + 1), mul(n[1], frames.row(kSine + 1))));
  const V corners = maximum(maximum(toB, toC), zero);
  front.height = mul(sub(mad(n[0], p[0], mad(n[1], p[1], mul(n[2], p[2]))), corners), inverse);
  front.slope = mul(mad(n[0], feet.direction[0], mad(n[1], feet.direction[1], mul(n[2], feet.direction[2]))), inverse);
  return front;
}

static inline V boundOf(const InFront& front, V halfLength) {
  return sub(front.height, mul(halfLength, maximum(front.slope, sub(set(0.0f), front.slope))));
}

// From where the line meets the plane, going d along it brings it nearer to the triangle by d cos of the angle between
// them and away from the plane by d sin: it comes no nearer than the distance in the plane times that sine.
static inline V lineBound(const Lanes& frames, const Feet& feet, float error) {
  const V zero = set(0.0f), sine = maximum(feet.direction[2], sub(zero, feet.direction[2])), flat = set(1e-6f);
  const V at = divide(sub(zero, feet.start[2]), selectGreater(sine, flat, feet.direction[2], flat));
  const V inPlane = frameDistances(frames, mad(feet.direction[0], at, feet.start[0]),
                                   mad(feet.direction[1], at, feet.start[1]), zero);
  return sub(mul(root(inPlane), mul(sine, set(0.99999f))), set(2.0f * error));
}

// With a second plane, at the end of the feet to which the first one comes down: the bound lies where the two meet, or
// in the middle.
static inline V betterBound(const Lanes& frames, const Feet& feet, const InFront& first, float error) {
  const V zero = set(0.0f), w = feet.halfLength;
  const V end = selectGreater(first.slope, zero, sub(feet.middle, w), add(feet.middle, w));
  const InFront second = inFrontAt(frames, feet, end);
  const V inwards = selectGreater(first.slope, zero, second.slope, sub(zero, second.slope));
  const V down = maximum(sub(zero, inwards), zero);  // from the end to the middle
  const V up = maximum(first.slope, sub(zero, first.slope));
  const V met = divide(add(sub(second.height, first.height), mul(up, w)), maximum(add(up, down), set(1e-6f)));
  const V low = sub(second.height, mul(down, between(met, zero, w)));
  return sub(minimum(low, first.height), set(error));
}

// Depth first through what lies within `limit`, the square of a float distance, which atLeaf() may lower.
template <typename AtLeaf>
static inline void searchSegment(const Mesh& mesh, const LocalSegment& segment, const float& limit,
                                 const AtLeaf& atLeaf) {
  Stack stack;
  int32_t current = mesh.root;
  for (;;) {
    if (current < 0) {
      atLeaf(~current);
    } else {
      const Node* node = mesh.nodes + current;
      const V near = segmentBounds(node, &segment);
      const unsigned mask = node->lanes & lessOrEqualMask(near, set(limit));
      if (mask != 0) {
        current = goDown(&mesh, near, node->child, mask, &stack);
        continue;
      }
    }
    do {
      if (stack.top == 0) return;
      --stack.top;
    } while (!(stack.bound[stack.top] <= limit));
    current = stack.child[stack.top];
  }
}

static void visitSegment(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visitor,
                         void* context) {
  LocalSegment segment;
  if (toLocal(mesh, from, to, &segment) == 0) {
    visit(mesh, from, to, reach, visitor, context);
    return;
  }
  float limit = limitOf(reach * mesh.scale, segment.slack);
  searchSegment(mesh, segment, limit, [&](int32_t leaf) {
    const Lanes frames = lanesOf(mesh.leaves + leaf);
    const Feet feet = feetOn(frames, &segment);
    const V bounds = boundOf(inFrontAt(frames, feet, feet.middle), feet.halfLength);
    unsigned mask = lessOrEqualMask(bounds, set(__builtin_sqrtf(limit) * 1.000001f));
    for (; mask != 0; mask &= mask - 1) {
      const int32_t slot = leaf * kWidth + __builtin_ctz(mask);
      if (mesh.triangles[slot].index >= 0) reach = visitor(context, slot, reach);
    }
    limit = limitOf(reach * mesh.scale, segment.slack);
  });
}

// Triangles are collected and looked at in fours.
struct AxisSearch {
  const Mesh* mesh;
  Axis axis;
  SegmentAnswer* answer;
  int waiting;
  int32_t slot[4];
  double beyond;  // squared, of the nearest one that was looked at
};

static inline void keepNearer(AxisSearch* s, const Triangle* triangle, const SegmentCandidate& c) {
  if (c.squared < s->beyond) s->beyond = c.squared;
  SegmentAnswer* answer = s->answer;
  if (!(c.squared < answer->squared) &&
      !(c.squared == answer->squared && (answer->slot < 0 || triangle->index < s->mesh->triangles[answer->slot].index)))
    return;
  answer->squared = c.squared;
  answer->parameter = c.parameter;
  for (int k = 0; k < 3; ++k) answer->point[k] = c.point[k];
  answer->feature = c.feature;
  answer->slot = static_cast<int32_t>(triangle - s->mesh->triangles);
}

static inline void tryWaiting(AxisSearch* s) {
  const Triangle* t[4];
  int thin = 0;
  for (int i = 0; i < 4; ++i) {
    t[i] = s->mesh->triangles + s->slot[i < s->waiting ? i : 0];
    thin |= static_cast<int>(isThin(t[i]));
  }
  SegmentCandidate c;
  if (thin == 0 && s->waiting > 1) {
    const int lane = closestToAxisOfFour(t, &s->axis, &c);
    keepNearer(s, t[lane], c);
  } else {
    for (int i = 0; i < s->waiting; ++i) {
      closestToAxis(t[i], &s->axis, &c);
      keepNearer(s, t[i], c);
    }
  }
  s->waiting = 0;
}

static inline double collectForAxis(void* context, int32_t slot, double reach) {
  AxisSearch* s = static_cast<AxisSearch*>(context);
  const Triangle* all = s->mesh->triangles;
  const int32_t best = s->answer->slot;
  if (best >= 0 && s->answer->squared == 0.0 && all[slot].index > all[best].index) return reach;  // at best as near
  s->slot[s->waiting++] = slot;
  if (s->waiting < 4) return reach;
  tryWaiting(s);
  return __builtin_sqrt(s->answer->squared);
}

// The triangles that may lie within reach are looked at exactly; of the others the bounds are enough.
static inline void searchAxis(AxisSearch* s, const LocalSegment& segment, double reach, double far, int32_t hint) {
  const Mesh& mesh = *s->mesh;
  const float error = 2.0f * static_cast<float>(segment.slack);
  float limit = limitOf((reach > far ? reach : far) * mesh.scale, segment.slack);
  float exactly = __builtin_sqrtf(limitOf(reach * mesh.scale, segment.slack)) * 1.000001f;
  float clear = 3.4e38f;
  int32_t done = -1;
  const auto atLeaf = [&](int32_t leaf) {
    if (leaf == done) return;
    const Lanes frames = lanesOf(mesh.leaves + leaf);
    const Feet feet = feetOn(frames, &segment);
    const InFront front = inFrontAt(frames, feet, feet.middle);
    const float least = (__builtin_sqrtf(smallest(front.squared)) + error) * 1.000001f;
    if (least < exactly) exactly = least;
    const float enough = exactly + kEnough * (least - exactly);
    if (enough * enough < limit) limit = enough * enough;
    V bounds = boundOf(front, feet.halfLength);
    unsigned mask = lessOrEqualMask(bounds, set(exactly));
    if (__builtin_popcount(mask) > kFewOfLeaf) {
      bounds = maximum(bounds, lineBound(frames, feet, error));
      mask = lessOrEqualMask(bounds, set(exactly));
    }
    if (__builtin_popcount(mask) > kManyOfLeaf) {
      bounds = maximum(bounds, betterBound(frames, feet, front, error));
      mask = lessOrEqualMask(bounds, set(exactly));
    }
    const float beyond = smallest(selectGreater(bounds, set(exactly), bounds, set(3.4e38f)));
    if (beyond < clear) clear = beyond;
    if (mask == 0) return;
    for (unsigned rest = mask; rest != 0; rest &= rest - 1)
      fetch(mesh.triangles + leaf * kWidth + __builtin_ctz(rest), 2);
    float bound[kWidth];
    store(bound, bounds);
    int lane = __builtin_ctz(lessOrEqualMask(bounds, set(smallest(bounds))));  // the nearest one first
    for (; mask != 0; lane = __builtin_ctz(mask | 0x10000u)) {
      mask &= ~(1u << lane);
      const int32_t slot = leaf * kWidth + lane;
      if (!(bound[lane] <= exactly) || mesh.triangles[slot].index < 0) continue;
      const double now = collectForAxis(s, slot, reach);
      if (!(now < reach)) continue;
      reach = now;
      const float closer = limitOf(reach * mesh.scale, segment.slack);
      if (closer < limit) limit = closer;
      const float most = __builtin_sqrtf(closer) * 1.000001f;
      if (most < exactly) exactly = most;
    }
  };
  if (hint >= 0) {
    atLeaf(hint / kWidth);
    done = hint / kWidth;
  }
  searchSegment(mesh, segment, limit, atLeaf);
  if (s->waiting > 0) tryWaiting(s);
  if (s->answer->slot >= 0) return;
  const float most = __builtin_sqrtf(limit);
  const double keeps =
      (static_cast<double>(clear < most ? clear : most) * (1.0 - 1e-6) - 2.0 * segment.slack) / mesh.scale;
  const double looked = __builtin_sqrt(s->beyond) * (1.0 - 1e-12);
  const double free = keeps < looked ? keeps : looked;
  if (free > reach) s->answer->squared = free * free;
}

static void closestToSegment(const Mesh& mesh, const double from[3], const double to[3], double reach, double far,
                             int32_t hint, SegmentAnswer* answer) {
  AxisSearch s = {&mesh, axisBetween(from, to), answer, 0, {}, kHuge};
  answer->squared = reach * reach < kHuge ? reach * reach : kHuge;
  answer->slot = -1;
  LocalSegment segment;
  if (toLocal(mesh, from, to, &segment) != 0) {
    searchAxis(&s, segment, reach, far, hint);
    return;
  }
  if (hint >= 0) s.slot[s.waiting++] = hint;
  visit(mesh, from, to, reach, &collectForAxis, &s);
  if (s.waiting > 0) tryWaiting(&s);
}

// Children within the limit whose cones allow a local minimum: the line from one of their points to the point in
// question is nowhere steeper to the third axis than the sides of the box allow.
static inline unsigned childrenWithMinima(const Node* node, V x, V y, V z, V limit, V slack) {
  const V zero = set(0.0f), one = set(1.0f);
  const Lanes lanes = lanesOf(node);
  V extent[3], squared = zero;
  for (int i = 0; i < 3; ++i) {
    extent[i] = alongAxis(lanes, i, x, y, z);
    const V d = maximum(sub(extent[i], lanes.row(12 + i)), zero);
    squared = mad(d, d, squared);
  }
  const V u = maximum(sub(sub(extent[0], lanes.row(12)), slack), zero);
  const V v = maximum(sub(sub(extent[1], lanes.row(13)), slack), zero);
  const V h = add(add(extent[2], lanes.row(14)), slack);
  const V cone = load(node->cone);
  return node->lanes & lessOrEqualMask(squared, limit) &
         lessOrEqualMask(mul(mad(u, u, mul(v, v)), cone), mul(mul(h, h), sub(one, cone)));
}

static void visitMinima(const Mesh& mesh, const double point[3], double reach, Visit visitor, void* context) {
  Search s;
  startSearch(&s, &mesh, point, reach * reach);
  if (isFar(s.local)) {
    visit(mesh, point, point, reach, visitor, context);
    return;
  }
  const V x = set(s.x), y = set(s.y), z = set(s.z), limit = set(s.limit), slack = set(2.0f * s.slackUp);
  int32_t stack[kStackSize + kWidth], slots[kMostCandidates + kWidth];
  int top = 0, count = 0;
  const auto visitAll = [&] {
    for (int i = 0; i < count; ++i)
      if (mesh.triangles[slots[i]].index >= 0) visitor(context, slots[i], reach);
    count = 0;
  };
  stack[top++] = mesh.root;
  while (top > 0) {
    const int32_t current = stack[--top];
    if (current < 0) {
      const Leaf* leaf = mesh.leaves + ~current;
      V height;
      const V d = triangleDistances(lanesOf(leaf), x, y, z, &height);
      const V under = sub(set(0.0f), height);
      const V high = add(maximum(height, under), slack);  // and what both may err by
      const V front = load(leaf->front), back = load(leaf->back);
      const V either = selectGreater(under, slack, back, minimum(front, back));
      const V least = mul(selectGreater(height, slack, front, either), d);
      const unsigned near = lessOrEqualMask(d, limit) & lessOrEqualMask(least, mul(high, high));
      compressNumbers(~current * kWidth, choose(near), slots + count);
      for (int i = __builtin_popcount(near); i > 0; --i) fetch(mesh.triangles + slots[count++], 2);
      if (count > kMostCandidates - kWidth) visitAll();
      continue;
    }
    const Node* node = mesh.nodes + current;
    const unsigned mask = childrenWithMinima(node, x, y, z, limit, slack);
    const int before = top;
    compress(node->child, choose(mask), stack + top);
    top += __builtin_popcount(mask);
    for (int i = before; i < top; ++i) fetchChild(&mesh, stack[i], kLeafLines);
  }
  visitAll();
}
