#include "minima.hpp"

#include <algorithm>
#include <cmath>

namespace enamel::kernel {
namespace {

#include "exact.inl"

constexpr int kMostFanSteps = 64;

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

void keepMinimum(const Minimum& minimum, Minima& minima) {
  int place = minima.count;
  while (place > 0 && minimum.distance < minima.all[place - 1].distance) --place;
  int first = place;
  for (; first > 0 && minimum.distance == minima.all[first - 1].distance; --first) {
    const Minimum& known = minima.all[first - 1];
    if (known.point != minimum.point) continue;  // otherwise the same corner or edge, seen from another triangle
    if (known.triangle <= minimum.triangle) return;
    std::copy(minima.all.begin() + first, minima.all.begin() + minima.count, minima.all.begin() + first - 1);
    --minima.count;
    --place;
  }
  while (place > first && minimum.triangle < minima.all[place - 1].triangle) --place;
  if (place == Minima::kMost) return;
  minima.count = std::min(minima.count + 1, Minima::kMost);
  for (int i = minima.count - 1; i > place; --i) minima.all[i] = minima.all[i - 1];
  minima.all[place] = minimum;
}

// The minima around a point, and the nearest point of all.
struct MinimaSearch {
  const MeshData* data;
  Vec3 p;
  Answer found;
  Minima* minima;
};

bool hasNearer(const MinimaSearch& s, const Triangle& triangle, double squared) {
  Candidate c;
  closestOnTriangle(&triangle, s.p.data(), &c);
  return c.squared < squared * (1.0 - 1e-12);
}

// Index of the corner of a triangle at x; -1 if it has none there.
int cornerAt(const Triangle& triangle, const double* x) {
  for (int i = 0; i < 3; ++i)
    if (std::equal(x, x + 3, triangle.corner[i])) return i;
  return -1;
}

// A point on an edge or corner is a local minimum if no other triangle there is nearer.
bool isMinimum(const MinimaSearch& s, const Triangle& triangle, const Candidate& c) {
  if (c.feature == kFace) return true;
  const auto& neighbour = s.data->neighbour;
  const auto triangleOf = [&s](std::int32_t number) -> const Triangle& {
    return s.data->triangles[s.data->slotOf[number]];
  };
  if (c.feature >= kEdge01) {
    const std::int32_t other = neighbour[triangle.index][c.feature - kEdge01];
    return other < 0 || !hasNearer(s, triangleOf(other), c.squared);
  }
  for (const int turn : {2, 0}) {  // walk round the corner one way, and the other way if a border stops the walk
    std::int32_t at = triangle.index;
    int corner = c.feature;
    for (int step = 0; step < kMostFanSteps && corner >= 0; ++step) {
      at = neighbour[at][(corner + turn) % 3];
      if (at == triangle.index) return true;
      if (at < 0) break;
      const Triangle& next = triangleOf(at);
      if (hasNearer(s, next, c.squared)) return false;
      corner = cornerAt(next, triangle.corner[c.feature]);
    }
  }
  return true;
}

double tryMinimum(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<MinimaSearch*>(context);
  const Triangle* triangles = s.data->triangles.data();
  const Triangle& triangle = triangles[slot];
  Candidate c;
  closestOnTriangle(&triangle, s.p.data(), &c);
  if (!(c.squared <= reach * reach)) return reach;
  Answer& found = s.found;
  if (found.slot < 0 || c.squared < found.nearest.squared ||
      (c.squared == found.nearest.squared && triangle.index < triangles[found.slot].index))
    found = {c, slot};
  if (!(c.squared > 0.0)) return reach;
  Minimum minimum;
  minimum.point = vec(c.point);
  minimum.distance = std::sqrt(c.squared);
  minimum.normal = (s.p - minimum.point).normalized();  // of a mesh of 50 km, rounding differs from the distance
  minimum.triangle = triangle.index;
  setFeature(c.feature, minimum);
  if (isMinimum(s, triangle, c)) keepMinimum(minimum, *s.minima);
  return reach;
}

}  // namespace

Answer findMinima(const MeshData& data, const Vec3& p, double reach, Minima& minima) noexcept {
  MinimaSearch s{&data, p, {{0.0, {p[0], p[1], p[2]}, kFace, 0.0, 0.0}, -1}, &minima};
  minima.count = 0;
  loops().visitMinima(data.view, p.data(), reach, &tryMinimum, &s);
  return s.found;
}

}  // namespace enamel::kernel
