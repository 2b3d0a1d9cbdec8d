// Triangles that may hold a local minimum of the distance from a point, selected by the cones of their normals.
#pragma once

#include "segment_search.inl"

constexpr int kMostWaiting = 64;

// Children within the limit whose cones permit a minimum. The line from a point of the box to the query point has a
// bounded angle to the third axis. The sides of the box give the bound.
inline unsigned childrenWithMinima(const Node& node, const V3& q, V limit, V slack) {
  const Lanes boxes = lanesOf(node);
  const V3 f = fromMiddles(boxes, q);
  const V u = positive(f[0] - boxes.half(0) - slack), v = positive(f[1] - boxes.half(1) - slack);
  const V h = f[2] + boxes.half(2) + slack, cone = load(node.cone);
  return lessOrEqualMask(squaredLength(beyondBoxes(boxes, f)), limit) &
         lessOrEqualMask(mad(u, u, v * v) * cone, h * h * (set(1.0f) - cone));
}

void visitMinima(const Mesh& mesh, const double point[3], double reach, Visit visitor, void* context) {
  double local[3];
  toLocal(mesh, point, local);
  if (isFar(local)) return visit(mesh, point, point, reach, visitor, context);
  const double error = slackOf(mesh, local);
  const V3 q = setAll(local);
  const V limit = set(limitOf(reach * mesh.scale, error));
  const V slack = set(2.0f * (static_cast<float>(error) * 1.000001f));
  int32_t slots[kMostWaiting + kWidth];
  int count = 0;
  const auto visitAll = [&] {
    for (int i = 0; i < count; ++i)
      if (mesh.triangles[slots[i]].index >= 0) visitor(context, slots[i], reach);
    count = 0;
  };
  const auto nearOf = [&](const Node& node) { return childrenWithMinima(node, q, limit, slack); };
  anyOrder(mesh, nearOf, [&](int32_t number) {
    const Leaf& leaf = mesh.leaves[number];
    const V3 f = lanesOf(leaf).place(q);
    const V d = frameDistances(lanesOf(leaf), f), height = f[2];
    const V high = absolute(height) + slack;  // plus the possible error of both
    const V front = load(leaf.front), back = load(leaf.back);
    const V either = selectGreater(-height, slack, back, minimum(front, back));
    const V least = selectGreater(height, slack, front, either) * d;
    const unsigned near = lessOrEqualMask(d, limit) & lessOrEqualMask(least, high * high);
    compressNumbers(number * kWidth, choose(near), slots + count);
    for (int i = __builtin_popcount(near); i > 0; --i) fetchTriangle(mesh, slots[count++]);
    if (count > kMostWaiting - kWidth) visitAll();
  });
  visitAll();
}
