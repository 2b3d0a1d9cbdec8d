// The search loops, written on a vector `V` of 16 floats that the including file defines together with
// load, set, add, sub, mul, div, mad, maximum, minimum, lessOrEqualMask and selectGreater. Everything has internal
// linkage.

#include "exact.inl"

// Relative and absolute share of rounding in the float bounds, with room to spare: at most 20 roundings of numbers
// not larger than |q|_1 + 2 enter a distance, 2^-24 each, and a triangle is bounded by its edges alone if it is
// lower than 2^-20.
static const double kBoundError = 0x1p-19;
// Beyond this many mesh sizes float boxes no longer tell triangles apart; doubles take over.
static const double kFar = 64.0;
static const double kHuge = 1e300;

struct Search {
  const Mesh* mesh;
  const double* point;  // original coordinates
  double local[3];
  float x, y, z;     // local, rounded
  double slack;      // absolute error of a float bound
  double squared;    // best so far, original units
  double bound;      // its root in local units, without slack
  float limit;       // largest float bound (squared) that may still matter
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

static inline void tighten(Search* s) {
  s->bound = __builtin_sqrt(s->squared) * s->mesh->scale;
  s->limit = limitOf(s->bound, s->slack);
}

static inline int isFar(const double* local) {
  return !(local[0] < kFar && local[0] > -kFar && local[1] < kFar && local[1] > -kFar && local[2] < kFar &&
           local[2] > -kFar);
}

static inline double absolute(double v) { return v < 0.0 ? -v : v; }

static inline void startSearch(Search* s, const Mesh* mesh, const double* point, double limitSquared) {
  s->mesh = mesh;
  s->point = point;
  for (int k = 0; k < 3; ++k) s->local[k] = (point[k] - mesh->centre[k]) * mesh->scale;
  s->x = static_cast<float>(s->local[0]);
  s->y = static_cast<float>(s->local[1]);
  s->z = static_cast<float>(s->local[2]);
  s->slack = kBoundError * (absolute(s->local[0]) + absolute(s->local[1]) + absolute(s->local[2]) + 2.0);
  s->squared = limitSquared < kHuge ? limitSquared : kHuge;
  s->slot = -1;
  s->index = 0x7fffffff;
  tighten(s);
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
    tighten(s);
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

// One edge: squared distance to the segment, and where the point lies seen from the plane through the edge along
// the normal (positive: outside).
static inline V edgeBound(V ax, V ay, V az, V ex, V ey, V ez, V nx, V ny, V nz, V* outside) {
  const V zero = set(0.0f), one = set(1.0f);
  const V ee = maximum(mad(ex, ex, mad(ey, ey, mul(ez, ez))), set(1e-30f));
  const V along = mad(ax, ex, mad(ay, ey, mul(az, ez)));
  const V t = minimum(maximum(div(along, ee), zero), one);
  const V rx = sub(ax, mul(t, ex)), ry = sub(ay, mul(t, ey)), rz = sub(az, mul(t, ez));
  const V cx = sub(mul(ey, nz), mul(ez, ny)), cy = sub(mul(ez, nx), mul(ex, nz)), cz = sub(mul(ex, ny), mul(ey, nx));
  *outside = mad(cx, ax, mad(cy, ay, mul(cz, az)));
  return mad(rx, rx, mad(ry, ry, mul(rz, rz)));
}

// Squared distances of the 16 triangles of a leaf: to the plane where the point lies over the triangle, else to the
// nearest edge. Both parts are well conditioned; near the border between them they agree to within the slack.
static inline V leafBounds(const Leaf* leaf, V x, V y, V z) {
  const V ax = load(leaf->corner[0][0]), ay = load(leaf->corner[0][1]), az = load(leaf->corner[0][2]);
  const V bx = load(leaf->corner[1][0]), by = load(leaf->corner[1][1]), bz = load(leaf->corner[1][2]);
  const V cx = load(leaf->corner[2][0]), cy = load(leaf->corner[2][1]), cz = load(leaf->corner[2][2]);
  const V nx = load(leaf->normal[0]), ny = load(leaf->normal[1]), nz = load(leaf->normal[2]);
  const V apx = sub(x, ax), apy = sub(y, ay), apz = sub(z, az);
  V sideA, sideB, sideC;
  const V ab = edgeBound(apx, apy, apz, sub(bx, ax), sub(by, ay), sub(bz, az), nx, ny, nz, &sideA);
  const V bc = edgeBound(sub(x, bx), sub(y, by), sub(z, bz), sub(cx, bx), sub(cy, by), sub(cz, bz), nx, ny, nz, &sideB);
  const V ca = edgeBound(sub(x, cx), sub(y, cy), sub(z, cz), sub(ax, cx), sub(ay, cy), sub(az, cz), nx, ny, nz, &sideC);
  const V height = mad(nx, apx, mad(ny, apy, mul(nz, apz)));
  const V edges = minimum(minimum(ab, bc), ca);
  return selectGreater(maximum(maximum(sideA, sideB), sideC), load(leaf->inside), edges, mul(height, height));
}

// Bounds of a whole leaf first, then exact distances of the triangles that may win, the most promising first.
static inline void searchLeaf(Search* s, int32_t leaf) {
  float bounds[kWidth];
  const V b = leafBounds(s->mesh->leaves + leaf, set(s->x), set(s->y), set(s->z));
  unsigned mask = lessOrEqualMask(b, set(s->limit));
  if (mask == 0) return;
  const int32_t base = leaf * kWidth;
  if (s->slot >= base && s->slot < base + kWidth) mask &= ~(1u << (s->slot - base));
  if ((mask & (mask - 1)) == 0) {
    if (mask != 0) tryTriangle(s, base + __builtin_ctz(mask));
    return;
  }
  store(bounds, b);
  while (mask != 0) {
    int next = __builtin_ctz(mask);
    for (unsigned rest = mask & (mask - 1); rest != 0; rest &= rest - 1) {
      const int lane = __builtin_ctz(rest);
      if (bounds[lane] < bounds[next]) next = lane;
    }
    if (!(bounds[next] <= s->limit)) return;
    mask &= ~(1u << next);
    tryTriangle(s, base + next);
  }
}

struct Entry {
  float bound;
  int32_t child;
};

// Depth first, the nearest child first.
static inline void searchTree(Search* s) {
  Entry stack[kStackSize];
  int top = 0;
  int32_t current = s->mesh->root;
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  for (;;) {
    if (current < 0) {
      searchLeaf(s, ~current);
    } else {
      const Node* node = s->mesh->nodes + current;
      const V b = boxBounds(node->low[0], node->high[0], kWidth, x, y, z);
      unsigned mask = lessOrEqualMask(b, set(s->limit));
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
          stack[place].bound = bound;
          stack[place].child = node->child[lane];
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
    const Node* node = s->mesh->nodes + entry.child;
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

// Lists every leaf whose box is within `reach` (local) of the query. Answers 0 if there are too many.
static inline int listLeaves(const Search* s, double reach, Cache* cache) {
  const float limit = limitOf(reach, s->slack);
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  int32_t stack[kStackSize];
  int top = 0, count = 0;
  if (s->mesh->root < 0) return 0;
  stack[top++] = s->mesh->root;
  while (top > 0) {
    const Node* node = s->mesh->nodes + stack[--top];
    unsigned mask = lessOrEqualMask(boxBounds(node->low[0], node->high[0], kWidth, x, y, z), set(limit));
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      const int32_t child = node->child[lane];
      if (child >= 0) {
        stack[top++] = child;
        continue;
      }
      if (count == kListCapacity) return 0;
      cache->leaf[count] = ~child;
      for (int k = 0; k < 3; ++k) {
        cache->low[k][count] = node->low[k][lane];
        cache->high[k][count] = node->high[k][lane];
      }
      ++count;
    }
  }
  const int padded = (count + kWidth - 1) / kWidth * kWidth;
  for (int i = count; i < padded; ++i)
    for (int k = 0; k < 3; ++k) {
      cache->low[k][i] = 3e38f;
      cache->high[k][i] = -3e38f;
    }
  cache->count = count;
  return 1;
}

static inline void searchList(Search* s, const Cache* cache) {
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  for (int first = 0; first < cache->count; first += kWidth) {
    const V b = boxBounds(cache->low[0] + first, cache->high[0] + first, kListCapacity, x, y, z);
    unsigned mask = lessOrEqualMask(b, set(s->limit));
    if (mask == 0) continue;
    float bounds[kWidth];
    store(bounds, b);
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      if (bounds[lane] <= s->limit) searchLeaf(s, cache->leaf[first + lane]);
    }
  }
}

// The list holds every leaf within d + 2 r of its origin o, where d is a distance that some triangle has from o. For
// a query p with |p - o| <= r, the nearest triangle is within d + r of p, hence within d + 2 r of o: it is listed.
static inline void searchWithCache(Search* s, Cache* cache) {
  const Mesh* mesh = s->mesh;
  if (cache->revision != mesh->revision) {
    cache->revision = mesh->revision;
    cache->slot = -1;
    cache->count = 0;
    cache->margin = 1.0 / 64.0;
    for (int k = 0; k < 3; ++k) cache->last[k] = 1e9;
  }
  double hint = -1.0;  // distance of the previous answer's triangle from here, local
  if (cache->slot >= 0) {
    tryTriangle(s, cache->slot);
    if (s->slot >= 0) hint = s->bound;
  }
  const double step = squaredDistance(s->local, cache->last);
  for (int k = 0; k < 3; ++k) cache->last[k] = s->local[k];
  if (cache->count > 0 && squaredDistance(s->local, cache->origin) <= cache->radius * cache->radius) {
    searchList(s, cache);
  } else {
    cache->count = 0;
    // Worth the while if the ball will hold for a few ticks.
    if (hint >= 0.0 && step * 16.0 <= cache->margin * cache->margin) {
      if (listLeaves(s, hint + 2.0 * cache->margin, cache) != 0) {
        for (int k = 0; k < 3; ++k) cache->origin[k] = s->local[k];
        cache->radius = cache->margin * (1.0 - 1e-6);
        if (cache->count <= kListCapacity / 4) cache->margin *= 1.25;
      } else {
        cache->margin *= 0.7;
      }
    } else if (step * 16.0 > cache->margin * cache->margin && step <= 1.0 / 256.0) {
      cache->margin *= 1.1;  // shrunk too far for this speed
    }
    if (cache->count > 0) {
      searchList(s, cache);
    } else {
      searchTree(s);
    }
  }
  if (s->slot >= 0) cache->slot = s->slot;
}

static void closest(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer) {
  Search s;
  startSearch(&s, &mesh, point, limitSquared);
  if (isFar(s.local)) {
    searchFar(&s);
  } else if (cache != nullptr) {
    searchWithCache(&s, cache);
  } else {
    searchTree(&s);
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
  double low[3], high[3], size = 2.0;
  for (int k = 0; k < 3; ++k) {
    const double a = (from[k] - mesh.centre[k]) * mesh.scale, b = (to[k] - mesh.centre[k]) * mesh.scale;
    low[k] = a < b ? a : b;
    high[k] = a < b ? b : a;
    size += absolute(low[k]) > absolute(high[k]) ? absolute(low[k]) : absolute(high[k]);
  }
  const double slack = kBoundError * size;
  stack[top++] = mesh.root;
  while (top > 0) {
    const int32_t current = stack[--top];
    if (current < 0) {
      for (int lane = 0; lane < kWidth; ++lane) {
        const int32_t slot = ~current * kWidth + lane;
        if (mesh.triangles[slot].index >= 0) reach = visitor(context, slot, reach);
      }
      if (reach < 0.0) return;
      continue;
    }
    const Node* node = mesh.nodes + current;
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
