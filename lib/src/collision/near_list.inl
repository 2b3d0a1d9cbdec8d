// Lists of near triangles, for a tool that moves little from query to query. A list holds every triangle that can be
// nearest within a ball around the predicted place. So most queries skip the hierarchy. The interface is forget(),
// listAt(), listedWithin() and workAhead().
#pragma once

#include "descent.inl"

// The numbers below were measured along the haptic path of `enamel bench --filter collision`: closestPoint() with a
// cache, AVX2. Each time is the least of each call in 12 runs of each of 22 variants in turn. Ratios compare the time
// with another value to that of the median variant, on 100 k and 1 M triangles. 10 % are noise.

// A list is begun if the tool, at its present motion, leaves the last one within this many queries. With 1 the p99.9 is
// 1.5 and 1.9 times as long, as lists are not ready in time. 6 makes no difference.
constexpr double kAhead = 3.0;
// The ball is at least this many queries wide. With 1.5 the median is 1.25 and 1.2 times as long; with 6 the p99 is 1.3
// and 0.85 times as long.
constexpr double kLeastReach = 3.0;
// The ball is centred this many radii ahead of the place where it is first needed. With 0.5 the p99 is 1.1 times as
// long on 100 k, and the p99.9 1.2 times on 1 M. 0.75 makes no difference.
constexpr double kLead = 0.9;
// Cost of a node and of a leaf, and the largest cost per query for the next list, unless it is needed at once. With 8
// the median is 1.5 times as long on 100 k, and on 1 M the p99 1.3 and the p99.9 1.6 times. With 32, on 100 k, the p99
// is 1.3 and the median 0.9 times as long.
enum { kNodeWork = 2, kLeafWork = 3, kWorkPerQuery = 16 };
// A list that cost less was too small; one that cost more was too large. Two thirds of both make no difference. With
// one and a half times both, the p99 is 1.1 times as long on 100 k.
enum { kLeastWork = 18, kMostWork = 25 };
// Factors for the size of the next list: larger, smaller, and smaller after an abandoned list. Last the radius of the
// first one in mesh sizes. Not measured: they set how soon the size is right. kLeastWork and kMostWork set the size.
constexpr double kLarger = 1.08, kSmaller = 0.92, kMuchSmaller = 0.6, kFirstRadius = 1.0 / 512.0;
// A list that costs more is abandoned. With 40 the p99 is 0.9 times as long on 1 M. 100 makes no difference.
constexpr int kNoList = 64;
// After an abandoned list, none is begun for kPause queries, doubled each time up to kLongPause. This limits the cost
// of useless lists far from the surface. 8 and 128 make no difference along the path.
enum { kPause = 32, kLongPause = 1024 };

inline void drop(NearLists& lists) { lists.firstNode = lists.nodes = lists.firstLeaf = lists.leaves = 0; }

// Forget everything: another mesh, or an edit.
inline void forget(NearLists& lists) {
  lists.list[0].radius = lists.list[1].radius = -1.0;
  drop(lists);
  lists.rest = 0;
  lists.pause = kPause;
  lists.margin = kFirstRadius;
}

inline bool isOpen(const NearLists& lists) { return lists.firstNode < lists.nodes || lists.firstLeaf < lists.leaves; }

inline bool holds(const NearList& list, const double* q) {
  return list.radius >= 0.0 && squaredDistance(q, list.origin) <= list.radius * list.radius;
}

inline V3 fromOrigin(const NearList& list, const double* q) {
  double e[3];
  subtract(q, list.origin, e);
  return setAll(e);
}

// Lower bounds of the distances of 16 entries from the origin plus e.
inline V boundsOf(const NearList& list, int first, const V3& e) {
  V bound = load(list.height + first);
  for (int k = 0; k < 3; ++k) bound = mad(load(list.normal[k] + first), e[k], bound);
  return bound;
}

// Write the slots of the triangles that may lie within `most` of q, and return their number. Room: kListed + kSpare.
inline int listedWithin(const NearList& list, const double* q, float most, int32_t* slot) {
  const V3 e = fromOrigin(list, q);
  int count = 0;
  for (int first = 0; first < list.count; first += kWidth) {
    const unsigned mask = lessOrEqualMask(boundsOf(list, first, e), most);
    compress(list.slot + first, choose(mask), slot + count);
    count += __builtin_popcount(mask);
  }
  return count;
}

// Each triangle lies behind a plane across the line to its nearest point. From a point at offset e the distance is at
// least height + normal.e. The height is taken over the corners, so this holds for any normal of length up to 1. A
// point close to the nearest one therefore suffices.
struct Planes {
  V3 normal;
  V height;
};

