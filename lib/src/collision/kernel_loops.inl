// The search loops, written on a vector `V` of 16 floats that the including file defines together with
// load, store, set, add, sub, mul, mad, root, maximum, minimum, smallest, lessOrEqualMask, selectGreater, and compress
// (the lanes that choose() made of a mask to consecutive floats; up to 16 are written). Everything has internal
// linkage.

#include "exact.inl"

// Error of the float distances, with room to spare: at most 20 roundings of numbers not larger than |q|_1 + 2 extent
// enter, 2^-24 each, and a triangle that is represented by its edges alone is lower than 2^-20.
static const double kBoundError = 0x1p-19;
// Beyond this many mesh sizes float boxes no longer tell triangles apart; doubles take over.
static const double kFar = 64.0;
static const double kHuge = 1e300;
// How far ahead of the tool the ball of a list lies, in parts of its radius.
static const double kLead = 0.8;

enum { kMostCandidates = 64 };

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

static inline double absolute(double v) { return v < 0.0 ? -v : v; }

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
static inline void tryTriangle(Search* s, int32_t slot) {
  const Triangle* t = s->mesh->triangles + slot;
  if (t->index < 0) return;
  Candidate c;
  closestOnTriangle(t, s->point, &c);
  if (c.squared < s->squared) {
    s->squared = c.squared;
    s->slot = slot;
    s->index = t->index;
    s->best = c;
  } else if (c.squared == s->squared && t->index < s->index) {
    s->slot = slot;
    s->index = t->index;
    s->best = c;
  }
}

// Squared distances of 16 boxes from a box [x0, x1] (a point where both are the same), as floats from below but for
// the slack that the limit carries.
static inline V boxBounds(const float* low, const float* high, int stride, V x, V y, V z) {
  const V zero = set(0.0f);
  const V dx = maximum(maximum(sub(load(low), x), sub(x, load(high))), zero);
  const V dy = maximum(maximum(sub(load(low + stride), y), sub(y, load(high + stride))), zero);
  const V dz = maximum(maximum(sub(load(low + 2 * stride), z), sub(z, load(high + 2 * stride))), zero);
  return mad(dx, dx, mad(dy, dy, mul(dz, dz)));
}

// 16 lanes of rows: of a leaf, of the boxes of a node, of a list.
struct Lanes {
  const float* first;
  int stride;
  V row(int i) const { return load(first + i * stride); }
};

static inline Lanes lanesOf(const Leaf* leaf) { return {leaf->row[0], kWidth}; }
static inline Lanes lanesOf(const LeafBoxes* boxes) { return {boxes->row[0], kWidth}; }
static inline Lanes lanesOf(const ProximityCache::Triangles* list, int lane) {
  return {list->row[0] + lane, ProximityCache::kTriangles + ProximityCache::kSpare};
}
static inline Lanes lanesOf(const ProximityCache::Leaves* list, int lane) {
  return {list->row[0] + lane, ProximityCache::kLeaves + ProximityCache::kSpare};
}

// Squared distances of 16 triangles from points in their frames: to the plane where the point lies over the triangle,
// else to the nearest edge (along the edge beyond its ends, across it in the plane, and the height over the plane).
// With directions in the frames, also how far the points lie ahead of the nearest points of the triangles.
static inline V frameDistances(const Lanes& frames, V u, V v, V h, const V* way = nullptr, V* ahead = nullptr) {
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
  if (way != nullptr) {
    const V ahead0 = mad(end0, way[0], mul(v, way[1]));
    const V ahead1 = mad(end1, mad(c1, way[0], mul(s1, way[1])), mul(across1, sub(mul(s1, way[0]), mul(c1, way[1]))));
    const V ahead2 = mad(end2, mad(c2, way[0], mul(s2, way[1])), mul(across2, sub(mul(c2, way[1]), mul(s2, way[0]))));
    const V of01 = selectGreater(edge0, edge1, ahead1, ahead0);
    const V ofEdges = selectGreater(minimum(edge0, edge1), edge2, ahead2, of01);
    *ahead = mad(h, way[2], selectGreater(out, inside, ofEdges, zero));
  }
  return mad(h, h, selectGreater(out, inside, edges, zero));
}

static inline void toFrames(const Lanes& frames, V x, V y, V z, V* f) {
  for (int i = 0; i < 3; ++i)
    f[i] = mad(frames.row(3 * i), x,
               mad(frames.row(3 * i + 1), y, mad(frames.row(3 * i + 2), z, frames.row(kOffset + i))));
}

static inline void turnToFrames(const Lanes& frames, const V* way, V* f) {
  for (int i = 0; i < 3; ++i)
    f[i] = mad(frames.row(3 * i), way[0], mad(frames.row(3 * i + 1), way[1], mul(frames.row(3 * i + 2), way[2])));
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
  for (int i = 0; i < s->candidates; ++i)
    if (s->candidateBound[i] <= s->limit) tryTriangle(s, s->candidate[i]);
  s->candidates = 0;
}

