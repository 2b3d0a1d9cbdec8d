#include "enamel/collision/solid_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solid_query.hpp"

namespace enamel {
namespace {

constexpr double kEnd = 0.01;      // share of an edge that no vertex is nearer to its ends
constexpr double kSettled = 1e-3;  // cells
constexpr int kSteps = 8;
constexpr int kCornersOfCube = 8;  // bits x, y, z

// From corner to opposite corner along the three axes in every order.
struct Tetrahedron {
  std::array<int, 4> corners;
  bool isOdd;
};
constexpr std::array<Tetrahedron, 6> kTetrahedra = {{{{0, 1, 3, 7}, false},
                                                     {{0, 2, 6, 7}, false},
                                                     {{0, 4, 5, 7}, false},
                                                     {{0, 2, 3, 7}, true},
                                                     {{0, 4, 6, 7}, true},
                                                     {{0, 1, 5, 7}, true}}};

Vec3 towards(int corner) { return Vec3(corner & 1, corner >> 1 & 1, corner >> 2); }
int strideTo(int corner) {
  return (corner & 1) + (corner >> 1 & 1) * kBrickSamples + (corner >> 2) * kBrickSamples * kBrickSamples;
}

class Extraction {
 public:
  Extraction(const Solid& solid, int brick, const BrickSamples& samples, int step, SolidSurface& surface)
      : solid_(solid), samples_(samples), step_(step), surface_(surface) {
    corner_ = ((solid.lowOf(brick) - solid.low()) / solid.cell()).array().round();
    vertices_.fill(-1);
  }

  void addCell(int x, int y, int z) {
    at_ = {x, y, z};
    sample_ = (z * kBrickSamples + y) * kBrickSamples + x;
    for (const Tetrahedron& tetrahedron : kTetrahedra) add(tetrahedron);
  }

 private:
  bool isInside(int corner) const {
    return samples_[static_cast<std::size_t>(sample_ + step_ * strideTo(corner))] < 0.0f;
  }

  void add(const Tetrahedron& tetrahedron) {
    std::array<int, 4> c;  // corners inside first
    int inside = 0, outside = 0;
    bool isOdd = tetrahedron.isOdd;
    std::array<int, 4> others;
    for (const int corner : tetrahedron.corners) {
      if (isInside(corner)) {
        c[static_cast<std::size_t>(inside++)] = corner;
        isOdd = isOdd != (outside % 2 != 0);
      } else {
        others[static_cast<std::size_t>(outside++)] = corner;
      }
    }
    if (inside == 0 || outside == 0) return;
    std::copy(others.begin(), others.begin() + outside, c.begin() + inside);
    if (isOdd) inside == 1 ? std::swap(c[2], c[3]) : std::swap(c[0], c[1]);
    if (inside == 1) {
      addTriangle(on(c[0], c[1]), on(c[0], c[2]), on(c[0], c[3]));
    } else if (inside == 3) {
      addTriangle(on(c[3], c[0]), on(c[3], c[1]), on(c[3], c[2]));
    } else {
      addTriangle(on(c[0], c[2]), on(c[0], c[3]), on(c[1], c[3]));
      addTriangle(on(c[0], c[2]), on(c[1], c[3]), on(c[1], c[2]));
    }
  }

  void addTriangle(int a, int b, int c) { surface_.mesh.triangles.push_back({a, b, c}); }

  // The vertex between two corners of the cell.
  int on(int from, int to) {
    const int low = from & to, way = from ^ to;
    const auto a = static_cast<std::size_t>(sample_ + step_ * strideTo(low));
    std::int32_t& vertex = vertices_[a * kCornersOfCube + static_cast<std::size_t>(way)];
    if (vertex >= 0) return vertex;
    const double t = std::clamp(zeroBetween(a, way), kEnd, 1.0 - kEnd);
    const Vec3 start = Vec3(at_[0], at_[1], at_[2]) + step_ * towards(low), edge = step_ * towards(way);
    const Vec3 position = solid_.low() + solid_.cell() * (corner_ + start + t * edge);
    const Vec3 gradient = (1.0 - t) * gradientAt(start) + t * gradientAt(start + edge);
    const double length = gradient.norm();
    const Vec3 normal =
        length > 1e-3 ? Vec3(gradient / length) : Vec3((samples_[a] < 0.0f ? 1.0 : -1.0) * towards(way).normalized());
    vertex = static_cast<std::int32_t>(surface_.mesh.vertices.size());
    surface_.mesh.vertices.push_back(position);
    surface_.normals.push_back(normal);
    surface_.layers.push_back(solid_.layerAt(position - 0.5 * solid_.cell() * normal));
    return vertex;
  }

