#include "mesh_prepare.hpp"

// Decimater's headers need the mesh header first.
#include <Eigen/Geometry>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <cmath>
#include <optional>

#include "enamel/collision/openmesh.hpp"
#include "enamel/collision/proximity.hpp"

namespace enamel::app {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using OpenMesh::VertexHandle;
using Loop = std::vector<VertexHandle>;

Vec3 at(const Mesh& mesh, VertexHandle v) { return fromOpenMeshPoint(mesh.point(v)); }
OpenMesh::Vec3d pointOf(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// Merge vertices at the same place. Remove triangles with repeated corners, and duplicates of other triangles.
TriangleMesh joinVertices(const TriangleMesh& mesh, PrepareReport& report) {
  const std::vector<int> place = weld(mesh);
  TriangleMesh joined;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (place[v] == static_cast<int>(joined.vertices.size())) joined.vertices.push_back(mesh.vertices[v]);
  report.joinedVertices = static_cast<int>(mesh.vertices.size() - joined.vertices.size());
  std::vector<std::array<int, 4>> sorted;  // corners in ascending order, then the triangle's number
  std::vector<std::array<int, 3>> corners;
  for (const auto& t : mesh.triangles) {
    const std::array<int, 3> c{place[static_cast<std::size_t>(t[0])], place[static_cast<std::size_t>(t[1])],
                               place[static_cast<std::size_t>(t[2])]};
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    std::array<int, 3> key = c;
    std::sort(key.begin(), key.end());
    sorted.push_back({key[0], key[1], key[2], static_cast<int>(corners.size())});
    corners.push_back(c);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<char> isDouble(corners.size(), 0);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin()))
      isDouble[static_cast<std::size_t>(sorted[i][3])] = 1;
  for (std::size_t t = 0; t < corners.size(); ++t)
    if (isDouble[t] == 0) joined.triangles.push_back(corners[t]);
  report.uselessTriangles = static_cast<int>(mesh.triangles.size() - joined.triangles.size());
  return joined;
}

// Add every triangle that keeps the mesh manifold. A rejected one may fit after its neighbours: try until none fits.
Mesh buildManifold(const TriangleMesh& mesh, PrepareReport& report) {
  Mesh result;
  result.request_vertex_status();
  result.request_edge_status();
  result.request_halfedge_status();
  result.request_face_status();
  for (const Vec3& v : mesh.vertices) result.add_vertex(pointOf(v));
  std::vector<std::array<int, 3>> refused, waiting = mesh.triangles;
  do {
    refused.clear();
    for (const auto& t : waiting)
      if (!addFaceTo(result, VertexHandle(t[0]), VertexHandle(t[1]), VertexHandle(t[2])).is_valid())
        refused.push_back(t);
    std::swap(refused, waiting);
  } while (!waiting.empty() && waiting.size() < refused.size());
  report.misfitTriangles += static_cast<int>(waiting.size());
  return result;
}

// Return the borders of the openings, in the direction of the faces that would close them. A border may pass a vertex
// twice.
std::vector<Loop> findLoops(const Mesh& mesh) {
  std::vector<Loop> loops;
  std::vector<char> isSeen(mesh.n_halfedges(), 0);
  for (const auto first : mesh.halfedges()) {
    if (!mesh.is_boundary(first) || isSeen[static_cast<std::size_t>(first.idx())] != 0) continue;
    Loop& loop = loops.emplace_back();
    OpenMesh::HalfedgeHandle h = first;
    do {
      isSeen[static_cast<std::size_t>(h.idx())] = 1;
      loop.push_back(mesh.from_vertex_handle(h));
      h = mesh.next_halfedge_handle(h);
    } while (h != first);
  }
  return loops;
}

double lengthOf(const Mesh& mesh, const Loop& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    length += (at(mesh, loop[(i + 1) % loop.size()]) - at(mesh, loop[i])).norm();
  return length;
}

// Return the outward unit normal of the cap that closes a loop, as if the cap were flat.
Vec3 normalOf(const Mesh& mesh, const Loop& loop) {
  const Vec3 origin = at(mesh, loop[0]);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (at(mesh, loop[i]) - origin).cross(at(mesh, loop[(i + 1) % loop.size()]) - origin);
  return sum.norm() > 0.0 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitZ());
}