static inline void fetch(const void* address, int lines) {
  for (int i = 0; i < lines; ++i) __builtin_prefetch(static_cast<const char*>(address) + 64 * i);
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

// Squared distances of oriented boxes from a point; with a direction, also how far the point lies ahead of the nearest
// points of the boxes.
static inline V orientedBounds(const Lanes& boxes, V x, V y, V z, const V* way = nullptr, V* ahead = nullptr) {
  const V zero = set(0.0f);
  V squared = zero;
  if (way != nullptr) *ahead = zero;
  for (int i = 0; i < 3; ++i) {
    const V ax = boxes.row(3 * i), ay = boxes.row(3 * i + 1), az = boxes.row(3 * i + 2), half = boxes.row(12 + i);
    const V a = mad(ax, x, mad(ay, y, mad(az, z, boxes.row(9 + i))));
    if (way == nullptr) {
      const V d = maximum(sub(maximum(a, sub(zero, a)), half), zero);
      squared = mad(d, d, squared);
    } else {
      const V d = sub(a, maximum(minimum(a, half), sub(zero, half)));
      squared = mad(d, d, squared);
      *ahead = mad(d, mad(ax, way[0], mad(ay, way[1], mul(az, way[2]))), *ahead);
    }
  }
  return squared;
}

// Every box holds a triangle, which is no farther than the farthest corner of the box.
static inline void tightenToBoxes(Search* s, const Node* node, V x, V y, V z) {
  const V dx = maximum(sub(x, load(node->low[0])), sub(load(node->high[0]), x));
  const V dy = maximum(sub(y, load(node->low[1])), sub(load(node->high[1]), y));
  const V dz = maximum(sub(z, load(node->low[2])), sub(load(node->high[2]), z));
  const float d = __builtin_sqrtf(smallest(mad(dx, dx, mad(dy, dy, mul(dz, dz))))) + s->slackUp;
  lowerLimit(s, d * d * 1.000002f);
}

struct Entry {
  float bound;
  int32_t child;
};

// Depth first, the nearest child first.
static inline void searchTree(Search* s, int cold) {
  Entry stack[kStackSize];
  int top = 0;
  int32_t current = s->mesh->root;
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  for (;;) {
    if (current < 0) {
      searchLeaf(s, ~current);
    } else {
      const Node* node = s->mesh->nodes + (current & kNumber);
      V b = boxBounds(node->low[0], node->high[0], kWidth, x, y, z);
      if (cold != 0 && s->least > 3e38f) tightenToBoxes(s, node, x, y, z);
      unsigned mask = lessOrEqualMask(b, set(s->limit));
      if (mask != 0 && (current & kHasLeaves) != 0) {
        b = maximum(b, orientedBounds(lanesOf(s->mesh->boxes + (current & kNumber)), x, y, z));
        mask &= lessOrEqualMask(b, set(s->limit));
      }
      if (mask != 0) {
        if ((mask & (mask - 1)) == 0) {
          current = node->child[__builtin_ctz(mask)];
          continue;
        }
        float bounds[kWidth];
        store(bounds, b);
        const int bottom = top;
        for (; mask != 0; mask &= mask - 1) {
          const int lane = __builtin_ctz(mask);
          const float bound = bounds[lane];
          int place = top++;
          for (; place > bottom && stack[place - 1].bound < bound; --place) stack[place] = stack[place - 1];
          const int32_t child = node->child[lane];
          stack[place].bound = bound;
          stack[place].child = child;
        }
        for (int i = top - 2; i < top; ++i)
          if (stack[i].child < 0) {
            fetch(s->mesh->leaves + ~stack[i].child, 20);
          } else {
            fetch(s->mesh->nodes + (stack[i].child & kNumber), 7);
          }
      }
    }
    do {
      if (top == 0) return;
      --top;
    } while (!(stack[top].bound <= s->limit));
    current = stack[top].child;
  }
}

// Far away: the same search with distances to the boxes in double.
static inline double boxDistance(const Node* node, int lane, const double* q) {
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double below = static_cast<double>(node->low[k][lane]) - q[k];
    const double above = q[k] - static_cast<double>(node->high[k][lane]);
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
    const Node* node = s->mesh->nodes + (entry.child & kNumber);
    const int bottom = top;
    for (int lane = 0; lane < kWidth; ++lane) {
      if (node->low[0][lane] > node->high[0][lane]) continue;
      const double squared = boxDistance(node, lane, s->local);
      if (squared * shrink > s->squared * unit) continue;
      int place = top++;
      for (; place > bottom && stack[place - 1].squared < squared; --place) stack[place] = stack[place - 1];
      stack[place].squared = squared;
      stack[place].child = node->child[lane];
    }
  }
}

