// The nearest triangle to a point: float bounds choose candidates, doubles decide between them.
#pragma once

#include "near_list.inl"

constexpr int kMostCandidates = 64;

struct Search {
  Search(const Mesh& of, const double* p, double limitSquared);
  V3 q() const { return {{set(rounded[0]), set(rounded[1]), set(rounded[2])}}; }  // the point, one register per number

  const Mesh& mesh;
  const double* point;  // original coordinates
  double local[3];
  float rounded[3];       // local
  double slack;           // absolute error of a float distance
  float slackUp;          // the same, rounded up
  float least = 3.4e38f;  // smallest squared float distance so far
  float limit = 3.4e38f;  // largest squared float distance that may still matter
  // Triangles whose exact distance is still to be computed.
  int candidates = 0;
  int32_t candidate[kMostCandidates];
  float candidateBound[kMostCandidates];
  // The best exact answer so far.
  double squared;
  int32_t slot = -1;
  int32_t index = 0x7fffffff;
  Candidate best;
};

inline void lowerLimit(Search& s, float limit) {
  if (limit < s.limit) s.limit = limit;
}

// Lower the limit: the nearest triangle so far is within `slack` of its float distance. Triangles above the limit
// cannot be nearest.
inline void tightenToFloat(Search& s, float least) {
  s.least = least;
  const float d = __builtin_sqrtf(least) + 2.0f * s.slackUp;
  lowerLimit(s, d * d * 1.000002f);
}

inline void tightenToExact(Search& s) { lowerLimit(s, limitOf(__builtin_sqrt(s.squared) * s.mesh.scale, s.slack)); }

// Every box holds a triangle, and the triangle is at most as far as the farthest corner of the box.
inline void tightenToBoxes(Search& s, const Lanes& boxes) {
  V3 far = fromMiddles(boxes, s.q());
  for (int i = 0; i < 3; ++i) far[i] = far[i] + boxes.half(i);
  const float d = __builtin_sqrtf(smallest(squaredLength(far))) + s.slackUp;
  lowerLimit(s, d * d * 1.000002f);
}

inline Search::Search(const Mesh& of, const double* p, double limitSquared) : mesh(of), point(p) {
  toLocal(mesh, point, local);
  for (int k = 0; k < 3; ++k) rounded[k] = static_cast<float>(local[k]);
  slack = slackOf(mesh, local);
  slackUp = static_cast<float>(slack) * 1.000001f;
  squared = limitSquared < kHuge ? limitSquared : kHuge;
  if (limitSquared < kHuge) tightenToExact(*this);
}

// The smaller distance wins; at equal distance the smaller index.
inline void keepNearer(Search& s, const Triangle* t, const Candidate& c) {
  if (!(c.squared < s.squared || (c.squared == s.squared && t->index < s.index))) return;
  s.squared = c.squared;
  s.slot = static_cast<int32_t>(t - s.mesh.triangles);
  s.index = t->index;
  s.best = c;
}

inline void tryTriangle(Search& s, int32_t slot) {
  const Triangle* t = s.mesh.triangles + slot;
  if (t->index < 0) return;
  Candidate c;
  closestOnTriangle(t, s.point, &c);
  keepNearer(s, t, c);
}

// Four at a time.
inline void tryTriangles(Search& s, const int32_t* slot, int all) {
  for (; all > 0; slot += 4, all -= 4) {
    const int count = all < 4 ? all : 4;
    if (count == 1) return tryTriangle(s, slot[0]);
    const Triangle* t[4];
    bool odd = false;
    for (int i = 0; i < 4; ++i) {
      t[i] = s.mesh.triangles + slot[i < count ? i : 0];
      odd |= t[i]->index < 0 || isThin(t[i]);
    }
    if (odd) {
      for (int i = 0; i < count; ++i) tryTriangle(s, slot[i]);
      continue;
    }
    Candidate c;
    keepNearer(s, t[closestOfFour(t, s.point, &c)], c);
  }
}

// Drop candidates that are ruled out.
inline void sift(Search& s) {
  int kept = 0;
  for (int i = 0; i < s.candidates; ++i) {
    if (!(s.candidateBound[i] <= s.limit)) continue;
    s.candidate[kept] = s.candidate[i];
    s.candidateBound[kept++] = s.candidateBound[i];
  }
  s.candidates = kept;
}

// Compute the exact distances of the candidates. They are few: all lie within the error of the float distances.
inline void settle(Search& s) {
  sift(s);
  tryTriangles(s, s.candidate, s.candidates);
  s.candidates = 0;
}

// Rare, and not inlined, so that the loop over nodes stays small.
__attribute__((noinline)) void makeRoom(Search& s) {
  sift(s);
  if (s.candidates <= kMostCandidates / 2) return;
  settle(s);
  tightenToExact(s);
}

inline void keepCandidate(Search& s, int32_t slot, float bound) {
  if (s.candidates == kMostCandidates) makeRoom(s);
  fetchTriangle(s.mesh, slot);
  s.candidate[s.candidates] = slot;
  s.candidateBound[s.candidates++] = bound;
}

