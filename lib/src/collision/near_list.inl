// The lists of near triangles: for a tool that moves little from query to query, every triangle that can be nearest
// within a ball about where it is going, so that most queries go through no hierarchy. Four functions are the
// interface: forget(), listAt(), listedWithin() and workAhead().
#pragma once

#include "descent.inl"

// The numbers below were measured with closestPoint() and a cache along the haptic path of
// `enamel bench --filter collision`, AVX2, the least time of each call in 12 runs of each of 22 variants in turns.
// Ratios are of another value's time to the middle one of all variants, on 100 k and 1 M triangles; 10 % are noise.

// A list is begun when the tool, going on as it does, leaves the last one within this many queries. 1: p99.9 1.5
// and 1.9 times, as lists are not ready in time; 6: no difference.
constexpr double kAhead = 3.0;
// Its ball is at least so many queries wide. 1.5: median 1.25 and 1.2 times; 6: p99 1.3 and 0.85 times.
constexpr double kLeastReach = 3.0;
// It lies so many radii ahead of the place where it is needed first. 0.5: p99 1.1 times on 100 k, p99.9 1.2 on 1 M;
// 0.75: no difference.
constexpr double kLead = 0.9;
// What a node and a leaf cost, and what one query spends on the next list at most, unless it needs that at once.
// 8: median 1.5 times on 100 k, p99 1.3 and p99.9 1.6 times on 1 M; 32: p99 1.3 times on 100 k, median 0.9.
enum { kNodeWork = 2, kLeafWork = 3, kWorkPerQuery = 16 };
// A list that took less was too small, one that took more too large. Two thirds of both: no difference; one and a
// half times: p99 1.1 times on 100 k.
enum { kLeastWork = 18, kMostWork = 25 };
// By how much the next one is then larger or smaller, how much smaller after one that was given up, and the first one's
// radius in mesh sizes. Not measured: they only say how soon the size is right, which kLeastWork and kMostWork decide.
constexpr double kLarger = 1.08, kSmaller = 0.92, kMuchSmaller = 0.6, kFirstRadius = 1.0 / 512.0;
// Beyond this work a list is given up. 40: p99 0.9 times on 1 M; 100: no difference.
constexpr int kNoList = 64;
// No other is begun then for kPause queries, twice as many each time up to kLongPause: what making lists in vain may
// cost far from the surface. 8 and 128: no difference along the path.
enum { kPause = 32, kLongPause = 1024 };

inline void drop(NearLists& lists) { lists.firstNode = lists.nodes = lists.firstLeaf = lists.leaves = 0; }

// Nothing is known: another mesh, or an edit.
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

// Writes the slots of those that may lie within `most` of q, answers how many; room for kListed + kSpare.
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

// Each triangle lies behind a plane across the line to its nearest point; from a point e farther on it is no nearer
// than height + normal.e. That holds for any normal not longer than 1, as the height is taken over the corners: a point
// close to the nearest one does.
struct Planes {
  V3 normal;
  V height;
};

inline Planes planesBefore(const Lanes& frames, const V3& at) {
  const V zero = set(0.0f);
  const V c1 = frames.row(kCosine), s1 = frames.row(kSine), c2 = frames.row(kCosine + 1), s2 = frames.row(kSine + 1);
  const V length0 = frames.row(kLength), length2 = frames.row(kLength + 2);
  const V3 q = frames.place(at);
  // Into the triangle: back over one edge, then over the other, then into its box.
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
// m its direction: at o + e it is at most D + m.e + r^2 / 2D away, and a body behind a plane of normal n and height f
// is at least f + n.e away. Hence only bodies with f - D <= r |m - n| + r^2 / 2D matter, besides the plain
// f - D <= 2 r.
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

// The plane of a box is as far away as its nearest point.
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

// The witness moves to the triangle that seems nearest to the origin, if that is nearer.
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

// For a tool that goes on by `motion` a query, was answered `surface`, and needs the list from `start` on.
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

// The ball may be larger than the margin where the tool has jumped: that is no reason for larger ones from now on.
inline void lowerMargin(NearLists& lists, double margin) {
  if (margin < lists.margin) lists.margin = margin;
}

inline void giveUp(NearLists& lists) {
  drop(lists);
  lowerMargin(lists, kMuchSmaller * lists.ball);
  lists.rest = lists.pause;
  if (lists.pause < kLongPause) lists.pause *= 2;
}

// Goes on with the list until it is complete or the work is done: the nodes first, level by level, so that memory has
// time to bring them, then the leaves.
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

// The list that answers at q, made complete if it is the one being made; null: none does.
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

// A list is made before it is needed, over some queries, so that none of them takes long.
inline void workAhead(const Mesh& mesh, const double* q, const double* motion, const double* surface,
                      NearLists& lists) {
  if (!isOpen(lists)) {
    if (lists.rest > 0) {
      --lists.rest;
      return;
    }
    double start[3];
    for (int k = 0; k < 3; ++k) start[k] = q[k] + kAhead * motion[k];
    if (isFar(start)) return;  // a jump, not the tool's motion
    if (holds(lists.list[0], start) || holds(lists.list[1], start)) return;
    begin(mesh, start, motion, surface, lists);
  }
  extend(mesh, kWorkPerQuery, lists);
}