static inline unsigned firstLanes(int count) { return count >= kWidth ? 0xffffu : (1u << count) - 1u; }

static inline void addToRegion(ProximityCache::Region* region, int32_t node, const float* low, const float* high,
                               int stride) {
  const int i = region->count++;
  region->node[i] = node & kNumber;
  for (int k = 0; k < 3; ++k) {
    region->low[k][i] = low[k * stride];
    region->high[k][i] = high[k * stride];
  }
}

static inline void openRegion(const Search* s, double reach, Cache* cache) {
  const float low[3] = {-16.0f, -16.0f, -16.0f}, high[3] = {16.0f, 16.0f, 16.0f};
  ProximityCache::Region* region = &cache->region[1 - cache->active];
  region->count = 0;
  for (int k = 0; k < 3; ++k) region->origin[k] = s->local[k];
  region->reach = reach;
  if ((s->mesh->root & kHasLeaves) != 0) addToRegion(region, s->mesh->root, low, high, 1);
  cache->open = 0;
  cache->stack[cache->open++] = s->mesh->root;
}

// Goes on with the region, a few nodes at a time. One that does not fit is given up; span and margin adapt.
static inline void extendRegion(const Search* s, Cache* cache) {
  const int kNodesPerQuery = 3;
  ProximityCache::Region* region = &cache->region[1 - cache->active];
  const V x = set(static_cast<float>(region->origin[0])), y = set(static_cast<float>(region->origin[1])),
          z = set(static_cast<float>(region->origin[2]));
  const V limit = set(limitOf(region->reach, s->slack));
  for (int visited = 0; cache->open > 0 && visited < kNodesPerQuery; ++visited) {
    const Node* node = s->mesh->nodes + (cache->stack[--cache->open] & kNumber);
    unsigned mask = lessOrEqualMask(boxBounds(node->low[0], node->high[0], kWidth, x, y, z), limit);
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      const int32_t child = node->child[lane];
      if (child < 0) continue;
      if (region->count == ProximityCache::kRegion || cache->open == ProximityCache::kStack) {
        region->reach = -1.0;
        cache->open = -1;
        cache->span *= 0.7;
        cache->leaves.margin *= 0.8;
        return;
      }
      if ((child & kHasLeaves) != 0) addToRegion(region, child, node->low[0] + lane, node->high[0] + lane, kWidth);
      if ((child & kHasNodes) != 0) {
        cache->stack[cache->open++] = child;
        fetch(s->mesh->nodes + (child & kNumber), 7);
      }
    }
  }
  if (cache->open == 0) {
    cache->open = -1;
    cache->active = 1 - cache->active;
    if (region->count <= ProximityCache::kRegion / 2) cache->span *= 1.25;
  }
}

static inline int holds(const ProximityCache::List* list, const double* q) {
  return list->radius >= 0.0 && squaredDistance(q, list->origin) <= list->radius * list->radius;
}

// All triangles of the list at once, then the exact distances of the few that the floats cannot tell apart.
static inline void searchTriangles(Search* s, ProximityCache::Triangles* list) {
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  V squared[ProximityCache::kTriangles / kWidth];
  V least = set(3.4e38f);
  int batches = 0;
  for (; batches * kWidth < list->count; ++batches) {
    squared[batches] = triangleDistances(lanesOf(list, batches * kWidth), x, y, z);
    least = minimum(least, squared[batches]);
  }
  tightenToFloat(s, smallest(least));
  const V limit = set(s->limit);
  for (int i = 0; i < batches; ++i)
    for (unsigned mask = lessOrEqualMask(squared[i], limit); mask != 0; mask &= mask - 1)
      tryTriangle(s, list->slot[i * kWidth + __builtin_ctz(mask)]);
  ++list->uses;
}

// The leaves within the limit, without a branch on what they hold; then as above.
static inline void searchLeaves(Search* s, const ProximityCache::Leaves* list) {
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  int32_t looked[ProximityCache::kLeaves];
  float squared[ProximityCache::kLeaves][kWidth];
  V least = set(3.4e38f);
  int count = 0;
  for (int first = 0; first < list->count; first += kWidth) {
    const V b = orientedBounds(lanesOf(list, first), x, y, z);
    unsigned mask = lessOrEqualMask(b, set(s->limit)) & firstLanes(list->count - first);
    for (; mask != 0; mask &= mask - 1) {
      const int32_t leaf = list->leaf[first + __builtin_ctz(mask)];
      const V d = triangleDistances(lanesOf(s->mesh->leaves + leaf), x, y, z);
      least = minimum(least, d);
      looked[count] = leaf;
      store(squared[count++], d);
    }
  }
  tightenToFloat(s, smallest(least));
  const V limit = set(s->limit);
  for (int i = 0; i < count; ++i)
    for (unsigned mask = lessOrEqualMask(load(squared[i]), limit); mask != 0; mask &= mask - 1)
      tryTriangle(s, looked[i] * kWidth + __builtin_ctz(mask));
}

