// The solid angles of clusters of triangles by their dipole and first moments, 16 at once. Source: Barill et al., "Fast
// winding numbers for soups and clouds", 2018.
#pragma once

#include "lanes.inl"

unsigned clusterAngles(const MomentRows& moments, const double point[3], float accept, float* angles) {
  const auto row = [&](int i) { return load(moments.row[i]); };
  const V two = set(2.0f);
  V3 way, normal;
  for (int i = 0; i < 3; ++i) {
    way[i] = row(kCentre + i) - set(static_cast<float>(point[i]));
    normal[i] = row(kNormal + i);
  }
  const V squared = plainDot(way, way), radius = row(kRadius), reach = set(accept) * radius;
  const V perLength = set(1.0f) / root(maximum(squared, set(1e-30f))), perSquared = perLength * perLength;
  const V xx = row(kSpread), yy = row(kSpread + 1), zz = row(kSpread + 2);
  const V mixed =
      way[0] * way[1] * row(kSpread + 3) + way[0] * way[2] * row(kSpread + 4) + way[1] * way[2] * row(kSpread + 5);
  const V across = way[0] * way[0] * xx + way[1] * way[1] * yy + way[2] * way[2] * zz + two * mixed;
  const V along = plainDot(way, normal) + (xx + yy + zz);
  store(angles, (along - set(3.0f) * across * perSquared) * perSquared * perLength);
  return ~lessOrEqualMask(squared, reach * reach) & 0xffffu;
}
