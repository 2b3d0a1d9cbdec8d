// The search loops, written on a vector `V` of 16 floats that the including file defines together with
// load, store, set, add, sub, mul, mad, maximum, minimum, smallest, lessOrEqualMask, selectGreater and
// compress (the lanes of a mask to consecutive floats; up to 16 are written). Everything has internal
// linkage.

#include "exact.inl"

// Error of the float distances, with room to spare: at most 20 roundings of numbers not larger than |q|_1 + 2 extent
// enter, 2^-24 each, and a triangle that is represented by its edges alone is lower than 2^-20.
static const double kBoundError = 0x1p-19;
// Beyond this many mesh sizes float boxes no longer tell triangles apart; doubles take over.
static const double kFar = 64.0;
static const double kHuge = 1e300;

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

static inline void startSearch(Search* s, const Mesh* mesh, const double* point, double limitSquared) {
  s->mesh = mesh;
  s->point = point;
  for (int k = 0; k < 3; ++k) s->local[k] = (point[k] - mesh->centre[k]) * mesh->scale;
  s->x = static_cast<float>(s->local[0]);
  s->y = static_cast<float>(s->local[1]);
  s->z = static_cast<float>(s->local[2]);
  s->slack = kBoundError * (absolute(s->local[0]) + absolute(s->local[1]) + absolute(s->local[2]) + 2.0 * mesh->extent);
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

// Squared distances of the 16 triangles of a leaf from points in their frames: to the plane where the point lies over
// the triangle, else to the nearest edge (along the edge beyond its ends, across it in the plane, and the height over
// the plane). With directions in the frames, also how far the points lie ahead of the nearest points of the triangles.
static inline V frameDistances(const Leaf* leaf, V u, V v, V h, const V* way = nullptr, V* ahead = nullptr) {
  const V zero = set(0.0f);
  const V beyond = sub(u, load(leaf->length[0]));
  const V c1 = load(leaf->cosine[0]), s1 = load(leaf->sine[0]), c2 = load(leaf->cosine[1]), s2 = load(leaf->sine[1]);
  // Across: positive outside. Along: from the start of the edge.
  const V across0 = sub(zero, v);
  const V across1 = sub(mul(s1, beyond), mul(c1, v)), along1 = mad(c1, beyond, mul(s1, v));
  const V across2 = sub(mul(c2, v), mul(s2, u)), along2 = mad(c2, u, mul(s2, v));
  const V end0 = sub(u, maximum(minimum(u, load(leaf->length[0])), zero));
  const V end1 = sub(along1, maximum(minimum(along1, load(leaf->length[1])), zero));
  const V end2 = sub(along2, maximum(minimum(along2, load(leaf->length[2])), zero));
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
    *ahead = mad(h, way[2], selectGreater(out, load(leaf->inside), ofEdges, zero));
  }
  return mad(h, h, selectGreater(out, load(leaf->inside), edges, zero));
}

static inline V leafDistances(const Leaf* leaf, V x, V y, V z, V* height) {
  V f[3];
  for (int i = 0; i < 3; ++i)
    f[i] = mad(load(leaf->axis[i][0]), x,
               mad(load(leaf->axis[i][1]), y, mad(load(leaf->axis[i][2]), z, load(leaf->offset[i]))));
  *height = f[2];
  return frameDistances(leaf, f[0], f[1], f[2]);
}