// Which convex bodies can be nearest within r of the origin o. Let f be the distance of one from o and n the direction
// from its nearest point to o; x a point of the mesh, D its distance from o and m its direction. A distance from a
// convex body is convex, so at o + e it is at least f + n.e; that of x is at most D + m.e + r^2 / (2 D). Hence only
// bodies with f - D <= r |m - n| + r^2 / (2 D) matter, besides the plain f - D <= 2 r.
struct Reach {
  V most;         // squared plain reach
  V m[3];         // direction
  V start;        // D + r^2 / (2 D) and what the floats may err by
  V twiceSquare;  // 2 r^2
  V close;        // D / 2: below, the direction n is not to be trusted
  int isPlain;    // near the surface the plain reach is as good
};

static inline Reach reachOf(const double* origin, const double* x, double r, double slack) {
  double m[3];
  subtract(origin, x, m);
  const double D = __builtin_sqrt(dot(m, m));
  Reach reach;
  reach.most = set(limitOf(D + 2.0 * r, slack));
  reach.isPlain = !(D > 2.0 * r && D > 64.0 * slack);
  if (reach.isPlain) return reach;
  // Distances known to e tell the nearest point of a convex body to sqrt(2 e f), and n to sqrt(2 e / f).
  const double turn = 2.0 * __builtin_sqrt(4.0 * slack / D) + 2e-3;
  for (int k = 0; k < 3; ++k) reach.m[k] = set(static_cast<float>(m[k] / D));
  reach.start = set(upward(D + r * r / (2.0 * D) + r * turn + 2.0 * slack));
  reach.twiceSquare = set(upward(2.0001 * r * r));
  reach.close = set(static_cast<float>(0.5 * D));
  return reach;
}

static inline unsigned within(const Reach& reach, V squared, V ahead) {
  const V f = root(squared), more = sub(f, reach.start);
  // |m - n|^2 = 2 - 2 m.n
  return lessOrEqualMask(f, reach.close) | lessOrEqualMask(more, set(0.0f)) |
         lessOrEqualMask(mul(mul(more, more), f), mul(reach.twiceSquare, sub(f, ahead)));
}

static inline unsigned boxesWithin(const Reach& reach, const Lanes& boxes, V x, V y, V z) {
  if (reach.isPlain) return lessOrEqualMask(orientedBounds(boxes, x, y, z), reach.most);
  V ahead;
  const V squared = orientedBounds(boxes, x, y, z, reach.m, &ahead);
  return lessOrEqualMask(squared, reach.most) & within(reach, squared, ahead);
}

static inline unsigned trianglesWithin(const Reach& reach, const Lanes& frames, V x, V y, V z) {
  V f[3], way[3], ahead;
  toFrames(frames, x, y, z, f);
  if (reach.isPlain) return lessOrEqualMask(frameDistances(frames, f[0], f[1], f[2]), reach.most);
  turnToFrames(frames, reach.m, way);
  const V squared = frameDistances(frames, f[0], f[1], f[2], way, &ahead);
  return lessOrEqualMask(squared, reach.most) & within(reach, squared, ahead);
}

// Begins a list for a ball of radius r that lies mostly ahead of the tool.
static inline Reach beginList(const Search* s, const Cache* cache, double r, ProximityCache::List* list) {
  double way[3];
  subtract(s->local, cache->query, way);
  const double step = __builtin_sqrt(dot(way, way));
  const double lead = step > 1e-3 * r ? kLead * r / step : 0.0;
  for (int k = 0; k < 3; ++k) list->origin[k] = s->local[k] + lead * way[k];
  list->count = 0;
  list->radius = -1.0;
  return reachOf(list->origin, cache->surface, r, slackOf(s->mesh, list->origin));
}