inline Planes planesBefore(const Lanes& frames, const V3& at) {
  const V zero = set(0.0f);
  const V c1 = frames.row(kCosine), s1 = frames.row(kSine), c2 = frames.row(kCosine + 1), s2 = frames.row(kSine + 1);
  const V length0 = frames.row(kLength), length2 = frames.row(kLength + 2);
  const V3 q = frames.place(at);
  // Project into the triangle: over one edge, then over the other, then into its bounding box.
  const V over1 = positive(s1 * (q[0] - length0) - c1 * q[1]);
  const V u1 = q[0] - s1 * over1, v1 = mad(c1, over1, q[1]);
  const V over2 = positive(c2 * v1 - s2 * u1);
  const V top = length2 * s2;
  V3 n = {{q[0] - between(mad(s2, over2, u1), zero, length0), q[1] - between(v1 - c2 * over2, zero, top), q[2]}};
  const V inverse = set(1.0f) / root(maximum(dot(n, n), set(1e-30f)));
  for (int i = 0; i < 3; ++i) n[i] = n[i] * inverse;
  const V corners = maximum(maximum(zero, n[0] * length0), mad(n[1], top, n[0] * (length2 * c2)));
  Planes planes;
  planes.height = dot(n, q) - corners;
  for (int i = 0; i < 3; ++i) planes.normal[i] = dot({{frames.row(i), frames.row(3 + i), frames.row(6 + i)}}, n);
  return planes;
}

// Which convex bodies can be nearest within r of the origin o. Let x be a point of the mesh, D its distance from o and
// m the direction. At o + e, x is at most D + m.e + r^2 / 2D away. A body behind a plane of normal n and height f is at
// least f + n.e away. So only bodies with f - D <= r |m - n| + r^2 / 2D matter, besides the plain f - D <= 2 r.
struct Reach {
  V plain;   // D + 2 r
  V square;  // its square
  V start;   // D + r^2 / 2D
  V turn;    // r^2
  V3 m;
};

inline Reach reachOf(const double* origin, const double* x, double r, double slack) {
  double m[3];
  subtract(origin, x, m);
  const double D = __builtin_sqrt(dot(m, m));
  const double inverse = D > slack ? 1.0 / D : 0.0;
  for (double& component : m) component *= inverse;
  Reach reach;
  reach.plain = set(upward(D + 2.0 * (r + slack)));
  reach.square = set(limitOf(D + 2.0 * r, 2.0 * slack));
  reach.start = set(D > slack ? upward(D + 0.5 * r * r * inverse + 2.0 * slack) : 3e38f);
  reach.turn = set(upward(1.0001 * r * r));
  reach.m = setAll(m);
  return reach;
}

inline unsigned planesWithin(const Reach& reach, const Planes& planes) {
  const V3 &m = reach.m, &n = planes.normal;
  const V squared = squaredLength({{m[0] - n[0], m[1] - n[1], m[2] - n[2]}});
  const V more = positive(planes.height - reach.start);
  return lessOrEqualMask(planes.height, reach.plain) & lessOrEqualMask(more * more, reach.turn * squared);
}

// The plane of a box is at its nearest point.
inline unsigned boxesWithin(const Reach& reach, const Lanes& boxes, const V3& q) {
  V squared = set(0.0f), ahead = squared;
  for (int i = 0; i < 3; ++i) {
    const V3 axis = boxes.axis(i);
    const V at = dotPlus(axis, q, boxes.row(kOffset + i));
    const V d = at - between(at, -boxes.half(i), boxes.half(i));
    squared = mad(d, d, squared);
    ahead = mad(d, dot(axis, reach.m), ahead);
  }
  const V f = root(squared), more = positive(f - reach.start);
  // f |m - n|^2 = 2 (f - m.d), rounded up
  const V turn = f * set(2.00002f) - (ahead + ahead);
  return lessOrEqualMask(squared, reach.square) & lessOrEqualMask(more * more * f, reach.turn * turn);
}

// Move the witness to the triangle that seems nearest to the origin, if that is nearer.
inline void improveWitness(const Mesh& mesh, const NearList& list, const double* origin, double* witness) {
  const V3 e = fromOrigin(list, origin);
  float least = 3.4e38f;
  int32_t slot = -1;
  for (int first = 0; first < list.count; first += kWidth) {
    const V bound = boundsOf(list, first, e);
    const float here = smallest(bound);
    if (!(here < least)) continue;
    least = here;
    slot = list.slot[first + __builtin_ctz(lessOrEqualMask(bound, here))];
  }
  if (slot < 0) return;
  double p[3], x[3];
  for (int k = 0; k < 3; ++k) p[k] = origin[k] / mesh.scale + mesh.centre[k];
  Candidate c;
  closestOnTriangle(mesh.triangles + slot, p, &c);
  toLocal(mesh, c.point, x);
  if (!(squaredDistance(x, origin) < squaredDistance(witness, origin))) return;
  for (int k = 0; k < 3; ++k) witness[k] = x[k];
}

// Begin a list for a tool that moves by `motion` per query, had the answer `surface`, and needs the list from `start`.
inline void begin(const Mesh& mesh, const double* start, const double* motion, const double* surface,
                  NearLists& lists) {
  NearList& list = lists.list[1 - lists.active];
  const NearList& last = lists.list[lists.active];
  const double step = __builtin_sqrt(dot(motion, motion));
  const double r = lists.margin > kLeastReach * step ? lists.margin : kLeastReach * step;
  const double lead = step > 1e-3 * r ? kLead * r / step : 0.0;
  for (int k = 0; k < 3; ++k) {
    list.origin[k] = start[k] + lead * motion[k];
    lists.witness[k] = surface[k];
  }
  if (last.radius >= 0.0) improveWitness(mesh, last, list.origin, lists.witness);
  list.radius = -1.0;
  list.count = 0;
  list.slack = static_cast<float>(slackOf(mesh, list.origin)) * 1.000001f;
  lists.ball = r;
  lists.work = 0;
  drop(lists);
  lists.node[0] = mesh.root;
  lists.nodes = 1;
}

