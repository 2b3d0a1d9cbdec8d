// Cuts the samples of a brick, 16 at a time. No product is fused, so that every SIMD level finds the same bits.
#pragma once

#include "lanes.inl"

constexpr int kSliceSamples = kBrickEdge * kBrickEdge;

// Share of a cell's volume below a plane at this distance from its centre.
inline V shareBelow(V value) { return between(set(0.5f) - value, set(0.0f), set(1.0f)); }

bool cutBrick(float* samples, const float away[3][kBrickEdge], int first, int last, const BurAt& bur, BeforeCut before,
              void* context, CutSamples* cut) {
  float x[kSliceSamples], y[kSliceSamples];
  for (int row = 0; row < kBrickEdge; ++row)
    for (int i = 0; i < kBrickEdge; ++i) {
      x[row * kBrickEdge + i] = away[0][i];
      y[row * kBrickEdge + i] = away[1][row];
    }
  const V zero = set(0.0f), reach = set(bur.reach), innerSquared = set(bur.inner * bur.inner);
  bool isCut = false;
  cut->count = 0;
  cut->isTurned = false;
  for (int slice = first; slice <= last; ++slice) {
    const V dz = set(away[2][slice]);
    for (int start = 0; start < kSliceSamples; start += kWidth) {
      const int at =
          start + kWidth <= kSliceSamples ? start : kSliceSamples - kWidth;  // overlaps: a second cut changes nothing
      V dx = load(x + at), dy = load(y + at), squared;
      if (bur.perLength == 0.0f) {
        squared = dx * dx + dy * dy + dz * dz;
      } else {
        const V sx = set(bur.span[0]), sy = set(bur.span[1]), sz = set(bur.span[2]);
        const V t = between((dx * sx + dy * sy + dz * sz) * set(bur.perLength), zero, set(1.0f));
        dx = dx - t * sx;
        dy = dy - t * sy;
        const V rest = dz - t * sz;
        squared = dx * dx + dy * dy + rest * rest;
      }
      if (lessOrEqualMask(squared, bur.most) == 0) continue;
      float* const place = samples + slice * kSliceSamples + at;
      const V old = load(place), room = positive(reach - old);
      // Is reach - distance above any sample, except those at the end of the band?
      if ((~lessOrEqualMask(room * room, maximum(squared, innerSquared)) & 0xffffu) == 0) continue;
      if (!isCut) before(context);
      isCut = true;
      const V now = minimum(maximum(old, reach - root(squared)), set(bur.band));
      store(place, now);
      cut->isTurned = cut->isTurned || (~lessOrEqualMask(zero, old) & lessOrEqualMask(zero, now) & 0xffffu) != 0;
      const V taken = shareBelow(old) - shareBelow(now);
      const unsigned lost = ~lessOrEqualMask(taken, zero) & 0xffffu;
      if (lost == 0) continue;
      push(taken, lost, cut->taken + cut->count);
      compressNumbers(slice * kSliceSamples + at, choose(lost), cut->index + cut->count);
      cut->count += __builtin_popcount(lost);
    }
  }
  return isCut;
}