// Answers 0 if there are too many leaves; the margin adapts.
static inline int makeLeaves(const Search* s, Cache* cache) {
  ProximityCache::Leaves* list = &cache->leaves;
  const ProximityCache::Region* region = &cache->region[cache->active];
  const Reach reach = beginList(s, cache, list->margin, list);
  const V x = set(static_cast<float>(list->origin[0])), y = set(static_cast<float>(list->origin[1])),
          z = set(static_cast<float>(list->origin[2]));
  for (int first = 0; first < region->count; first += kWidth) {
    const V bounds = boxBounds(region->low[0] + first, region->high[0] + first, ProximityCache::kRegion, x, y, z);
    const unsigned nodes = lessOrEqualMask(bounds, reach.most) & firstLanes(region->count - first);
    for (unsigned i = nodes & (nodes - 1); i != 0; i &= i - 1)
      fetch(s->mesh->boxes + region->node[first + __builtin_ctz(i)], 16);
    for (unsigned i = nodes; i != 0; i &= i - 1) {
      const int32_t number = region->node[first + __builtin_ctz(i)];
      const Node* node = s->mesh->nodes + number;
      const LeafBoxes* boxes = s->mesh->boxes + number;
      unsigned near = boxesWithin(reach, lanesOf(boxes), x, y, z) & boxes->lanes;
      if (near == 0) continue;
      if (list->count + __builtin_popcount(near) > ProximityCache::kLeaves) {
        list->margin *= 0.6;
        return 0;
      }
      const Chosen lanes = choose(near);
      for (int row = 0; row < ProximityCache::kBoxRows; ++row)
        compress(load(boxes->row[row]), lanes, list->row[row] + list->count);
      for (; near != 0; near &= near - 1) list->leaf[list->count++] = ~node->child[__builtin_ctz(near)];
    }
  }
  list->radius = list->margin * (1.0 - 1e-6);
  if (list->count <= kWidth && region->count <= ProximityCache::kRegion / 2) list->margin *= 1.25;
  if (list->count > kWidth + kWidth / 2) list->margin *= 0.85;
  return 1;
}

// The same from the leaves, for a ball within theirs. Answers 0 also where the ball would not hold for two queries. The
// margin grows only where it had room: it cannot run away.
static inline int makeTriangles(const Search* s, Cache* cache) {
  ProximityCache::Triangles* list = &cache->triangles;
  const ProximityCache::Leaves* leaves = &cache->leaves;
  const double room = leaves->radius - __builtin_sqrt(squaredDistance(s->local, leaves->origin));
  const double r = list->margin < room / (1.0 + kLead) ? list->margin : room / (1.0 + kLead);
  const double step = squaredDistance(s->local, cache->query);
  if (step > r * r) {
    if (r == list->margin) list->margin *= 1.05;
    return 0;
  }
  const int uses = list->uses;
  list->uses = 0;
  const Reach reach = beginList(s, cache, r, list);
  const V x = set(static_cast<float>(list->origin[0])), y = set(static_cast<float>(list->origin[1])),
          z = set(static_cast<float>(list->origin[2]));
  for (int first = 0; first < leaves->count; first += kWidth) {
    unsigned mask = boxesWithin(reach, lanesOf(leaves, first), x, y, z) & firstLanes(leaves->count - first);
    for (; mask != 0; mask &= mask - 1) {
      const int32_t number = leaves->leaf[first + __builtin_ctz(mask)];
      const Leaf* leaf = s->mesh->leaves + number;
      unsigned near = trianglesWithin(reach, lanesOf(leaf), x, y, z);
      if (near == 0) continue;
      if (list->count + __builtin_popcount(near) > ProximityCache::kTriangles) {
        list->margin = 0.6 * r;
        return 0;
      }
      const Chosen lanes = choose(near);
      for (int row = 0; row < ProximityCache::kFrameRows; ++row)
        compress(load(leaf->row[row]), lanes, list->row[row] + list->count);
      for (; near != 0; near &= near - 1) list->slot[list->count++] = number * kWidth + __builtin_ctz(near);
    }
  }
  for (int row = 0; row < ProximityCache::kFrameRows; ++row) store(list->row[row] + list->count, set(unusedRow(row)));
  list->radius = r * (1.0 - 1e-6);
  // Two batches that hold for some ten queries cost least in the mean.
  if (r == list->margin && (list->count <= kWidth || (uses < 6 && list->count <= 2 * kWidth))) list->margin *= 1.25;
  if (list->count > 2 * kWidth + kWidth / 2 || (uses > 12 && list->count > kWidth)) list->margin = 0.85 * r;
  return 1;
}

// The previous answer is on the mesh, so its distance bounds the new one. Close to it, a list of triangles answers; it
// is made from a list of leaves, that one from a region, and the region ahead of time, a little every query: no query
// makes more than one of them. Where none is at hand the tree is searched.
static inline void searchWithCache(Search* s, Cache* cache) {
  const float surface = __builtin_sqrtf(static_cast<float>(squaredDistance(s->local, cache->surface))) * 1.000001f;
  lowerLimit(s, (surface + s->slackUp) * (surface + s->slackUp) * 1.000002f);
  if (holds(&cache->triangles, s->local)) {
    searchTriangles(s, &cache->triangles);
    if (cache->open >= 0) extendRegion(s, cache);
    return;
  }
  if (holds(&cache->leaves, s->local)) {
    if (makeTriangles(s, cache) != 0) {
      searchTriangles(s, &cache->triangles);
    } else {
      searchLeaves(s, &cache->leaves);
    }
    return;
  }
  const double margin = cache->leaves.margin;
  const double step = squaredDistance(s->local, cache->query);
  if (step * 2.0 > margin * margin) {  // a list would not hold for two queries
    if (step <= 1.0 / 4096.0) cache->leaves.margin *= 1.1;
    searchTree(s, 0);
    return;
  }
  // The origin lies kLead margins ahead; a list reaches two margins farther than the mesh is from there.
  const double need = static_cast<double>(surface) + 2.0 * (1.0 + kLead) * margin;
  const ProximityCache::Region* region = &cache->region[cache->active];
  const double room = region->reach - need - __builtin_sqrt(squaredDistance(s->local, region->origin));
  if (room >= 0.0 && makeLeaves(s, cache) != 0) {
    searchLeaves(s, &cache->leaves);
  } else {
    searchTree(s, 0);
  }
  if (cache->open >= 0) {
    const ProximityCache::Region* next = &cache->region[1 - cache->active];
    if (next->reach - need - __builtin_sqrt(squaredDistance(s->local, next->origin)) < 0.0) cache->open = -1;
  }
  if (cache->open < 0 && room < 0.5 * cache->span) openRegion(s, need + cache->span, cache);
  if (cache->open >= 0 && room < 0.0) extendRegion(s, cache);
}

