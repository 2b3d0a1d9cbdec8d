// The query loops for any machine.
#include "kernel.hpp"

namespace enamel::kernel {
namespace {

// Four floats: what compilers map to one register on most machines.
using Quad = float __attribute__((vector_size(16)));
using QuadMask = int32_t __attribute__((vector_size(16)));
constexpr int kQuads = kWidth / 4;

struct V {
  Quad q[kQuads];
};

template <typename Function>
inline V each(const Function& f) {
  V r;
  for (int i = 0; i < kQuads; ++i) r.q[i] = f(i);
  return r;
}
inline V load(const float* p) {
  V r;
  __builtin_memcpy(&r, p, sizeof(r));
  return r;
}
inline void store(float* p, const V& x) { __builtin_memcpy(p, &x, sizeof(x)); }
inline V set(float x) {
  return each([&](int) { return Quad{x, x, x, x}; });
}
inline V operator+(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] + y.q[i]; });
}
inline V operator-(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] - y.q[i]; });
}
inline V operator*(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] * y.q[i]; });
}
inline V operator/(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] / y.q[i]; });
}
inline V mad(const V& x, const V& y, const V& z) {
  return each([&](int i) { return x.q[i] * y.q[i] + z.q[i]; });
}
inline V root(const V& x) {
  return each([&](int i) {
    Quad r;
    for (int k = 0; k < 4; ++k) r[k] = __builtin_sqrtf(x.q[i][k]);
    return r;
  });
}
inline V inverseRoot(const V& x) { return set(1.0f) / root(x); }
inline V maximum(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] > y.q[i] ? x.q[i] : y.q[i]; });
}
inline V minimum(const V& x, const V& y) {
  return each([&](int i) { return x.q[i] < y.q[i] ? x.q[i] : y.q[i]; });
}
inline V selectGreater(const V& x, const V& y, const V& a, const V& b) {
  return each([&](int i) { return x.q[i] > y.q[i] ? a.q[i] : b.q[i]; });
}
inline float smallest(const V& a) {
  float lanes[kWidth];
  store(lanes, a);
  float least = lanes[0];
  for (int i = 1; i < kWidth; ++i) least = lanes[i] < least ? lanes[i] : least;
  return least;
}
inline unsigned lessOrEqualMask(const V& a, const V& b) {
  QuadMask bits = {0, 0, 0, 0};
  for (int i = 0; i < kQuads; ++i) bits |= (a.q[i] <= b.q[i]) & (QuadMask{1, 2, 4, 8} << (4 * i));
  return static_cast<unsigned>(bits[0] | bits[1] | bits[2] | bits[3]);
}
using Chosen = unsigned;
inline Chosen choose(unsigned mask) { return mask; }
inline void compress(const V& a, Chosen mask, float* p) {
  for (; mask != 0; mask &= mask - 1) *p++ = a.q[__builtin_ctz(mask) / 4][__builtin_ctz(mask) % 4];
}
inline void compress(const int32_t* x, Chosen mask, int32_t* p) {
  for (; mask != 0; mask &= mask - 1) *p++ = x[__builtin_ctz(mask)];
}
inline void compressNumbers(int32_t first, Chosen mask, int32_t* p) {
  for (; mask != 0; mask &= mask - 1) *p++ = first + __builtin_ctz(mask);
}

#include "exact.inl"

// The nearest of four; of equally near ones, that with the smallest index.
template <typename Found, typename Closest>
int nearestOfFour(const Triangle* const* t, const Closest& closest, Found* nearest) {
  int lane = 0;
  closest(t[0], nearest);
  for (int i = 1; i < 4; ++i) {
    Found c;
    closest(t[i], &c);
    if (!(c.squared < nearest->squared || (c.squared == nearest->squared && t[i]->index < t[lane]->index))) continue;
    *nearest = c;
    lane = i;
  }
  return lane;
}

// As in exact_four.inl.
inline int closestOfFour(const Triangle* const* t, const double* point, Candidate* nearest) {
  return nearestOfFour(
      t, [point](const Triangle* one, Candidate* c) { closestOnTriangle(one, point, c); }, nearest);
}

inline int closestToAxisOfFour(const Triangle* const* t, const Axis* axis, SegmentCandidate* nearest) {
  return nearestOfFour(
      t, [axis](const Triangle* one, SegmentCandidate* c) { closestToAxis(one, axis, c); }, nearest);
}

inline void solidAngles(const Triangle* triangles, const double* point, double* re, double* im) {
  for (int i = 0; i < kWidth; ++i) solidAngle(triangles + i, point, re + i, im + i);
}

#include "kernel_loops.inl"

}  // namespace

const Loops kBaselineLoops = {&closest,     &visit,    &visitSegment, &closestToSegment, &visitMinima, &clusterAngles,
                              &solidAngles, &seeCells, &boundCells,   &nearestOnCells,   &cutBrick};

}  // namespace enamel::kernel
