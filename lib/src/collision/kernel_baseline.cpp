// The query loops for any machine: plain arrays that the compiler may vectorise.
#include "kernel.hpp"

namespace enamel::kernel {
namespace {

struct V {
  float v[kWidth];
};

template <typename Function>
inline V each(const Function& f) {
  V r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = f(i);
  return r;
}
inline V load(const float* p) {
  return each([&](int i) { return p[i]; });
}
inline void store(float* p, const V& x) {
  for (int i = 0; i < kWidth; ++i) p[i] = x.v[i];
}
inline V set(float x) {
  return each([&](int) { return x; });
}
inline V operator+(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] + y.v[i]; });
}
inline V operator-(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] - y.v[i]; });
}
inline V operator*(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] * y.v[i]; });
}
inline V operator/(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] / y.v[i]; });
}
inline V mad(const V& x, const V& y, const V& z) {
  return each([&](int i) { return x.v[i] * y.v[i] + z.v[i]; });
}
inline V root(const V& x) {
  return each([&](int i) { return __builtin_sqrtf(x.v[i]); });
}
inline V inverseRoot(const V& x) {
  return each([&](int i) { return 1.0f / __builtin_sqrtf(x.v[i]); });
}
inline V maximum(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] > y.v[i] ? x.v[i] : y.v[i]; });
}
inline V minimum(const V& x, const V& y) {
  return each([&](int i) { return x.v[i] < y.v[i] ? x.v[i] : y.v[i]; });
}
inline V selectGreater(const V& x, const V& y, const V& a, const V& b) {
  return each([&](int i) { return x.v[i] > y.v[i] ? a.v[i] : b.v[i]; });
}
inline float smallest(const V& a) {
  float least = a.v[0];
  for (int i = 1; i < kWidth; ++i) least = a.v[i] < least ? a.v[i] : least;
  return least;
}
inline unsigned lessOrEqualMask(const V& a, const V& b) {
  unsigned mask = 0;
  for (int i = 0; i < kWidth; ++i) mask |= static_cast<unsigned>(a.v[i] <= b.v[i]) << i;
  return mask;
}
using Chosen = unsigned;
inline Chosen choose(unsigned mask) { return mask; }
inline void compress(const V& a, Chosen mask, float* p) {
  for (; mask != 0; mask &= mask - 1) *p++ = a.v[__builtin_ctz(mask)];
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

#include "kernel_loops.inl"

}  // namespace

const Loops kBaselineLoops = {&closest,     &visit,      &visitSegment,   &closestToSegment,
                              &visitMinima, &boundCells, &nearestOnCells, &cutBrick};

}  // namespace enamel::kernel
