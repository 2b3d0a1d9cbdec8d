// Triangles near a segment: all within a reach, or the nearest one.
#pragma once

#include "descent.inl"

// Measured as described in near_list.inl, with segments of 5 mm from the points of the path outwards.

// Share of the clearance above a segment's reach that is worth computing; a tracked tool skips queries by it. 0 and 1
// make no difference in the query itself.
constexpr float kEnough = 0.5f;
// If more triangles of a leaf may be nearest, better bounds pay off: first that of the line, then a second plane. With
// 6 and 12 the time is 1.2 times on 100 k. Other trials made no difference on these segments: 0, 3 and 3, none at all.
enum { kFewOfLeaf = 3, kManyOfLeaf = 6 };

// In local coordinates: start, unit direction, length.
struct LocalSegment {
  double from[3], to[3];
  V3 start, direction;
  V length;
  double slack;  // absolute error of a float distance
};

inline LocalSegment toLocal(const Mesh& mesh, const double* from, const double* to) {
  LocalSegment segment;
  double span[3], size = 2.0 * mesh.extent;
  toLocal(mesh, from, segment.from);
  toLocal(mesh, to, segment.to);
  subtract(segment.to, segment.from, span);
  const double length = __builtin_sqrt(dot(span, span));
  for (int k = 0; k < 3; ++k) {
    const double a = absolute(segment.from[k]), b = absolute(segment.to[k]);
    size += a > b ? a : b;
    span[k] = length > 0.0 ? span[k] / length : 0.0;
  }
  segment.start = setAll(segment.from);
  segment.direction = setAll(span);
  segment.length = set(static_cast<float>(length));
  segment.slack = kBoundError * size;
  return segment;
}

inline bool isFar(const LocalSegment& segment) { return isFar(segment.from) || isFar(segment.to); }

// Test boxes against the box of the segment, enlarged by the reach. Floats select; the visitor decides exactly.
void visit(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visitor, void* context) {
  const LocalSegment segment = toLocal(mesh, from, to);
  double low[3], high[3], middle[3], extent[3];
  for (int k = 0; k < 3; ++k) {
    const double a = segment.from[k], b = segment.to[k];
    low[k] = a < b ? a : b;
    high[k] = a < b ? b : a;
    middle[k] = 0.5 * (low[k] + high[k]);
    extent[k] = 0.5 * (high[k] - low[k]);
  }
  const double half = __builtin_sqrt(dot(extent, extent));
  const V3 lowest = setAll(low), highest = setAll(high), centre = setAll(middle);
  const auto nearOf = [&](const Node& node) {
    const AlignedBoxes& boxes = mesh.boxes[&node - mesh.nodes];
    V3 d;
    for (int k = 0; k < 3; ++k) {
      const V below = load(boxes.low[k]) - highest[k];
      const V above = lowest[k] - load(boxes.high[k]);
      d[k] = positive(maximum(below, above));
    }
    return lessOrEqualMask(squaredLength(d), limitOf(reach * mesh.scale, segment.slack));
  };
  anyOrder(mesh, nearOf, [&](int32_t leaf) {
    // A point within reach of the segment is within reach plus half the length of its middle.
    unsigned near = 0xffffu;
    if (!isFar(middle))
      near = lessOrEqualMask(triangleDistances(lanesOf(mesh.leaves[leaf]), centre),
                             limitOf(reach * mesh.scale + half, segment.slack));
    for (; near != 0; near &= near - 1) {
      const int32_t slot = leaf * kWidth + __builtin_ctz(near);
      if (mesh.triangles[slot].index >= 0) reach = visitor(context, slot, reach);
    }
  });
}