static void closest(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer) {
  Search s;
  startSearch(&s, &mesh, point, limitSquared);
  const int known = cache != nullptr && cache->revision == mesh.revision;
  if (cache != nullptr && !known) {
    cache->revision = 0;
    cache->triangles.radius = cache->leaves.radius = -1.0;
    cache->region[0].reach = cache->region[1].reach = -1.0;
    cache->active = 0;
    cache->open = -1;
    cache->triangles.margin = 1.0 / 256.0;
    cache->leaves.margin = 1.0 / 64.0;
    cache->span = 1.0 / 16.0;
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
    cache->revision = mesh.revision;
    for (int k = 0; k < 3; ++k) {
      cache->query[k] = s.local[k];
      cache->surface[k] = (s.best.point[k] - mesh.centre[k]) * mesh.scale;
    }
  }
  answer->squared = s.squared;
  answer->slot = s.slot;
  if (s.slot >= 0) {
    for (int k = 0; k < 3; ++k) answer->point[k] = s.best.point[k];
    answer->feature = s.best.feature;
  } else {
    for (int k = 0; k < 3; ++k) answer->point[k] = point[k];
    answer->feature = kFace;
  }
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
      if (reach < 0.0) return;
      continue;
    }
    const Node* node = mesh.nodes + (current & kNumber);
    const V zero = set(0.0f);
    V squared = zero;
    for (int k = 0; k < 3; ++k) {
      const V below = sub(load(node->low[k]), set(static_cast<float>(high[k])));
      const V above = sub(set(static_cast<float>(low[k])), load(node->high[k]));
      const V d = maximum(maximum(below, above), zero);
      squared = mad(d, d, squared);
    }
    unsigned mask = lessOrEqualMask(squared, set(limitOf(reach * mesh.scale, slack)));
    for (; mask != 0; mask &= mask - 1) stack[top++] = node->child[__builtin_ctz(mask)];
  }
}

// A segment in local coordinates: start, unit direction, length.
struct Ray {
  V start[3], way[3], length;
};

static inline V between(V x, V low, V high) { return maximum(minimum(x, high), low); }

// Squared distances of boxes |f| <= half from a segment that is given in their frames. What is nearest to a point of
// the box is the foot of that point, so only the feet of the box count; their bounding box is taken.
static inline V pieceBounds(const V* start, const V* way, const V* half, V length) {
  const V zero = set(0.0f);
  V foot = zero, extent = zero;
  for (int k = 0; k < 3; ++k) {
    foot = mad(start[k], way[k], foot);
    extent = mad(maximum(way[k], sub(zero, way[k])), half[k], extent);
  }
  const V first = between(sub(sub(zero, foot), extent), zero, length);
  const V last = between(sub(extent, foot), zero, length);
  V squared = zero;
  for (int k = 0; k < 3; ++k) {
    const V a = mad(way[k], first, start[k]), b = mad(way[k], last, start[k]);
    const V d = maximum(sub(maximum(minimum(a, b), sub(zero, maximum(a, b))), half[k]), zero);
    squared = mad(d, d, squared);
  }
  return squared;
}

static inline V segmentBounds(const Node* node, const Ray* ray) {
  const V middle = set(0.5f), empty = set(-1e25f);  // its square is infinite
  V start[3], half[3];
  for (int k = 0; k < 3; ++k) {
    const V low = load(node->low[k]), high = load(node->high[k]);
    half[k] = maximum(mul(sub(high, low), middle), empty);
    start[k] = sub(ray->start[k], mul(add(high, low), middle));
  }
  return pieceBounds(start, ray->way, half, ray->length);
}

