#include "support/meshes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace enamel::test {

TriangleMesh boxMesh(const Vec3& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(half.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh subdivide(const TriangleMesh& mesh) {
  TriangleMesh fine;
  fine.vertices = mesh.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, isNew] = middles.emplace(std::minmax(a, b), static_cast<int>(fine.vertices.size()));
    if (isNew) fine.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    return entry->second;
  };
  for (const auto& t : mesh.triangles) {
    const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    for (const std::array<int, 3>& part : {std::array<int, 3>{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}})
      fine.triangles.push_back(part);
  }
  return fine;
}

TriangleMesh ball(int levels, double waves) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) mesh.vertices.push_back(sign * Vec3::Unit(axis));
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        const bool turn = (x + y + z) % 2 != 0;
        mesh.triangles.push_back(turn ? std::array<int, 3>{x, z, y} : std::array<int, 3>{x, y, z});
      }
  for (int i = 0; i < levels; ++i) mesh = subdivide(mesh);
  for (Vec3& v : mesh.vertices) {
    v.normalize();
    v *= 1.0 + waves * std::sin(7.0 * v.x()) * std::sin(5.0 * v.y() + 1.0) * std::sin(6.0 * v.z() + 2.0);
  }
  return mesh;
}

TriangleMesh transformed(TriangleMesh mesh, double scale, const Vec3& shift) {
  for (Vec3& v : mesh.vertices) v = scale * v + shift;
  return mesh;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int first = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

TriangleMesh wedge(double angle) {
  TriangleMesh mesh;
  const double h = std::tan(0.5 * angle);
  mesh.vertices = {{0, 0, 0}, {1, h, 0}, {1, -h, 0}, {0, 0, 1}, {1, h, 1}, {1, -h, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 1}, {1, 3, 4}, {0, 2, 3}, {2, 5, 3}, {1, 4, 2}, {2, 4, 5}};
  return mesh;
}

std::vector<NamedMesh> brokenMeshes() {
  std::vector<NamedMesh> zoo;
  const TriangleMesh wavy = ball(4, 0.1);
  const auto add = [&](const std::string& name, TriangleMesh mesh, bool closed = false) {
    zoo.push_back({name, std::move(mesh), closed});
  };
  add("one triangle", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  add("one segment", {{{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}}, {{0, 1, 2}}});
  add("one point", {{{1, 2, 3}}, {{0, 0, 0}}});
  add("needles", [] {
    TriangleMesh mesh;
    for (int i = 0; i < 40; ++i) {
      const double width = std::pow(10.0, -0.4 * i), y = 0.01 * i;
      const int first = 3 * i;
      mesh.vertices.insert(mesh.vertices.end(), {{0, y, 0.3}, {1, y + 0.3 * width, 0.1 * y}, {1, y, 0.2 * width}});
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
  }());
  add("caps", [] {
    TriangleMesh mesh;
    for (int i = 0; i < 40; ++i) {
      const double height = std::pow(10.0, -0.4 * i), y = 0.01 * i;
      const int first = 3 * i;
      mesh.vertices.insert(mesh.vertices.end(), {{0, y, 0.1}, {1, y, 0.2}, {0.37, y + height, 0.137}});
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
  }());
  {
    TriangleMesh mesh = wavy;  // collapsed edges: triangles without area between sound ones
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 7) {
      const auto corner = mesh.triangles[t];
      mesh.vertices.push_back(0.5 * (mesh.vertices[corner[0]] + mesh.vertices[corner[1]]));
      const int middle = static_cast<int>(mesh.vertices.size()) - 1;
      mesh.triangles.push_back({corner[0], middle, corner[1]});
      mesh.triangles.push_back({corner[2], corner[2], corner[0]});
    }
    add("zero areas", mesh);
  }
  add("duplicates", joined(wavy, wavy));
  {
    TriangleMesh mesh = boxMesh({1, 1, 1});  // one side split without its neighbours: T-junctions
    mesh.vertices.push_back({0, 0, 1});
    mesh.vertices.push_back({0, -1, 1});
    mesh.triangles.erase(mesh.triangles.begin() + 2);
    mesh.triangles.insert(mesh.triangles.end(), {{4, 9, 6}, {9, 5, 6}, {8, 9, 5}});
    add("T-junctions", mesh);
  }
  add("non-manifold edges", {{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}, {-1, 1, 0}},
                             {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}, {0, 1, 5}}});
  add("self-intersection", joined(wavy, transformed(wavy, 0.9, {0.5, 0.2, 0.1})));
  add(
      "loose vertices",
      [&] {
        TriangleMesh mesh;
        for (const auto& t : wavy.triangles) {
          const int first = static_cast<int>(mesh.vertices.size());
          for (const int v : t) mesh.vertices.push_back(wavy.vertices[v]);
          mesh.triangles.push_back({first, first + 1, first + 2});
        }
        return mesh;
      }(),
      true);
  add("1 um", transformed(wavy, 1e-6, {3e-6, 1e-6, 0}), true);
  add("1 km far away", transformed(wavy, 1.0, {1000, -1000, 500}), true);
  add("1000 km wide", transformed(wavy, 1e6, {1e5, 0, 0}), true);
  {
    TriangleMesh mesh = ball(3);  // closed, with zero-area triangles along split edges
    std::map<std::pair<int, int>, int> owner;
    const std::size_t count = mesh.triangles.size();
    for (std::size_t t = 0; t < count; t += 11) {
      const auto corner = mesh.triangles[t];
      const int middle = static_cast<int>(mesh.vertices.size());
      mesh.vertices.push_back(0.5 * (mesh.vertices[corner[0]] + mesh.vertices[corner[1]]));
      mesh.triangles[t] = {middle, corner[1], corner[2]};
      mesh.triangles.push_back({corner[0], middle, corner[2]});
      mesh.triangles.push_back({corner[1], middle, corner[0]});
    }
    add("closed with zero areas", mesh, true);
  }
  return zoo;
}

std::vector<NamedMesh> soundMeshes() {
  return {{"box", boxMesh({1, 2, 3}), true},
          {"ball", ball(3), true},
          {"wavy ball", ball(5, 0.1), true},
          {"sharp wedge", wedge(0.02), true},
          {"blunt wedge", wedge(3.0), true},
          {"thin plate", boxMesh({1.0, 1.0, 1e-6}), true},
          {"hollow ball",
           [] {
             TriangleMesh inner = transformed(ball(3), 0.5, Vec3::Zero());
             for (auto& t : inner.triangles) std::swap(t[0], t[1]);
             return joined(ball(3), inner);
           }(),
           true}};
}

std::string largeMeshFolder() {
  for (const char* folder : {"/../shared/meshes", "/../../shared/meshes"}) {
    const std::string path = ENAMEL_SOURCE_DIR + std::string(folder);
    if (std::filesystem::exists(path + "/tooth36.ply")) return path;
  }
  return "";
}

double referenceDistance(const Vec3& point, const Vec3& va, const Vec3& vb, const Vec3& vc) {
  using L3 = Eigen::Matrix<long double, 3, 1>;
  const L3 p = point.cast<long double>(), a = va.cast<long double>(), b = vb.cast<long double>(),
           c = vc.cast<long double>();
  const auto toSegment = [&p](const L3& s, const L3& e) {
    const long double length = (e - s).norm();
    if (length == 0.0L) return (p - s).norm();
    const L3 along = (e - s) / length;
    const long double t = std::min(std::max((p - s).dot(along), 0.0L), length);
    return (p - s - t * along).norm();
  };
  long double distance = std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
  // Place the axes at the corner opposite the longest edge.
  const long double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
  const L3& o = ab >= bc && ab >= ca ? c : bc >= ca ? a : b;
  const L3& s = &o == &a ? b : &o == &b ? c : a;
  const L3& e = &o == &a ? c : &o == &b ? a : b;
  const L3 u = s - o, w = e - o;
  if (u.norm() == 0.0L) return static_cast<double>(distance);
  const L3 x = u.normalized(), across = w - x * x.dot(w);
  if (across.norm() <= 1e-17L * std::max({ab, bc, ca})) return static_cast<double>(distance);
  const L3 y = across.normalized();
  const long double ux = u.norm(), wx = w.dot(x), wy = across.norm(), px = (p - o).dot(x), py = (p - o).dot(y);
  const long double second = py / wy, first = (px - second * wx) / ux;
  if (first >= 0.0L && second >= 0.0L && first + second <= 1.0L)
    distance = std::min(distance, (p - o - first * u - second * w).norm());
  return static_cast<double>(distance);
}

ReferenceDistance::ReferenceDistance(const TriangleMesh& mesh) : mesh_(mesh) {
  for (const auto& t : mesh.triangles) {
    const Vec3 centre = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
    double radius = 0.0;
    for (const int v : t) radius = std::max(radius, (mesh.vertices[v] - centre).norm());
    centres_.push_back(centre);
    radii_.push_back(radius);
  }
}

double ReferenceDistance::operator()(const Vec3& p) const {
  std::size_t nearest = 0;
  double least = 1e300;
  std::vector<double> toCentre(centres_.size());
  for (std::size_t i = 0; i < centres_.size(); ++i) {
    toCentre[i] = (centres_[i] - p).norm();
    if (toCentre[i] < least) {
      least = toCentre[i];
      nearest = i;
    }
  }
  double distance = exact(p, nearest);
  for (std::size_t i = 0; i < centres_.size(); ++i)
    if (toCentre[i] * (1.0 - 1e-12) - radii_[i] * (1.0 + 1e-12) <= distance) distance = std::min(distance, exact(p, i));
  return distance;
}

double ReferenceDistance::exact(const Vec3& p, std::size_t i) const {
  const auto& t = mesh_.triangles[i];
  return referenceDistance(p, mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]);
}