// After a jump of the tool the ball may be larger than the margin. This must not enlarge later balls.
inline void lowerMargin(NearLists& lists, double margin) {
  if (margin < lists.margin) lists.margin = margin;
}

inline void giveUp(NearLists& lists) {
  drop(lists);
  lowerMargin(lists, kMuchSmaller * lists.ball);
  lists.rest = lists.pause;
  if (lists.pause < kLongPause) lists.pause *= 2;
}

// Extend the list until it is complete or the work is used up. Nodes come first, level by level, so that prefetching
// has time; then the leaves.
inline void extend(const Mesh& mesh, int work, NearLists& lists) {
  NearList& list = lists.list[1 - lists.active];
  const Reach reach = reachOf(list.origin, lists.witness, lists.ball, slackOf(mesh, list.origin));
  const V3 q = setAll(list.origin);
  int first = lists.firstNode, nodes = lists.nodes, leaves = lists.leaves, count = list.count, left = work;
  for (; first < nodes && left > 0; left -= kNodeWork) {
    const Node& node = mesh.nodes[lists.node[first++]];
    const unsigned near = node.lanes & boxesWithin(reach, lanesOf(node), q);
    const unsigned nearLeaves = near & node.leaves, nearNodes = near & ~node.leaves;
    const int leavesBefore = leaves, nodesBefore = nodes;
    leaves += __builtin_popcount(nearLeaves);
    nodes += __builtin_popcount(nearNodes);
    if (leaves > NearLists::kLeaves || nodes > NearLists::kNodes) return giveUp(lists);
    compress(node.child, choose(nearLeaves), lists.leaf + leavesBefore);
    compress(node.child, choose(nearNodes), lists.node + nodesBefore);
    for (int i = leavesBefore; i < leaves; ++i) fetchChild(mesh, lists.leaf[i]);
    for (int i = nodesBefore; i < nodes; ++i) fetchChild(mesh, lists.node[i]);
  }
  lists.firstNode = first;
  lists.nodes = nodes;
  for (first = lists.firstLeaf; first < leaves && left > 0; left -= kLeafWork) {
    const int32_t leaf = ~lists.leaf[first++];
    const Planes planes = planesBefore(lanesOf(mesh.leaves[leaf]), q);
    const unsigned near = planesWithin(reach, planes);
    const int before = count;
    count += __builtin_popcount(near);
    if (count > kListed) return giveUp(lists);
    const Chosen lanes = choose(near);
    for (int k = 0; k < 3; ++k) compress(planes.normal[k], lanes, list.normal[k] + before);
    compress(planes.height, lanes, list.height + before);
    compressNumbers(leaf * kWidth, lanes, list.slot + before);
    for (int i = before; i < count; ++i) fetchTriangle(mesh, list.slot[i]);
  }
  lists.firstLeaf = first;
  lists.leaves = leaves;
  list.count = count;
  lists.work += work - left;
  if (isOpen(lists)) {
    if (lists.work > kNoList) giveUp(lists);
    return;
  }
  for (int k = 0; k < 3; ++k) store(list.normal[k] + count, set(0.0f));
  store(list.height + count, set(3e38f));
  list.radius = lists.ball * (1.0 - 1e-6);
  lists.pause = kPause;
  if (lists.work < kLeastWork) lists.margin = kLarger * lists.ball;
  if (lists.work > kMostWork) lowerMargin(lists, kSmaller * lists.ball);
}

// Return the list that holds at q, or null. Completes the list in progress if it holds there.
inline const NearList* listAt(const Mesh& mesh, const double* q, NearLists& lists) {
  if (!holds(lists.list[lists.active], q)) {
    const NearList& next = lists.list[1 - lists.active];
    if (isOpen(lists) && squaredDistance(q, next.origin) <= lists.ball * lists.ball * (1.0 - 4e-6))
      extend(mesh, kNoList, lists);
    if (!holds(next, q)) return nullptr;
    lists.active = 1 - lists.active;
  }
  return &lists.list[lists.active];
}

// Build the next list before it is needed, spread over several queries, so that none of them takes long.
inline void workAhead(const Mesh& mesh, const double* q, const double* motion, const double* surface,
                      NearLists& lists) {
  if (!isOpen(lists)) {
    if (lists.rest > 0) {
      --lists.rest;
      return;
    }
    double start[3];
    for (int k = 0; k < 3; ++k) start[k] = q[k] + kAhead * motion[k];
    if (isFar(start)) return;  // a jump, not motion of the tool
    if (holds(lists.list[0], start) || holds(lists.list[1], start)) return;
    begin(mesh, start, motion, surface, lists);
  }
  extend(mesh, kWorkPerQuery, lists);
}