  // Where the trilinear interpolation is 0 on the way from a sample to an opposite corner of its edge, face or cell:
  // sum of the corners weighted with (1-t)^(n-k) t^k, k of the n axes ahead. Regula falsi (Illinois).
  double zeroBetween(std::size_t a, int way) const {
    std::array<double, 4> c{};  // by k
    int axes = 0;
    for (int corner = 0; corner <= way; ++corner) {
      if ((corner & way) != corner) continue;
      axes = (corner & 1) + (corner >> 1 & 1) + (corner >> 2);
      c[static_cast<std::size_t>(axes)] +=
          static_cast<double>(samples_[a + static_cast<std::size_t>(step_ * strideTo(corner))]);
    }
    double low = 0.0, high = 1.0, atLow = c[0], atHigh = c[static_cast<std::size_t>(axes)],
           t = atLow / (atLow - atHigh);
    for (int step = 0, last = 0; axes > 1 && step < kSteps; ++step) {
      const double u = 1.0 - t;
      const double value = axes == 2 ? u * u * c[0] + u * t * c[1] + t * t * c[2]
                                     : u * u * u * c[0] + u * u * t * c[1] + u * t * t * c[2] + t * t * t * c[3];
      if (std::abs(value) < kSettled) break;
      const bool isLow = (value < 0.0) == (c[0] < 0.0);
      (isLow ? low : high) = t;
      (isLow ? atLow : atHigh) = value;
      if (last == (isLow ? 1 : -1)) (isLow ? atHigh : atLow) *= 0.5;
      last = isLow ? 1 : -1;
      t = low + (high - low) * atLow / (atLow - atHigh);
    }
    return t;
  }

  // Differences of second order, at the border to one side.
  Vec3 gradientAt(const Vec3& sample) const {
    const Eigen::Vector3i at = sample.cast<int>();
    const std::array<int, 3> strides = {1, kBrickSamples, kBrickSamples * kBrickSamples};
    const int here = at[0] + at[1] * strides[1] + at[2] * strides[2];
    Vec3 gradient;
    for (int i = 0; i < 3; ++i) {
      const int stride = strides[static_cast<std::size_t>(i)];
      const auto s = [&](int k) { return static_cast<double>(samples_[static_cast<std::size_t>(here + k * stride)]); };
      gradient[i] = at[i] == 0             ? 0.5 * (4.0 * s(1) - 3.0 * s(0) - s(2))
                    : at[i] == kBrickCells ? 0.5 * (3.0 * s(0) - 4.0 * s(-1) + s(-2))
                                           : 0.5 * (s(1) - s(-1));
    }
    return gradient;
  }

  const Solid& solid_;
  const BrickSamples& samples_;
  int step_;  // samples from corner to corner
  SolidSurface& surface_;
  Vec3 corner_;  // of the brick, cells
  std::array<int, 3> at_{};
  int sample_ = 0;
  std::array<std::int32_t, std::tuple_size<BrickSamples>::value * kCornersOfCube> vertices_;  // by edge
};

}  // namespace

void SolidSurface::clear() noexcept {
  mesh.vertices.clear();
  mesh.triangles.clear();
  normals.clear();
  layers.clear();
}

void appendSurface(const Solid& solid, int brick, const BrickSamples& samples, SolidSurface& surface, int step) {
  const auto cells = kernel::surfaceCells(samples);
  if (std::all_of(cells.begin(), cells.end(), [](std::uint64_t slice) { return slice == 0; })) return;
  Extraction extraction(solid, brick, samples, step, surface);
  for (int z = 0; z < kBrickCells && step > 1; z += step)
    for (int y = 0; y < kBrickCells; y += step)
      for (int x = 0; x < kBrickCells; x += step) extraction.addCell(x, y, z);
  if (step > 1) return;
  for (int z = 0; z < kBrickCells; ++z)
    for (std::uint64_t left = cells[static_cast<std::size_t>(z)]; left != 0; left &= left - 1) {
      const int bit = __builtin_ctzll(left);
      extraction.addCell(bit % kBrickCells, bit / kBrickCells, z);
    }
}

TriangleMesh surfaceOf(const Solid& solid) {
  SolidSurface bricks;
  for (int brick = 0; brick < solid.bricks(); ++brick) appendSurface(solid, brick, solid.samples(brick), bricks);
  const std::vector<int> place = weld(bricks.mesh);
  TriangleMesh mesh;
  for (std::size_t v = 0; v < place.size(); ++v)
    if (place[v] == static_cast<int>(mesh.vertices.size())) mesh.vertices.push_back(bricks.mesh.vertices[v]);
  mesh.triangles = std::move(bricks.mesh.triangles);
  for (auto& triangle : mesh.triangles)
    for (int& v : triangle) v = place[static_cast<std::size_t>(v)];
  return mesh;
}

}  // namespace enamel