// Lower bounds of the squared distances of the boxes of a node from a segment. Only the feet of a box on the segment
// can be nearest to it. The plane across the line from the middle of the feet to the box separates them. Along the
// segment the height over the plane decreases at most by its slope.
__attribute__((always_inline)) inline V segmentBounds(const Lanes& boxes, const LocalSegment& segment) {
  const V zero = set(0.0f), oneHalf = set(0.5f);
  const V3 start = boxes.place(segment.start), direction = boxes.turn(segment.direction);
  V foot = zero, extent = zero;
  for (int i = 0; i < 3; ++i) {
    foot = mad(start[i], direction[i], foot);
    extent = mad(absolute(direction[i]), boxes.half(i), extent);
  }
  const V first = between(-foot - extent, zero, segment.length);
  const V last = between(extent - foot, zero, segment.length);
  const V3 middle = along(start, (first + last) * oneHalf, direction);
  const V halfLength = (last - first) * oneHalf;
  V squared = zero, ahead = zero;
  for (int i = 0; i < 3; ++i) {
    const V d = middle[i] - between(middle[i], -boxes.half(i), boxes.half(i));
    squared = mad(d, d, squared);
    ahead = mad(d, direction[i], ahead);
  }
  const V height = positive(squared - absolute(ahead) * halfLength);
  return height * height / maximum(squared, set(1e-30f));
}

// A segment in the frames of the triangles of a leaf, and their feet on it: `halfLength` to both sides of the middle.
struct Feet {
  V3 start, direction;
  V middle, halfLength;
};

inline Feet feetOn(const Lanes& frames, const LocalSegment& segment) {
  const V zero = set(0.0f), oneHalf = set(0.5f);
  Feet feet;
  feet.start = frames.place(segment.start);
  feet.direction = frames.turn(segment.direction);
  const V3& direction = feet.direction;
  const V a = -dot(feet.start, direction);
  const V b = mad(frames.row(kLength), direction[0], a);
  const V c =
      mad(frames.row(kLength + 2), mad(frames.row(kCosine + 1), direction[0], frames.row(kSine + 1) * direction[1]), a);
  const V first = between(minimum(minimum(a, b), c), zero, segment.length);
  const V last = between(maximum(maximum(a, b), c), zero, segment.length);
  feet.middle = (first + last) * oneHalf;
  feet.halfLength = (last - first) * oneHalf;
  return feet;
}

// Squared distances of the triangles from places of the segment, and separating planes. `height` is the height of the
// place over the plane, `slope` its change per step along the segment. Any normal of length up to 1 is valid. The best
// is the offset from the nearest point.
struct InFront {
  V squared, height, slope;
};

inline InFront inFrontAt(const Lanes& frames, const Feet& feet, V at) {
  const V3 p = along(feet.start, at, feet.direction);
  V3 n;
  InFront front;
  front.squared = frameDistances(frames, p, &n);
  const V inverse = set(0.9995f) * inverseRoot(maximum(front.squared, set(1e-12f)));
  const V toB = n[0] * frames.row(kLength);
  const V toC = frames.row(kLength + 2) * mad(n[0], frames.row(kCosine + 1), n[1] * frames.row(kSine + 1));
  front.height = (dot(n, p) - positive(maximum(toB, toC))) * inverse;
  front.slope = dot(n, feet.direction) * inverse;
  return front;
}

inline V boundOf(const InFront& front, V halfLength) { return front.height - halfLength * absolute(front.slope); }

// Start at the point where the line meets the plane. A step d along the line approaches the triangle by at most d times
// the cosine of the angle between them, and leaves the plane by d times its sine. So the distance is at least the
// distance in the plane times that sine.
inline V lineBound(const Lanes& frames, const Feet& feet, float error) {
  const V sine = absolute(feet.direction[2]), flat = set(1e-6f);
  const V at = -feet.start[2] / selectGreater(sine, flat, feet.direction[2], flat);
  V3 p = along(feet.start, at, feet.direction);
  p[2] = set(0.0f);
  return root(frameDistances(frames, p)) * (sine * set(0.99999f)) - set(2.0f * error);
}