double windingNumber(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4.0 * M_PI);
}

double sizeOf(const TriangleMesh& mesh) {
  Vec3 low = mesh.vertices[mesh.triangles[0][0]], high = low;
  for (const auto& t : mesh.triangles)
    for (const int v : t) {
      low = low.cwiseMin(mesh.vertices[v]);
      high = high.cwiseMax(mesh.vertices[v]);
    }
  return std::max((high - low).norm(), 1e-3 * high.norm());
}

Vec3 queryPoint(const TriangleMesh& mesh, double size, Random& random) {
  const auto pick = [&random](std::size_t n) {
    return std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1);
  };
  const auto& t = mesh.triangles[pick(mesh.triangles.size())];
  const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const Vec3 normal =
      (b - a).cross(c - a).normalized().allFinite() ? Vec3((b - a).cross(c - a).normalized()) : random.direction();
  double away = size * random.power(-9.0, 0.0);
  if (random.uniform(0.0, 1.0) < 0.5) away = -away;
  switch (pick(8)) {
    case 0: return a;
    case 1: return 0.5 * (a + b);
    case 2: return a + away * normal;
    case 3: return 0.5 * (a + b) + away * normal;
    case 4: {
      const double u = random.uniform(0.0, 1.0), v = random.uniform(0.0, 1.0 - u);
      return a + u * (b - a) + v * (c - a) + away * normal;
    }
    case 5: return a + away * random.direction();
    case 6: {
      const double far = size * random.power(0.0, 6.0);
      return a + far * random.direction();
    }
    default: return a + 1.5 * random.vector(size);
  }
}

}  // namespace enamel::test
