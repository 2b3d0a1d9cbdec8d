#include "enamel/collision/solid_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solid_query.hpp"
#include "tetrahedra.hpp"

namespace enamel {
namespace {

constexpr double kSettled = 1e-3;  // cells
constexpr double kOff = 0.25;      // cells: a triangle's centre that is farther from the surface is moved there
constexpr double kWithin = 0.05;   // least share of the triangle for each of the three parts
constexpr int kRounds = 8;
constexpr int kCornersOfCube = 8;  // bits x, y, z

Vec3 towards(int corner) { return Vec3(corner & 1, corner >> 1 & 1, corner >> 2); }
int strideTo(int corner) {
  return (corner & 1) + (corner >> 1 & 1) * kBrickSamples + (corner >> 2) * kBrickSamples * kBrickSamples;
}

int sampleAt(const std::array<int, 3>& p) { return (p[2] * kBrickSamples + p[1]) * kBrickSamples + p[0]; }

// Fit a brick to neighbours of twice its step. On the common border its samples become those of the neighbour's
// triangles, and its vertices the neighbour's.
class Fit {
 public:
  Fit(std::uint32_t coarser, int step) : step_(step) {
    for (int border = 0; border < kBorders; ++border) {
      const std::array<int, 3> at = {border % 3 - 1, border / 3 % 3 - 1, border / 9 - 1};
      for (int other = 0; other < kBorders; ++other) {
        const std::array<int, 3> neighbour = {other % 3 - 1, other / 3 % 3 - 1, other / 9 - 1};
        bool touches = other != kItself && (coarser >> other & 1) != 0;
        for (std::size_t i = 0; i < 3; ++i) touches = touches && (neighbour[i] == 0 || neighbour[i] == at[i]);
        touches_[static_cast<std::size_t>(border)] = touches_[static_cast<std::size_t>(border)] || touches;
      }
    }
  }

  // Whether an edge from a sample, or the sample itself, is on the border with such a neighbour.
  bool touches(const std::array<int, 3>& from, int way) const {
    int border = kItself;
    for (std::size_t i = 0, unit = 1; i < 3; ++i, unit *= 3)
      if ((way >> i & 1) == 0)
        border += static_cast<int>(unit) * ((from[i] == kBrickCells ? 1 : 0) - (from[i] == 0 ? 1 : 0));
    return touches_[static_cast<std::size_t>(border)];
  }

  // The neighbour splits its squares along the same diagonal. This brick's samples are in the middle of its edges.
  BrickSamples samples(const BrickSamples& samples) const {
    BrickSamples fitted = samples;
    std::array<int, 3> p;
    for (p[2] = 0; p[2] <= kBrickCells; p[2] += step_)
      for (p[1] = 0; p[1] <= kBrickCells; p[1] += step_)
        for (p[0] = 0; p[0] <= kBrickCells; p[0] += step_) {
          if (!touches(p, 0)) continue;
          const auto [low, high] = around(p);
          fitted[static_cast<std::size_t>(sampleAt(p))] = 0.5f * (samples[static_cast<std::size_t>(sampleAt(low))] +
                                                                  samples[static_cast<std::size_t>(sampleAt(high))]);
        }
    return fitted;
  }

  // Find the neighbour's edge that has the vertex of this one. It is on the same line, or an edge of the neighbour's
  // surrounding triangle that crosses the surface, always the same.
  void move(const BrickSamples& samples, std::array<int, 3>& from, int& way) const {
    const std::array<int, 3> low = around(from).first;
    int ahead = 0;
    for (std::size_t i = 0; i < 3; ++i) ahead |= from[i] != low[i] ? 1 << i : 0;
    from = low;
    if (ahead == 0 || ahead == way) return;
    // Corners of the triangle: low, from there along one axis, along both.
    const int both = ahead | way, first = ahead == both ? way : ahead;
    const auto isInside = [&](int corner) {
      std::array<int, 3> at = low;
      for (std::size_t i = 0; i < 3; ++i) at[i] += (corner >> i & 1) * 2 * step_;
      return samples[static_cast<std::size_t>(sampleAt(at))] < 0.0f;
    };
    way = isInside(0) != isInside(first) ? first : both;
  }

 private:
  static constexpr int kBorders = 27, kItself = 13;

  std::pair<std::array<int, 3>, std::array<int, 3>> around(const std::array<int, 3>& p) const {
    std::array<int, 3> low = p, high = p;
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] -= p[i] % (2 * step_);
      high[i] += p[i] % (2 * step_);
    }
    return {low, high};
  }