// Add walls from a loop down to a plane `depth` below its lowest vertex. Return the loop in that plane.
Loop addWalls(Mesh& mesh, const Loop& loop, double depth) {
  const Vec3 down = normalOf(mesh, loop);
  double lowest = -HUGE_VAL;
  for (const VertexHandle v : loop) lowest = std::max(lowest, down.dot(at(mesh, v)));
  Loop below;
  for (const VertexHandle v : loop) {
    const Vec3 p = at(mesh, v);
    below.push_back(mesh.add_vertex(pointOf(p + (lowest + depth - down.dot(p)) * down)));
  }
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t next = (i + 1) % loop.size();
    addFaceTo(mesh, loop[i], loop[next], below[next]);
    addFaceTo(mesh, loop[i], below[next], below[i]);
  }
  return below;
}

// Add triangles from a loop to a new vertex in its middle.
bool addFan(Mesh& mesh, const Loop& loop) {
  Vec3 middle = Vec3::Zero();
  for (const VertexHandle v : loop) middle += at(mesh, v) / static_cast<double>(loop.size());
  const VertexHandle centre = mesh.add_vertex(pointOf(middle));
  bool isWhole = true;
  for (std::size_t i = 0; i < loop.size(); ++i)
    isWhole = addFaceTo(mesh, loop[i], loop[(i + 1) % loop.size()], centre).is_valid() && isWhole;
  return isWhole;
}