static inline V segmentBounds(const LeafBoxes* boxes, const Ray* ray) {
  V start[3], way[3], half[3];
  for (int i = 0; i < 3; ++i) {
    const V x = load(boxes->row[3 * i]), y = load(boxes->row[3 * i + 1]), z = load(boxes->row[3 * i + 2]);
    start[i] = mad(x, ray->start[0], mad(y, ray->start[1], mad(z, ray->start[2], load(boxes->row[9 + i]))));
    way[i] = mad(x, ray->way[0], mad(y, ray->way[1], mul(z, ray->way[2])));
    half[i] = load(boxes->row[12 + i]);
  }
  return pieceBounds(start, way, half, ray->length);
}

// Distances of the triangles of a leaf from the middle of their feet on the segment, squared, how far that lies ahead
// of the triangles' nearest points, and half the way between the feet: the segment is nearer by no more than that.
static inline V segmentDistances(const Leaf* leaf, const Ray* ray, V* halfWay, V* ahead) {
  const V zero = set(0.0f), half = set(0.5f);
  const Lanes frames = lanesOf(leaf);
  V start[3], way[3];
  toFrames(frames, ray->start[0], ray->start[1], ray->start[2], start);
  turnToFrames(frames, ray->way, way);
  const V a = sub(zero, mad(start[0], way[0], mad(start[1], way[1], mul(start[2], way[2]))));
  const V b = mad(frames.row(kLength), way[0], a);
  const V c = mad(frames.row(kLength + 2), mad(frames.row(kCosine + 1), way[0], mul(frames.row(kSine + 1), way[1])), a);
  const V first = between(minimum(minimum(a, b), c), zero, ray->length);
  const V last = between(maximum(maximum(a, b), c), zero, ray->length);
  const V at = mul(add(first, last), half);
  *halfWay = mul(sub(last, first), half);
  return frameDistances(frames, mad(way[0], at, start[0]), mad(way[1], at, start[1]), mad(way[2], at, start[2]), way,
                        ahead);
}

// The distance is a convex function along the segment, so it stays above its tangent in the middle of the feet. The
// nearest point, whose distance is known to `error`, is known to sqrt(2 error distance), and so is the slope.
static inline float tangentBound(float squared, float ahead, float halfWay, float error) {
  const float d = __builtin_sqrtf(squared);
  if (!(d > 32.0f * error)) return d - halfWay;
  const float slope = (ahead < 0.0f ? -ahead : ahead) / d + 2.0f * __builtin_sqrtf(error / d);
  return d - halfWay * (slope < 1.0f ? slope : 1.0f);
}

// With a visitor as Loops::visitSegment, without one as Loops::clearance.
static inline double searchSegment(const Mesh& mesh, const double from[3], const double to[3], double reach,
                                   double needed, Visit visitor, void* context) {
  double a[3], b[3], way[3], size = 2.0 * mesh.extent;
  for (int k = 0; k < 3; ++k) {
    a[k] = (from[k] - mesh.centre[k]) * mesh.scale;
    b[k] = (to[k] - mesh.centre[k]) * mesh.scale;
    way[k] = b[k] - a[k];
    size += absolute(a[k]) > absolute(b[k]) ? absolute(a[k]) : absolute(b[k]);
  }
  if (isFar(a) || isFar(b)) {
    if (visitor == nullptr) return 0.0;
    visit(mesh, from, to, reach, visitor, context);
    return 0.0;
  }
  const double slack = kBoundError * size;
  const double length = __builtin_sqrt(dot(way, way));
  Ray ray;
  for (int k = 0; k < 3; ++k) {
    ray.start[k] = set(static_cast<float>(a[k]));
    ray.way[k] = set(length > 0.0 ? static_cast<float>(way[k] / length) : 0.0f);
  }
  ray.length = set(static_cast<float>(length));
  Entry stack[kStackSize];
  int top = 0;
  int32_t current = mesh.root;
  const double least = slack / mesh.scale;
  const float error = 2.0f * static_cast<float>(slack);
  float limit = limitOf(reach * mesh.scale, slack);
  for (;;) {
    if (current < 0) {
      V halfWay, ahead;
      const V d = segmentDistances(mesh.leaves + ~current, &ray, &halfWay, &ahead);
      float root = __builtin_sqrtf(limit) * 1.000001f;
      const V most = add(halfWay, set(root));
      unsigned mask = lessOrEqualMask(d, mul(most, most));
      if (mask != 0) {
        float bound[kWidth], half[kWidth], front[kWidth], nearest = 3.4e38f;
        store(bound, d);
        store(half, halfWay);
        store(front, ahead);
        int first = 0;
        for (unsigned m = mask; m != 0; m &= m - 1) {
          const int lane = __builtin_ctz(m);
          bound[lane] = tangentBound(bound[lane], front[lane], half[lane], error);
          if (bound[lane] < nearest) {
            nearest = bound[lane];
            first = lane;
          }
        }
        if (visitor == nullptr) {
          const double clear = static_cast<double>(nearest) / mesh.scale - least;
          if (clear < reach) reach = clear > 0.0 ? clear : 0.0;
          if (reach < needed && reach > 0.25 * needed) reach = 0.25 * needed;
          limit = limitOf(reach * mesh.scale, slack);
          if (!(reach > 0.0)) return 0.0;
        } else {
          for (int lane = first; mask != 0; lane = __builtin_ctz(mask | 0x10000u)) {
            mask &= ~(1u << lane);
            const int32_t slot = ~current * kWidth + lane;
            if (!(bound[lane] <= root) || mesh.triangles[slot].index < 0) continue;
            const double now = visitor(context, slot, reach);
            if (!(now < reach)) continue;
            reach = now;
            limit = limitOf(reach * mesh.scale, slack);
            root = __builtin_sqrtf(limit) * 1.000001f;
          }
        }
      }
    } else {
      const Node* node = mesh.nodes + (current & kNumber);
      V near = segmentBounds(node, &ray);
      unsigned mask = lessOrEqualMask(near, set(limit));
      if (mask != 0 && (current & kHasLeaves) != 0) {
        near = maximum(near, segmentBounds(mesh.boxes + (current & kNumber), &ray));
        mask &= lessOrEqualMask(near, set(limit));
      }
      float bounds[kWidth];
      store(bounds, near);
      const int bottom = top;
      for (; mask != 0; mask &= mask - 1) {
        const int lane = __builtin_ctz(mask);
        const float bound = bounds[lane];
        int place = top++;
        for (; place > bottom && stack[place - 1].bound < bound; --place) stack[place] = stack[place - 1];
        stack[place].bound = bound;
        stack[place].child = node->child[lane];
      }
    }
    do {
      if (top == 0) return reach;
      --top;
    } while (!(stack[top].bound <= limit));
    current = stack[top].child;
  }
}