  int step_;
  std::array<bool, kBorders> touches_{};
};

// The triangles in a cube, by the corners that are inside. Their vertices are edges between corners.
struct CubeCase {
  static constexpr int kMostEdges = 19, kMostTriangles = 12;
  int edges = 0, triangles = 0;
  std::array<std::uint8_t, kMostEdges> low{}, way{};  // low corner, axes to the other one
  std::array<std::array<std::uint8_t, 3>, kMostTriangles> triangle{};
};

std::array<CubeCase, 1 << kCornersOfCube> makeCubeCases() {
  std::array<CubeCase, 1 << kCornersOfCube> cases;
  for (std::size_t inside = 0; inside < cases.size(); ++inside) {
    CubeCase& cube = cases[inside];
    const auto on = [&cube](int from, int to) {
      const int low = from & to, way = from ^ to;
      int edge = 0;
      while (edge < cube.edges &&
             (cube.low[static_cast<std::size_t>(edge)] != low || cube.way[static_cast<std::size_t>(edge)] != way))
        ++edge;
      cube.low[static_cast<std::size_t>(edge)] = static_cast<std::uint8_t>(low);
      cube.way[static_cast<std::size_t>(edge)] = static_cast<std::uint8_t>(way);
      cube.edges = std::max(cube.edges, edge + 1);
      return static_cast<std::uint8_t>(edge);
    };
    kernel::addTriangles([inside](int corner) { return (inside >> corner & 1) != 0; }, on,
                         [&cube](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
                           cube.triangle[static_cast<std::size_t>(cube.triangles++)] = {a, b, c};
                         });
  }
  return cases;
}

class Extraction {
 public:
  Extraction(const Solid& solid, int brick, const BrickSamples& samples, int step, const Fit* fit,
             SolidSurface& surface)
      : solid_(solid), samples_(samples), step_(step), fit_(fit), surface_(surface) {
    corner_ = ((solid.lowOf(brick) - solid.low()) / solid.cell()).array().round();
    vertices_.fill(-1);
  }

  void addCells() {
    if (step_ == 1) {
      const auto cells = kernel::surfaceCells(samples_);
      for (int z = 0; z < kBrickCells; ++z)
        for (std::uint64_t left = cells[static_cast<std::size_t>(z)]; left != 0; left &= left - 1) {
          const int bit = __builtin_ctzll(left);
          addCell(bit % kBrickCells, bit / kBrickCells, z);
        }
      return;
    }
    for (int z = 0; z < kBrickCells; z += step_)
      for (int y = 0; y < kBrickCells; y += step_)
        for (int x = 0; x < kBrickCells; x += step_) addCell(x, y, z);
  }