// Add a second plane at the end of the feet where the first is lowest. The bound is where both meet, or in the middle.
inline V betterBound(const Lanes& frames, const Feet& feet, const InFront& first, float error) {
  const V zero = set(0.0f), w = feet.halfLength;
  const V end = selectGreater(first.slope, zero, feet.middle - w, feet.middle + w);
  const InFront second = inFrontAt(frames, feet, end);
  const V inwards = selectGreater(first.slope, zero, second.slope, -second.slope);
  const V down = positive(-inwards);  // from the end to the middle
  const V up = absolute(first.slope);
  const V met = (second.height - first.height + up * w) / maximum(up + down, set(1e-6f));
  const V low = second.height - down * between(met, zero, w);
  return minimum(low, first.height) - set(error);
}

inline float rootUp(float squared) { return __builtin_sqrtf(squared) * 1.000001f; }

void visitSegment(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visitor,
                  void* context) {
  const LocalSegment segment = toLocal(mesh, from, to);
  if (isFar(segment)) return visit(mesh, from, to, reach, visitor, context);
  float limit = limitOf(reach * mesh.scale, segment.slack);
  const auto boundsOf = [&](const Node& node) { return segmentBounds(lanesOf(node), segment); };
  nearestFirst(mesh, limit, boundsOf, [&](int32_t leaf) {
    const Lanes frames = lanesOf(mesh.leaves[leaf]);
    const Feet feet = feetOn(frames, segment);
    unsigned mask = lessOrEqualMask(boundOf(inFrontAt(frames, feet, feet.middle), feet.halfLength), rootUp(limit));
    for (; mask != 0; mask &= mask - 1) {
      const int32_t slot = leaf * kWidth + __builtin_ctz(mask);
      if (mesh.triangles[slot].index >= 0) reach = visitor(context, slot, reach);
    }
    limit = limitOf(reach * mesh.scale, segment.slack);
  });
}

// Triangles are collected and computed in fours.
struct AxisSearch {
  const Mesh& mesh;
  Axis axis;
  SegmentAnswer& answer;
  int waiting;
  int32_t slot[4];
  double beyond;  // squared, of the nearest computed triangle
};

inline void keepNearer(AxisSearch& s, const Triangle* triangle, const SegmentCandidate& c) {
  if (c.squared < s.beyond) s.beyond = c.squared;
  SegmentAnswer& answer = s.answer;
  if (!(c.squared < answer.squared) &&
      !(c.squared == answer.squared && (answer.slot < 0 || triangle->index < s.mesh.triangles[answer.slot].index)))
    return;
  answer.squared = c.squared;
  answer.parameter = c.parameter;
  for (int k = 0; k < 3; ++k) answer.point[k] = c.point[k];
  answer.feature = c.feature;
  answer.slot = static_cast<int32_t>(triangle - s.mesh.triangles);
}

inline void tryWaiting(AxisSearch& s) {
  const Triangle* t[4];
  bool thin = false;
  for (int i = 0; i < 4; ++i) {
    t[i] = s.mesh.triangles + s.slot[i < s.waiting ? i : 0];
    thin |= isThin(t[i]);
  }
  SegmentCandidate c;
  if (!thin && s.waiting > 1) {
    const int lane = closestToAxisOfFour(t, &s.axis, &c);
    keepNearer(s, t[lane], c);
  } else {
    for (int i = 0; i < s.waiting; ++i) {
      closestToAxis(t[i], &s.axis, &c);
      keepNearer(s, t[i], c);
    }
  }
  s.waiting = 0;
}

inline double collectForAxis(void* context, int32_t slot, double reach) {
  AxisSearch& s = *static_cast<AxisSearch*>(context);
  const Triangle* all = s.mesh.triangles;
  const int32_t best = s.answer.slot;
  if (best >= 0 && s.answer.squared == 0.0 && all[slot].index > all[best].index) return reach;  // at most equally near
  s.slot[s.waiting++] = slot;
  if (s.waiting < 4) return reach;
  tryWaiting(s);
  return __builtin_sqrt(s.answer.squared);
}