static void visitSegment(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visitor,
                         void* context) {
  searchSegment(mesh, from, to, reach, 0.0, visitor, context);
}

static double clearance(const Mesh& mesh, const double from[3], const double to[3], double most, double needed) {
  return searchSegment(mesh, from, to, most, needed, nullptr, nullptr);
}

// Leaves within the limit whose normals allow a local minimum: the way from one of their points to the point in
// question is nowhere steeper to the third axis than the sides of the box allow.
static inline unsigned leavesWithMinima(const LeafBoxes* boxes, V x, V y, V z, V limit, V slack) {
  const V zero = set(0.0f), one = set(1.0f);
  const Lanes lanes = lanesOf(boxes);
  V extent[3], squared = zero;
  for (int i = 0; i < 3; ++i) {
    const V a = mad(lanes.row(3 * i), x, mad(lanes.row(3 * i + 1), y, mad(lanes.row(3 * i + 2), z, lanes.row(9 + i))));
    extent[i] = maximum(a, sub(zero, a));
    const V d = maximum(sub(extent[i], lanes.row(12 + i)), zero);
    squared = mad(d, d, squared);
  }
  const V u = maximum(sub(sub(extent[0], lanes.row(12)), slack), zero);
  const V v = maximum(sub(sub(extent[1], lanes.row(13)), slack), zero);
  const V h = add(add(extent[2], lanes.row(14)), slack);
  const V cone = load(boxes->cone);
  return lessOrEqualMask(squared, limit) &
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
  int32_t stack[kStackSize];
  int top = 0;
  stack[top++] = mesh.root;
  while (top > 0) {
    const int32_t current = stack[--top];
    const Node* node = mesh.nodes + (current & kNumber);
    unsigned mask = lessOrEqualMask(boxBounds(node->low[0], node->high[0], kWidth, x, y, z), limit);
    if ((current & kHasLeaves) != 0) {
      const LeafBoxes* boxes = mesh.boxes + (current & kNumber);
      mask &= leavesWithMinima(boxes, x, y, z, limit, slack) | ~boxes->lanes;
    }
    for (; mask != 0; mask &= mask - 1) {
      const int32_t child = node->child[__builtin_ctz(mask)];
      if (child >= 0) {
        stack[top++] = child;
        continue;
      }
      V height;
      const V d = triangleDistances(lanesOf(mesh.leaves + ~child), x, y, z, &height);
      const V high =
          sub(maximum(height, sub(set(0.0f), height)), sub(set(0.0f), slack));  // |height| and what both may err by
      const V least = mul(load(mesh.cones + ~child * kWidth), d);
      unsigned near = lessOrEqualMask(d, limit) & lessOrEqualMask(least, mul(high, high));
      for (; near != 0; near &= near - 1) {
        const int32_t slot = ~child * kWidth + __builtin_ctz(near);
        if (mesh.triangles[slot].index >= 0) visitor(context, slot, reach);
      }
    }
  }
}