static inline V leafDistances(const Leaf* leaf, V x, V y, V z) {
  V height;
  return leafDistances(leaf, x, y, z, &height);
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
  const V b = leafDistances(s->mesh->leaves + leaf, set(s->x), set(s->y), set(s->z));
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

// Squared distances of oriented boxes, given as rows of `stride` floats.
static inline V orientedBounds(const float* rows, int stride, V x, V y, V z) {
  const V zero = set(0.0f);
  V squared = zero;
  for (int i = 0; i < 3; ++i) {
    const float* axis = rows + 3 * i * stride;
    const V a =
        mad(load(axis), x, mad(load(axis + stride), y, mad(load(axis + 2 * stride), z, load(rows + (9 + i) * stride))));
    const V d = maximum(sub(maximum(a, sub(zero, a)), load(rows + (12 + i) * stride)), zero);
    squared = mad(d, d, squared);
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
        b = maximum(b, orientedBounds(s->mesh->boxes[current & kNumber].row[0], kWidth, x, y, z));
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
        cache->margin *= 0.8;
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

struct Found {
  int count;
  V smallest;
  int32_t leaf[ProximityCache::kRow];
  float distance[ProximityCache::kRow][kWidth];
};

// The triangles of one leaf, without a branch on what they hold.
static inline void lookAt(const Search* s, int32_t leaf, V x, V y, V z, Found* found) {
  const V b = leafDistances(s->mesh->leaves + leaf, x, y, z);
  store(found->distance[found->count], b);
  found->leaf[found->count++] = leaf;
  found->smallest = minimum(found->smallest, b);
}

// The limit once for all leaves looked at, then the exact distances of the few triangles below it.
static inline void settleFound(Search* s, const Found* found) {
  const float least = smallest(found->smallest);
  if (least < s->least) tightenToFloat(s, least);
  const V limit = set(s->limit);
  for (int i = 0; i < found->count; ++i)
    for (unsigned mask = lessOrEqualMask(load(found->distance[i]), limit); mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      tryTriangle(s, found->leaf[i] * kWidth + lane);
    }
}

static inline void searchList(Search* s, const ProximityCache::List* list) {
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  Found found;
  found.count = 0;
  found.smallest = set(3.4e38f);
  for (int first = 0; first < list->count; first += kWidth) {
    const V b = orientedBounds(list->box[0] + first, ProximityCache::kRow, x, y, z);
    unsigned mask = lessOrEqualMask(b, set(s->limit)) & firstLanes(list->count - first);
    for (; mask != 0; mask &= mask - 1) lookAt(s, list->leaf[first + __builtin_ctz(mask)], x, y, z, &found);
  }
  settleFound(s, &found);
}

// Makes the list anew and searches it. It holds every leaf within d + 2 r of its origin o, where d is a distance that
// some point of the mesh has from o. For a query p with |p - o| <= r, the nearest triangle is within d + r of p, hence
// within d + 2 r of o: it is listed. Answers 0 if there are too many leaves; the margin adapts.
static inline int searchRegion(Search* s, double nearest, Cache* cache) {
  ProximityCache::List* list = &cache->list;
  const ProximityCache::Region* region = &cache->region[cache->active];
  const V x = set(s->x), y = set(s->y), z = set(s->z);
  const V most = set(limitOf(nearest + 2.0 * cache->margin, s->slack)), limit = set(s->limit);
  Found found;
  found.count = 0;
  found.smallest = set(3.4e38f);
  list->count = 0;
  list->radius = -1.0;
  for (int first = 0; first < region->count; first += kWidth) {
    const V bounds = boxBounds(region->low[0] + first, region->high[0] + first, ProximityCache::kRegion, x, y, z);
    const unsigned mask = lessOrEqualMask(bounds, most) & firstLanes(region->count - first);
    for (unsigned i = mask & (mask - 1); i != 0; i &= i - 1)
      fetch(s->mesh->boxes + region->node[first + __builtin_ctz(i)], 16);
    for (unsigned i = mask; i != 0; i &= i - 1) {
      const int32_t number = region->node[first + __builtin_ctz(i)];
      const Node* node = s->mesh->nodes + number;
      const LeafBoxes* boxes = s->mesh->boxes + number;
      const V b = orientedBounds(boxes->row[0], kWidth, x, y, z);
      const unsigned listed = lessOrEqualMask(b, most) & boxes->lanes;
      const int count = __builtin_popcount(listed);
      if (list->count + count > ProximityCache::kLeaves) {
        cache->margin *= 0.6;
        return 0;
      }
      for (unsigned j = listed & lessOrEqualMask(b, limit); j != 0; j &= j - 1)
        lookAt(s, ~node->child[__builtin_ctz(j)], x, y, z, &found);
      for (int row = 0; row < 15; ++row) compress(load(boxes->row[row]), listed, list->box[row] + list->count);
      for (unsigned j = listed; j != 0; j &= j - 1) list->leaf[list->count++] = ~node->child[__builtin_ctz(j)];
    }
  }
  for (int k = 0; k < 3; ++k) list->origin[k] = s->local[k];
  list->radius = cache->margin * (1.0 - 1e-6);
  if (list->count <= kWidth / 2 && region->count <= ProximityCache::kRegion / 2) cache->margin *= 1.25;
  if (list->count > kWidth) cache->margin *= 0.85;
  settleFound(s, &found);
  return 1;
}

// The previous answer is on the mesh, so its distance bounds the new one. Close to it, a list of leaves answers. Lists
// are made at once from a region, and regions ahead of time, a little every query, so that no query pays for much;
// where neither is at hand the tree is searched.
static inline void searchWithCache(Search* s, Cache* cache) {
  const float surface = __builtin_sqrtf(static_cast<float>(squaredDistance(s->local, cache->surface))) * 1.000001f;
  lowerLimit(s, (surface + s->slackUp) * (surface + s->slackUp) * 1.000002f);
  const ProximityCache::List* list = &cache->list;
  if (list->radius >= 0.0 && squaredDistance(s->local, list->origin) <= list->radius * list->radius) {
    searchList(s, list);
    if (cache->open >= 0) extendRegion(s, cache);
    return;
  }
  const double step = squaredDistance(s->local, cache->query);
  if (step * 4.0 > cache->margin * cache->margin) {  // a list would not hold for two queries
    if (step <= 1.0 / 4096.0) cache->margin *= 1.1;
    searchTree(s, 0);
    return;
  }
  const double nearest = static_cast<double>(surface);
  const double need = nearest + 2.0 * cache->margin;
  const ProximityCache::Region* region = &cache->region[cache->active];
  const double room = region->reach - need - __builtin_sqrt(squaredDistance(s->local, region->origin));
  if (room < 0.0 || searchRegion(s, nearest, cache) == 0) searchTree(s, 0);
  if (cache->open >= 0) {
    const ProximityCache::Region* next = &cache->region[1 - cache->active];
    if (next->reach - need - __builtin_sqrt(squaredDistance(s->local, next->origin)) < 0.0) cache->open = -1;
  }
  if (cache->open < 0 && room < 0.5 * cache->span) openRegion(s, need + cache->span, cache);
  if (cache->open >= 0) extendRegion(s, cache);
}

static void closest(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer) {
  Search s;
  startSearch(&s, &mesh, point, limitSquared);
  const int known = cache != nullptr && cache->revision == mesh.revision;
  if (cache != nullptr && !known) {
    cache->revision = 0;
    cache->list.radius = -1.0;
    cache->region[0].reach = cache->region[1].reach = -1.0;
    cache->active = 0;
    cache->open = -1;
    cache->margin = 1.0 / 64.0;
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
        const V d = leafDistances(mesh.leaves + ~current, set(static_cast<float>(middle[0])),
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
  V start[3], way[3];
  for (int i = 0; i < 3; ++i) {
    const V x = load(leaf->axis[i][0]), y = load(leaf->axis[i][1]), z = load(leaf->axis[i][2]);
    start[i] = mad(x, ray->start[0], mad(y, ray->start[1], mad(z, ray->start[2], load(leaf->offset[i]))));
    way[i] = mad(x, ray->way[0], mad(y, ray->way[1], mul(z, ray->way[2])));
  }
  const V a = sub(zero, mad(start[0], way[0], mad(start[1], way[1], mul(start[2], way[2]))));
  const V b = mad(load(leaf->length[0]), way[0], a);
  const V c = mad(load(leaf->length[2]), mad(load(leaf->cosine[1]), way[0], mul(load(leaf->sine[1]), way[1])), a);
  const V first = between(minimum(minimum(a, b), c), zero, ray->length);
  const V last = between(maximum(maximum(a, b), c), zero, ray->length);
  const V at = mul(add(first, last), half);
  *halfWay = mul(sub(last, first), half);
  return frameDistances(leaf, mad(way[0], at, start[0]), mad(way[1], at, start[1]), mad(way[2], at, start[2]), way,
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
    V b = boxBounds(node->low[0], node->high[0], kWidth, x, y, z);
    if ((current & kHasLeaves) != 0)
      b = maximum(b, orientedBounds(mesh.boxes[current & kNumber].row[0], kWidth, x, y, z));
    for (unsigned mask = lessOrEqualMask(b, limit); mask != 0; mask &= mask - 1) {
      const int32_t child = node->child[__builtin_ctz(mask)];
      if (child >= 0) {
        stack[top++] = child;
        continue;
      }
      V height;
      const V d = leafDistances(mesh.leaves + ~child, x, y, z, &height);
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