inline void searchLeaf(Search& s, int32_t leaf) {
  const V b = triangleDistances(lanesOf(s.mesh.leaves[leaf]), s.q());
  unsigned mask = lessOrEqualMask(b, s.limit);
  if (mask == 0) return;
  const float least = smallest(b);
  if (least < s.least) {
    tightenToFloat(s, least);
    mask = lessOrEqualMask(b, s.limit);
  }
  float bounds[kWidth];
  store(bounds, b);
  for (; mask != 0; mask &= mask - 1) {
    const int lane = __builtin_ctz(mask);
    keepCandidate(s, leaf * kWidth + lane, bounds[lane]);
  }
}

// `cold`: nothing is known about the answer, and every box holds a triangle.
inline void searchTree(Search& s, bool cold) {
  const auto boundsOf = [&s, cold](const Node& node) {
    const Lanes boxes = lanesOf(node);
    const V bounds = squaredLength(beyondBoxes(boxes, fromMiddles(boxes, s.q())));
    // After the bounds: before them, the compiler would load all rows at once, which are more than the registers.
    if (cold && s.least > 3e38f) tightenToBoxes(s, boxes);
    return bounds;
  };
  nearestFirst(s.mesh, s.limit, boundsOf, [&s](int32_t leaf) { searchLeaf(s, leaf); });
}

// Far away: bounds in double, of the axis-aligned boxes.
struct FarBounds {
  double lane[kWidth];
};

inline double smallest(const FarBounds& b) {
  double least = b.lane[0];
  for (const double one : b.lane) least = one < least ? one : least;
  return least;
}

inline unsigned lessOrEqualMask(const FarBounds& b, double limit) {
  unsigned mask = 0;
  for (int i = 0; i < kWidth; ++i) mask |= static_cast<unsigned>(b.lane[i] <= limit) << i;
  return mask;
}

inline void push(const FarBounds& b, unsigned mask, double* p) {
  for (; mask != 0; mask &= mask - 1) *p++ = b.lane[__builtin_ctz(mask)];
}

inline void searchFar(Search& s) {
  const double unit = s.mesh.scale * s.mesh.scale * (1.0 + 1e-12);
  double limit = s.squared * unit;
  const auto boundsOf = [&s](const Node& node) {
    const AlignedBoxes& boxes = s.mesh.boxes[&node - s.mesh.nodes];
    FarBounds bounds;
    for (int lane = 0; lane < kWidth; ++lane) {
      bounds.lane[lane] = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double below = static_cast<double>(boxes.low[k][lane]) - s.local[k];
        const double above = s.local[k] - static_cast<double>(boxes.high[k][lane]);
        const double d = below > above ? below : above;
        if (d > 0.0) bounds.lane[lane] += d * d;
      }
    }
    return bounds;
  };
  nearestFirst(s.mesh, limit, boundsOf, [&](int32_t leaf) {
    for (int lane = 0; lane < kWidth; ++lane) tryTriangle(s, leaf * kWidth + lane);
    limit = s.squared * unit;
  });
}

// The previous answer is on the mesh, so its distance bounds the new one. If a list holds, it gives the answer;
// otherwise the tree is searched.
inline void searchWithCache(Search& s, Cache& cache) {
  const float surface = __builtin_sqrtf(static_cast<float>(squaredDistance(s.local, cache.surface))) * 1.000001f;
  const NearList* list = listAt(s.mesh, s.local, cache.near);
  if (list == nullptr) {
    lowerLimit(s, (surface + s.slackUp) * (surface + s.slackUp) * 1.000002f);
    return searchTree(s, false);
  }
  // The planes of the list have the rounding error of its origin, which may be farther out than the point.
  const float slack = s.slackUp > list->slack ? s.slackUp : list->slack;
  float most = surface + 3.0f * slack;
  if (s.limit < most * most) most = __builtin_sqrtf(s.limit) * 1.000001f + 2.0f * slack;
  int32_t slot[kListed + kSpare];
  tryTriangles(s, slot, listedWithin(*list, s.local, most, slot));
}

void closest(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer) {
  Search s(mesh, point, limitSquared);
  const bool known = cache != nullptr && cache->revision == mesh.revision;
  if (cache != nullptr && !known) {
    cache->revision = 0;
    forget(cache->near);
  }
  if (isFar(s.local)) {
    searchFar(s);
  } else if (known) {
    searchWithCache(s, *cache);
  } else {
    searchTree(s, mesh.tight != 0);
  }
  settle(s);
  if (cache != nullptr && s.slot >= 0) {
    double motion[3];
    subtract(s.local, cache->query, motion);
    cache->revision = mesh.revision;
    for (int k = 0; k < 3; ++k) cache->query[k] = s.local[k];
    toLocal(mesh, s.best.point, cache->surface);
    if (known && !isFar(s.local)) workAhead(mesh, s.local, motion, cache->surface, cache->near);
  }
  answer->slot = s.slot;
  answer->nearest = s.slot >= 0 ? s.best : Candidate{s.squared, {point[0], point[1], point[2]}, kFace, 0.0, 0.0};
}