// Fill a loop by ear clipping (Meisters 1975), seen along the loop's normal, ear with the shortest diagonal first. An
// ear is skipped if its diagonal is already an edge of the mesh. If no ear remains, a fan closes the rest. Return false
// if part of the loop stays open.
bool fillLoop(Mesh& mesh, Loop loop) {
  const Vec3 normal = normalOf(mesh, loop), u = normal.unitOrthogonal(), w = normal.cross(u);
  using Point2 = Eigen::Vector2d;
  std::vector<Point2> flat;
  for (const VertexHandle v : loop) flat.emplace_back(u.dot(at(mesh, v)), w.dot(at(mesh, v)));
  const auto side = [](const Point2& a, const Point2& b, const Point2& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  const auto isFree = [&](VertexHandle a, VertexHandle b) { return a != b && !mesh.find_halfedge(a, b).is_valid(); };
  const auto measure = [&](std::size_t i) -> double {  // length of the diagonal; infinite if it is not an ear
    const std::size_t n = loop.size(), before = (i + n - 1) % n, after = (i + 1) % n;
    if (!isFree(loop[after], loop[before])) return HUGE_VAL;
    const Point2 &a = flat[before], &b = flat[i], &c = flat[after];
    if (!(side(a, b, c) > 0.0)) return HUGE_VAL;
    for (std::size_t k = 0; k < n; ++k) {
      if (k == before || k == i || k == after) continue;
      const Point2& p = flat[k];
      if (side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0) return HUGE_VAL;
    }
    return (at(mesh, loop[after]) - at(mesh, loop[before])).norm();
  };
  std::vector<double> ear;
  for (std::size_t i = 0; i < loop.size(); ++i) ear.push_back(measure(i));
  while (loop.size() > 3) {
    const auto least = std::min_element(ear.begin(), ear.end());
    if (!(*least < HUGE_VAL)) {
      // The polygon overlaps itself in this projection: cut the corner with the shortest diagonal instead.
      const auto fold = [&](std::size_t i) {
        const std::size_t n = loop.size();
        const VertexHandle a = loop[(i + n - 1) % n], b = loop[(i + 1) % n];
        return isFree(b, a) ? (at(mesh, b) - at(mesh, a)).norm() : HUGE_VAL;
      };
      for (std::size_t i = 0; i < loop.size(); ++i) ear[i] = fold(i);
      if (!(*std::min_element(ear.begin(), ear.end()) < HUGE_VAL)) return addFan(mesh, loop);
      continue;
    }
    const auto i = static_cast<std::size_t>(least - ear.begin());
    const std::size_t n = loop.size();
    if (!addFaceTo(mesh, loop[(i + n - 1) % n], loop[i], loop[(i + 1) % n]).is_valid()) return false;
    const auto offset = static_cast<std::ptrdiff_t>(i);
    loop.erase(loop.begin() + offset);
    flat.erase(flat.begin() + offset);
    ear.erase(ear.begin() + offset);
    for (const std::size_t k : {(i + n - 2) % (n - 1), i % (n - 1)}) ear[k] = measure(k);
  }
  return addFaceTo(mesh, loop[0], loop[1], loop[2]).is_valid();
}

// Where several sheets meet in one vertex, keep the largest one only. Otherwise the caps of the openings beside them
// would touch each other.
void clearCorners(Mesh& mesh, PrepareReport& report) {
  constexpr int kRounds = 8;  // clearing a corner may create another one
  const auto before = static_cast<int>(mesh.n_faces());
  for (int round = 0; round < kRounds; ++round) {
    std::vector<OpenMesh::FaceHandle> faces;
    for (const auto v : mesh.vertices()) {
      std::vector<OpenMesh::FaceHandle> ring;  // an invalid handle marks an opening
      for (const auto h : mesh.voh_range(v)) ring.push_back(mesh.face_handle(h));
      const auto isOpening = [](OpenMesh::FaceHandle f) { return !f.is_valid(); };
      if (std::count_if(ring.begin(), ring.end(), isOpening) < 2) continue;
      std::rotate(ring.begin(), std::find_if(ring.begin(), ring.end(), isOpening), ring.end());
      std::vector<std::vector<OpenMesh::FaceHandle>> sheets;
      for (const OpenMesh::FaceHandle f : ring) {
        if (isOpening(f))
          sheets.emplace_back();
        else
          sheets.back().push_back(f);
      }
      const auto largest = std::max_element(sheets.begin(), sheets.end(),
                                            [](const auto& a, const auto& b) { return a.size() < b.size(); });
      for (auto sheet = sheets.begin(); sheet != sheets.end(); ++sheet)
        if (sheet != largest) faces.insert(faces.end(), sheet->begin(), sheet->end());
    }
    if (faces.empty()) break;
    for (const auto f : faces)
      if (!mesh.status(f).deleted()) mesh.delete_face(f, true);
    mesh.garbage_collection();
  }
  report.misfitTriangles += before - static_cast<int>(mesh.n_faces());
}

void close(Mesh& mesh, double base, PrepareReport& report) {
  clearCorners(mesh, report);
  std::vector<Loop> loops = findLoops(mesh);
  if (base > 0.0 && !loops.empty()) {
    const auto longest = std::max_element(loops.begin(), loops.end(), [&](const Loop& a, const Loop& b) {
      return lengthOf(mesh, a) < lengthOf(mesh, b);
    });
    *longest = addWalls(mesh, *longest, base);
  }
  for (const Loop& loop : loops) report.closedHoles += loop.size() > 2 && fillLoop(mesh, loop) ? 1 : 0;
  report.openHoles = static_cast<int>(findLoops(mesh).size());
  mesh.delete_isolated_vertices();
  mesh.garbage_collection();
}

constexpr float kMostTurn = 30.0f;  // degrees that a collapse may turn a face: a fold lets the mesh cross itself

// Collapse edges with OpenMesh, smallest quadric error first (Garland & Heckbert 1997).
Mesh decimated(Mesh mesh, std::size_t faces) {
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_halfedge_status();
  mesh.request_face_status();
  mesh.request_face_normals();
  mesh.update_face_normals();
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(flipping);
  decimater.module(quadric).unset_max_err();
  decimater.module(flipping).set_max_normal_deviation(kMostTurn);
  decimater.initialize();
  decimater.decimate_to_faces(0, faces);
  mesh.garbage_collection();
  return mesh;
}

Deviation deviation(const TriangleMesh& of, const MeshModel& from) {
  Deviation result;
  ProximityCache cache;
  double sum = 0.0;
  const auto look = [&](const Vec3& p) {
    const double distance = closestPoint(from, p, &cache).distance;
    result.most = std::max(result.most, distance);
    sum += distance * distance;
    ++result.points;
  };
  std::vector<char> isSeen(of.vertices.size(), 0);
  for (const auto& t : of.triangles) {
    std::array<Vec3, 3> v;
    for (std::size_t i = 0; i < 3; ++i) {
      v[i] = of.vertices[static_cast<std::size_t>(t[i])];
      char& isDone = isSeen[static_cast<std::size_t>(t[i])];
      if (isDone == 0) look(v[i]);
      isDone = 1;
    }
    look((v[0] + v[1] + v[2]) / 3.0);
    // Sample every edge from both of its triangles: in a file each triangle may have its own vertices.
    for (std::size_t i = 0; i < 3; ++i) look(0.5 * (v[i] + v[(i + 1) % 3]));
  }
  result.rms = std::sqrt(sum / result.points);
  return result;
}

TriangleMesh asWritten(TriangleMesh mesh) {
  for (Vec3& v : mesh.vertices) v = 1e-3 * (1e3 * v).cast<float>().cast<double>();
  return mesh;
}

struct Candidate {
  TriangleMesh mesh;
  Deviation there, back;
};

// Search for about the fewest triangles whose deviation, measured both ways, is within `most` m. Divide the number by 4
// while the deviation allows it, then bisect on a logarithmic scale.
Candidate decimateWithin(const Mesh& mesh, const TriangleMesh& closed, double most) {
  const MeshModel model(closed);
  const auto candidate = [&](std::size_t faces) {
    Candidate c{asWritten(fromOpenMesh(decimated(mesh, faces))), {}, {}};
    c.there = deviation(closed, MeshModel(c.mesh));
    c.back = deviation(c.mesh, model);
    return c;
  };
  std::optional<Candidate> best;
  double good = static_cast<double>(closed.triangles.size()), bad = 4.0;
  for (double faces = good / 4.0; good > 1.1 * bad && faces >= 4.0;) {
    Candidate c = candidate(static_cast<std::size_t>(faces));
    const bool isGood = std::max(c.there.most, c.back.most) <= most;
    (isGood ? good : bad) = faces;
    const bool isStuck = static_cast<double>(c.mesh.triangles.size()) > 1.1 * faces;  // no edge left to collapse
    if (isGood) best = std::move(c);
    if (isGood && isStuck) break;
    faces = isGood && bad == 4.0 ? good / 4.0 : std::sqrt(good * bad);
  }
  return best ? *best : Candidate{closed, {}, {}};
}

}  // namespace

TriangleMesh prepareMesh(const TriangleMesh& mesh, const PrepareOptions& options, PrepareReport& report) {
  checkMesh(mesh);
  report = PrepareReport();
  Mesh manifold = buildManifold(joinVertices(mesh, report), report);
  close(manifold, options.base, report);
  if (manifold.n_faces() == 0) throw Error("the mesh has no triangle that can be used");
  TriangleMesh closed = fromOpenMesh(manifold);
  if (inspect(closed).inwards) {
    for (auto& t : closed.triangles) std::swap(t[1], t[2]);
    manifold = toOpenMesh<Mesh>(closed);
    report.turnedTriangles = static_cast<int>(closed.triangles.size());
  }
  closed = asWritten(std::move(closed));
  report.beforeDecimation = static_cast<int>(closed.triangles.size());
  TriangleMesh result = closed;
  if (options.deviation > 0.0) {
    Candidate c = decimateWithin(manifold, closed, options.deviation);
    result = std::move(c.mesh);
    report.fromClosed = c.there;
    report.toClosed = c.back;
  }
  report.fromFile = deviation(mesh, MeshModel(result));
  return result;
}

}  // namespace enamel::app