 private:
  void addCell(int x, int y, int z) {
    static const auto kCases = makeCubeCases();
    at_ = {x, y, z};
    sample_ = sampleAt(at_);
    std::size_t inside = 0;
    for (int corner = 0; corner < kCornersOfCube; ++corner)
      inside |= static_cast<std::size_t>(samples_[static_cast<std::size_t>(sample_ + step_ * strideTo(corner))] < 0.0f)
                << corner;
    const CubeCase& cube = kCases[inside];
    std::array<int, CubeCase::kMostEdges> vertices;
    for (std::size_t edge = 0; edge < static_cast<std::size_t>(cube.edges); ++edge)
      vertices[edge] = on(cube.low[edge], cube.way[edge]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(cube.triangles); ++i) {
      const auto& triangle = cube.triangle[i];
      addTriangle(vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]);
    }
  }

  void addTriangle(int a, int b, int c) {
    if (a != b && b != c && c != a) surface_.mesh.triangles.push_back({a, b, c});
  }

  // The vertex on an edge of the cell.
  int on(int low, int way) {
    auto a = static_cast<std::size_t>(sample_ + step_ * strideTo(low));
    if (fit_ == nullptr && vertexOf(a, way) >= 0) return vertexOf(a, way);
    int step = step_;
    std::array<int, 3> at = {at_[0] + step * (low & 1), at_[1] + step * (low >> 1 & 1), at_[2] + step * (low >> 2)};
    if (fit_ != nullptr && fit_->touches(at, way)) {
      fit_->move(samples_, at, way);
      a = static_cast<std::size_t>(sampleAt(at));
      step = 2 * step_;
    }
    std::int32_t& vertex = vertexOf(a, way);
    if (vertex >= 0) return vertex;
    const double t = std::clamp(zeroBetween(a, way, step), kernel::kEnd, 1.0 - kernel::kEnd);
    const Vec3 start(at[0], at[1], at[2]), edge = step * towards(way);
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

  std::int32_t& vertexOf(std::size_t sample, int way) {
    return vertices_[sample * kCornersOfCube + static_cast<std::size_t>(way)];
  }

  // Zero of the trilinear interpolation on the line from a sample to an opposite corner of its edge, face or cell. The
  // polynomial is the sum of the corners weighted with (1-t)^(n-k) t^k, k of the n axes ahead. Regula falsi (Illinois).
  double zeroBetween(std::size_t a, int way, int step) const {
    std::array<double, 4> c{};  // by k
    int axes = 0;
    for (int corner = 0; corner <= way; ++corner) {
      if ((corner & way) != corner) continue;
      axes = (corner & 1) + (corner >> 1 & 1) + (corner >> 2);
      c[static_cast<std::size_t>(axes)] +=
          static_cast<double>(samples_[a + static_cast<std::size_t>(step * strideTo(corner))]);
    }
    double low = 0.0, high = 1.0, atLow = c[0], atHigh = c[static_cast<std::size_t>(axes)],
           t = atLow / (atLow - atHigh);
    for (int round = 0, last = 0; axes > 1 && round < kRounds; ++round) {
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

  // Differences of second order, one-sided at the border.
  Vec3 gradientAt(const Vec3& sample) const {
    const Eigen::Vector3i at = sample.cast<int>();
    const std::array<int, 3> strides = {1, kBrickSamples, kBrickSamples * kBrickSamples};
    const int here = at[0] + at[1] * strides[1] + at[2] * strides[2];
    Vec3 gradient;
    for (int i = 0; i < 3; ++i) {
      const int stride = strides[static_cast<std::size_t>(i)];
      const auto s = [&](int k) {
        const int number = here + k * stride;
        return static_cast<double>(samples_[static_cast<std::size_t>(number)]);
      };
      gradient[i] = at[i] == 0             ? 0.5 * (4.0 * s(1) - 3.0 * s(0) - s(2))
                    : at[i] == kBrickCells ? 0.5 * (3.0 * s(0) - 4.0 * s(-1) + s(-2))
                                           : 0.5 * (s(1) - s(-1));
    }
    return gradient;
  }

  const Solid& solid_;
  const BrickSamples& samples_;
  int step_;  // samples from corner to corner
  const Fit* fit_;
  SolidSurface& surface_;
  Vec3 corner_;  // of the brick, cells
  std::array<int, 3> at_{};
  int sample_ = 0;
  std::array<std::int32_t, std::tuple_size<BrickSamples>::value * kCornersOfCube> vertices_;  // by edge
};

// A triangle across a sharp edge leaves the surface between its corners. It gets a new corner on the surface over its
// middle, so that its edges stay and the mesh stays closed.
void splitWhereOff(const Solid& solid, TriangleMesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = mesh.triangles[i];
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])],
               &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const SolidPoint off = signedDistance(solid, (a + b + c) / 3.0, solid.cell());
    if (!off.found || std::abs(off.distance) < kOff * solid.cell()) continue;
    const Vec3 normal = (b - a).cross(c - a), top = off.point;
    const auto share = [&](const Vec3& from, const Vec3& to) {
      return (to - from).cross(top - from).dot(normal) / normal.squaredNorm();
    };
    if (!(std::min({share(a, b), share(b, c), share(c, a)}) > kWithin)) continue;
    const int middle = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(top);
    mesh.triangles[i] = {t[0], t[1], middle};
    mesh.triangles.push_back({t[1], t[2], middle});
    mesh.triangles.push_back({t[2], t[0], middle});
  }
}

}  // namespace

void SolidSurface::clear() noexcept {
  mesh.vertices.clear();
  mesh.triangles.clear();
  normals.clear();
  layers.clear();
}

void appendSurface(const Solid& solid, int brick, const BrickSamples& samples, SolidSurface& surface, int step,
                   std::uint32_t coarser) {
  const auto cells = kernel::surfaceCells(samples);
  if (std::all_of(cells.begin(), cells.end(), [](std::uint64_t slice) { return slice == 0; })) return;
  if (coarser != 0) {
    const Fit fit(coarser, step);
    const BrickSamples fitted = fit.samples(samples);
    Extraction(solid, brick, fitted, step, &fit, surface).addCells();
  } else {
    Extraction(solid, brick, samples, step, nullptr, surface).addCells();
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
  splitWhereOff(solid, mesh);
  return mesh;
}

}  // namespace enamel