// Compute triangles that may lie within reach exactly. Bounds are enough for the others.
inline void searchAxis(AxisSearch& s, const LocalSegment& segment, double reach, double far, int32_t hint) {
  const Mesh& mesh = s.mesh;
  const float error = 2.0f * static_cast<float>(segment.slack);
  float limit = limitOf((reach > far ? reach : far) * mesh.scale, segment.slack);
  float exactly = rootUp(limitOf(reach * mesh.scale, segment.slack));
  float clear = 3.4e38f;
  const int32_t hinted = hint >= 0 ? hint / kWidth : -1;
  bool isDone = false;  // the hinted leaf
  const auto atLeaf = [&](int32_t leaf) {
    if (isDone && leaf == hinted) return;
    const Lanes frames = lanesOf(mesh.leaves[leaf]);
    const Feet feet = feetOn(frames, segment);
    const InFront front = inFrontAt(frames, feet, feet.middle);
    const float least = (__builtin_sqrtf(smallest(front.squared)) + error) * 1.000001f;
    if (least < exactly) exactly = least;
    const float enough = exactly + kEnough * (least - exactly);
    if (enough * enough < limit) limit = enough * enough;
    V bounds = boundOf(front, feet.halfLength);
    unsigned mask = lessOrEqualMask(bounds, exactly);
    if (__builtin_popcount(mask) > kFewOfLeaf) {
      bounds = maximum(bounds, lineBound(frames, feet, error));
      mask = lessOrEqualMask(bounds, exactly);
    }
    if (__builtin_popcount(mask) > kManyOfLeaf) {
      bounds = maximum(bounds, betterBound(frames, feet, front, error));
      mask = lessOrEqualMask(bounds, exactly);
    }
    const float beyond = smallest(selectGreater(bounds, set(exactly), bounds, set(3.4e38f)));
    if (beyond < clear) clear = beyond;
    if (mask == 0) return;
    for (unsigned rest = mask; rest != 0; rest &= rest - 1) fetchTriangle(mesh, leaf * kWidth + __builtin_ctz(rest));
    float bound[kWidth];
    store(bound, bounds);
    int lane = __builtin_ctz(lessOrEqualMask(bounds, smallest(bounds)));  // the nearest one first
    for (; mask != 0; lane = __builtin_ctz(mask | 0x10000u)) {
      mask &= ~(1u << lane);
      const int32_t slot = leaf * kWidth + lane;
      if (!(bound[lane] <= exactly) || mesh.triangles[slot].index < 0) continue;
      const double now = collectForAxis(&s, slot, reach);
      if (!(now < reach)) continue;
      reach = now;
      const float closer = limitOf(reach * mesh.scale, segment.slack);
      if (closer < limit) limit = closer;
      const float most = rootUp(closer);
      if (most < exactly) exactly = most;
    }
  };
  if (hint >= 0) {
    atLeaf(hinted);
    isDone = true;
  }
  nearestFirst(
      mesh, limit, [&](const Node& node) { return segmentBounds(lanesOf(node), segment); }, atLeaf);
  if (s.waiting > 0) tryWaiting(s);
  if (s.answer.slot >= 0) return;
  const float most = __builtin_sqrtf(limit);
  const double keeps =
      (static_cast<double>(clear < most ? clear : most) * (1.0 - 1e-6) - 2.0 * segment.slack) / mesh.scale;
  const double looked = __builtin_sqrt(s.beyond) * (1.0 - 1e-12);
  const double free = keeps < looked ? keeps : looked;
  if (free > reach) s.answer.squared = free * free;
}

void closestToSegment(const Mesh& mesh, const double from[3], const double to[3], double reach, double far,
                      int32_t hint, SegmentAnswer* answer) {
  AxisSearch s = {mesh, axisBetween(from, to), *answer, 0, {}, kHuge};
  answer->squared = reach * reach < kHuge ? reach * reach : kHuge;
  answer->slot = -1;
  const LocalSegment segment = toLocal(mesh, from, to);
  if (!isFar(segment)) return searchAxis(s, segment, reach, far, hint);
  if (hint >= 0) s.slot[s.waiting++] = hint;
  visit(mesh, from, to, reach, &collectForAxis, &s);
  if (s.waiting > 0) tryWaiting(s);
}
