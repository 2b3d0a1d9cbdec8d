// Numbers for 16 triangles or boxes at once. The including file defines the vector V of 16 floats with:
// - load, store, set, + - * /, maximum, minimum, smallest, lessOrEqualMask, selectGreater;
// - root, and inverseRoot (to 2^-11);
// - mad: x * y + z, fused if the machine can;
// - compress and compressNumbers: move the lanes that choose() made of a mask to consecutive places, writing up to 16.
//
// Operators compile to the same instructions on every machine. Only mad may be fused.
#pragma once

// Error of the float distances, with margin. At most 20 roundings of 2^-24 enter, of numbers up to |q|_1 + 2 extent. A
// triangle that is represented by its edges alone is lower than 2^-20.
constexpr double kBoundError = 0x1p-19;
// Mesh sizes. Farther away float boxes cannot separate triangles, and doubles take over. The float error there is 64 *
// 2^-19, the size of a leaf of a mesh of 1e6 triangles.
constexpr double kFar = 64.0;
constexpr double kHuge = 1e300;

inline V operator-(V x) { return set(0.0f) - x; }
inline V absolute(V x) { return maximum(x, -x); }
inline V positive(V x) { return maximum(x, set(0.0f)); }
inline V between(V x, V low, V high) { return maximum(minimum(x, high), low); }
inline unsigned lessOrEqualMask(V x, float limit) { return lessOrEqualMask(x, set(limit)); }
inline void push(V x, unsigned mask, float* p) { compress(x, choose(mask), p); }

struct V3 {
  V at[3];
  V& operator[](int i) { return at[i]; }
  const V& operator[](int i) const { return at[i]; }
};

inline V plainDot(const V3& a, const V3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline V dot(const V3& a, const V3& b) { return mad(a[0], b[0], mad(a[1], b[1], a[2] * b[2])); }
inline V dotPlus(const V3& a, const V3& b, V c) { return mad(a[0], b[0], mad(a[1], b[1], mad(a[2], b[2], c))); }
inline V squaredLength(const V3& a) { return mad(a[2], a[2], mad(a[1], a[1], a[0] * a[0])); }
inline V3 along(const V3& start, V t, const V3& direction) {
  return {{mad(direction[0], t, start[0]), mad(direction[1], t, start[1]), mad(direction[2], t, start[2])}};
}
inline V3 setAll(const double* p) {
  return {{set(static_cast<float>(p[0])), set(static_cast<float>(p[1])), set(static_cast<float>(p[2]))}};
}

// 16 frames of the triangles of a leaf or of the boxes of a node. Both begin with three axes and an offset.
struct Lanes {
  const float (*rows)[kWidth];
  V row(int i) const { return load(rows[i]); }
  V3 axis(int i) const { return {{row(3 * i), row(3 * i + 1), row(3 * i + 2)}}; }
  V3 rows3(int i) const { return {{row(i), row(i + 1), row(i + 2)}}; }
  V half(int i) const { return row(12 + i); }  // of a box
  V3 place(const V3& q) const {
    return {{dotPlus(axis(0), q, row(kOffset)), dotPlus(axis(1), q, row(kOffset + 1)),
             dotPlus(axis(2), q, row(kOffset + 2))}};
  }
  V3 turn(const V3& d) const { return {{dot(axis(0), d), dot(axis(1), d), dot(axis(2), d)}}; }
};

inline Lanes lanesOf(const Leaf& leaf) { return {leaf.row}; }
inline Lanes lanesOf(const Node& node) { return {node.row}; }

// Squared distances of triangles from points f in their frames. Over the triangle it is the distance to the plane;
// elsewhere the distance to the nearest edge. The latter has three parts: along the edge past its ends, across it in
// the plane, and the height over the plane. `from`: the offsets from the nearest points of the triangles.
__attribute__((always_inline)) inline V frameDistances(const Lanes& frames, const V3& f, V3* from = nullptr) {
  const V zero = set(0.0f), u = f[0], v = f[1], h = f[2];
  const V3 length = frames.rows3(kLength);
  const V c1 = frames.row(kCosine), s1 = frames.row(kSine), c2 = frames.row(kCosine + 1), s2 = frames.row(kSine + 1);
  const V inside = frames.row(kInside);
  const V beyond = u - length[0];
  // Across: positive outside. Along: from the start of the edge.
  const V across0 = -v;
  const V across1 = s1 * beyond - c1 * v, along1 = mad(c1, beyond, s1 * v);
  const V across2 = c2 * v - s2 * u, along2 = mad(c2, u, s2 * v);
  const V end0 = u - between(u, zero, length[0]);
  const V end1 = along1 - between(along1, zero, length[1]);
  const V end2 = along2 - between(along2, zero, length[2]);
  const V edge0 = mad(v, v, end0 * end0);
  const V edge1 = mad(across1, across1, end1 * end1);
  const V edge2 = mad(across2, across2, end2 * end2);
  const V edges = minimum(minimum(edge0, edge1), edge2);
  const V out = maximum(maximum(across0, across1), across2);
  if (from != nullptr) {
    const V first[2] = {end0, v};
    const V second[2] = {mad(end1, c1, across1 * s1), end1 * s1 - across1 * c1};
    const V third[2] = {end2 * c2 - across2 * s2, mad(end2, s2, across2 * c2)};
    for (int i = 0; i < 2; ++i) {
      const V of01 = selectGreater(edge0, edge1, second[i], first[i]);
      const V ofEdges = selectGreater(minimum(edge0, edge1), edge2, third[i], of01);
      (*from)[i] = selectGreater(out, inside, ofEdges, zero);
    }
    (*from)[2] = h;
  }
  return mad(h, h, selectGreater(out, inside, edges, zero));
}

inline V triangleDistances(const Lanes& frames, const V3& q) { return frameDistances(frames, frames.place(q)); }

// Distances of points from the centres of boxes, along their axes.
inline V3 fromMiddles(const Lanes& boxes, const V3& q) {
  const V3 f = boxes.place(q);
  return {{absolute(f[0]), absolute(f[1]), absolute(f[2])}};
}

// Distances of points outside the faces of the boxes; 0 inside.
inline V3 beyondBoxes(const Lanes& boxes, const V3& f) {
  return {{positive(f[0] - boxes.half(0)), positive(f[1] - boxes.half(1)), positive(f[2] - boxes.half(2))}};
}

// Round up to float: a double, and the square of a distance whose float error is `slack`.
inline float upward(double value) { return value < 3e38 ? static_cast<float>(value) * 1.000001f + 1e-37f : 3.4e38f; }

inline float limitOf(double distance, double slack) {
  const double d = distance + slack;
  return upward(d * d);
}

inline bool isFar(const double* q) {
  return !(q[0] < kFar && q[0] > -kFar && q[1] < kFar && q[1] > -kFar && q[2] < kFar && q[2] > -kFar);
}

inline double slackOf(const Mesh& mesh, const double* q) {
  return kBoundError * (absolute(q[0]) + absolute(q[1]) + absolute(q[2]) + 2.0 * mesh.extent);
}

inline void toLocal(const Mesh& mesh, const double* p, double* q) {
  for (int k = 0; k < 3; ++k) q[k] = (p[k] - mesh.centre[k]) * mesh.scale;
}
