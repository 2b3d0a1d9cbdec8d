// OpenMesh triangle meshes as obstacles that can be edited in use (TriMesh_ArrayKernelT of any traits, float or
// double). Vertex and face handles equal the numbers of vertices and triangles, also after edits. Coordinates are in m.
// Programs that include this header must link OpenMeshCore.
#pragma once

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/mesh_changes.hpp"
#include "enamel/collision/mesh_update.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

template <typename Point>
Vec3 fromOpenMeshPoint(const Point& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// Convert an OpenMesh mesh to vertices and triangles. Throws Error if elements are marked as deleted: call
/// garbage_collection() first. Realtime: no.
template <typename Mesh>
TriangleMesh fromOpenMesh(const Mesh& mesh) {
  TriangleMesh result;
  result.vertices.reserve(mesh.n_vertices());
  result.triangles.reserve(mesh.n_faces());
  for (std::size_t i = 0; i < mesh.n_vertices(); ++i) {
    const OpenMesh::VertexHandle v(static_cast<int>(i));
    if (mesh.has_vertex_status() && mesh.status(v).deleted())
      throw Error("vertex " + std::to_string(i) + " is marked as deleted: call garbage_collection() before");
    result.vertices.push_back(fromOpenMeshPoint(mesh.point(v)));
  }
  for (std::size_t i = 0; i < mesh.n_faces(); ++i) {
    const OpenMesh::FaceHandle f(static_cast<int>(i));
    if (mesh.has_face_status() && mesh.status(f).deleted())
      throw Error("face " + std::to_string(i) + " is marked as deleted: call garbage_collection() before");
    auto v = mesh.cfv_begin(f);
    std::array<int, 3>& t = result.triangles.emplace_back();
    for (int& corner : t) corner = (v++)->idx();
  }
  return result;
}

/// Add a face to any mesh without messages on OpenMesh's error stream. Return an invalid handle if a corner is
/// repeated, an edge already has a face on this side, or a corner has no opening for the face. Realtime: no.
template <typename Mesh>
OpenMesh::FaceHandle addFaceTo(Mesh& mesh, OpenMesh::VertexHandle a, OpenMesh::VertexHandle b,
                               OpenMesh::VertexHandle c) {
  const std::array<OpenMesh::VertexHandle, 3> v{a, b, c};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!mesh.is_valid_handle(v[i]) || v[i] == v[(i + 1) % 3] || !mesh.is_boundary(v[i])) return OpenMesh::FaceHandle();
    const OpenMesh::HalfedgeHandle side = mesh.find_halfedge(v[i], v[(i + 1) % 3]);
    if (side.is_valid() && !mesh.is_boundary(side)) return OpenMesh::FaceHandle();
    // Between two existing edges the face fills a gap; the rest of this gap must fit into another one.
    const OpenMesh::HalfedgeHandle next = mesh.find_halfedge(v[(i + 1) % 3], v[(i + 2) % 3]);
    if (!side.is_valid() || !next.is_valid() || mesh.next_halfedge_handle(side) == next) continue;
    OpenMesh::HalfedgeHandle gap = mesh.opposite_halfedge_handle(next);
    do {
      gap = mesh.opposite_halfedge_handle(mesh.next_halfedge_handle(gap));
    } while (!mesh.is_boundary(gap));
    if (gap == side || mesh.next_halfedge_handle(gap) == next) return OpenMesh::FaceHandle();
  }
  return mesh.add_face(a, b, c);
}

/// Convert vertices and triangles to an OpenMesh mesh. Throws Error with the number of the first triangle that OpenMesh
/// cannot add to those before it (addFaceTo()). Realtime: no.
template <typename Mesh>
Mesh toOpenMesh(const TriangleMesh& mesh) {
  using Scalar = typename Mesh::Scalar;
  Mesh result;
  result.reserve(mesh.vertices.size(), 3 * mesh.triangles.size() / 2, mesh.triangles.size());
  for (const Vec3& v : mesh.vertices)
    result.add_vertex(
        typename Mesh::Point(static_cast<Scalar>(v.x()), static_cast<Scalar>(v.y()), static_cast<Scalar>(v.z())));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto handle = [&](int i) { return OpenMesh::VertexHandle(mesh.triangles[t][static_cast<std::size_t>(i)]); };
    if (!addFaceTo(result, handle(0), handle(1), handle(2)).is_valid())
      throw Error("triangle " + std::to_string(t) +
                  " does not fit into an OpenMesh mesh: a corner is repeated, or more than two triangles meet");
  }
  return result;
}

/// An OpenMesh mesh, its model for a scene, and the list of changes for a thread that draws. Edits through this class
/// reach all three. Deleted elements stay and are marked, so handles keep their meaning. Threads: no other thread may
/// query the model during an edit; one other thread may call takeChanges() at any time.
template <typename Mesh>
class EditableMesh {
 public:
  using Point = typename Mesh::Point;

  /// `spare`: room for additions. Throws Error as fromOpenMesh() and MeshModel, and for a vertex without faces that is
  /// too far away for moveVertices(). Realtime: no.
  explicit EditableMesh(Mesh mesh, SpareCapacity spare = {})
      : mesh_(std::move(mesh)),
        model_(std::make_shared<MeshModel>(fromOpenMesh(mesh_), spare)),
        changes_(static_cast<int>(mesh_.n_vertices()) + spare.vertices,
                 static_cast<int>(mesh_.n_faces()) + spare.triangles) {
    mesh_.request_vertex_status();
    mesh_.request_edge_status();
    mesh_.request_halfedge_status();
    mesh_.request_face_status();
    const auto moreFaces = static_cast<std::size_t>(spare.triangles);
    mesh_.reserve(mesh_.n_vertices() + static_cast<std::size_t>(spare.vertices), mesh_.n_edges() + 3 * moreFaces,
                  mesh_.n_faces() + moreFaces);
    numbers_.reserve(std::max(mesh_.n_vertices() + static_cast<std::size_t>(spare.vertices), mesh_.n_faces()));
    positions_.reserve(numbers_.capacity());
    for (const auto v : mesh_.vertices()) {
      const Vec3 position = fromOpenMeshPoint(mesh_.point(v));
      const int number = v.idx();
      if (mesh_.is_isolated(v) && enamel::moveVertices(*model_, &number, &position, 1) != Status::ok)
        throw Error("vertex " + std::to_string(number) + " has no faces and lies too far away from them");
    }
  }

  /// Return the OpenMesh mesh with half-edges, adjacency and attributes. Deleted elements are marked.
  const Mesh& mesh() const noexcept { return mesh_; }

  /// Return the model for Obstacle::shape.
  std::shared_ptr<const MeshModel> model() const noexcept { return model_; }

  /// Move vertices, as enamel::moveVertices(). Realtime: yes, for at most as many vertices as the mesh has.
  [[nodiscard]] Status moveVertices(const OpenMesh::VertexHandle* vertices, const Point* points, int count) {
    numbers_.clear();
    positions_.clear();
    for (int i = 0; i < count; ++i) {
      numbers_.push_back(vertices[i].idx());
      positions_.push_back(fromOpenMeshPoint(points[i]));
    }
    if (const Status status = enamel::moveVertices(*model_, numbers_.data(), positions_.data(), count);
        status != Status::ok)
      return status;
    for (int i = 0; i < count; ++i) {
      mesh_.set_point(vertices[i], points[i]);
      changes_.recordVertex(vertices[i].idx(), positions_[static_cast<std::size_t>(i)]);
    }
    return Status::ok;
  }

  /// Remove faces, as removeTriangles(). Vertices stay, also those without faces. Realtime: no, OpenMesh allocates.
  [[nodiscard]] Status deleteFaces(const OpenMesh::FaceHandle* faces, int count) {
    numbers_.clear();
    for (int i = 0; i < count; ++i) numbers_.push_back(faces[i].idx());
    if (const Status status = removeTriangles(*model_, numbers_.data(), count); status != Status::ok) return status;
    for (int i = 0; i < count; ++i) {
      if (mesh_.status(faces[i]).deleted()) continue;
      mesh_.delete_face(faces[i], false);
      changes_.recordTriangle(faces[i].idx(), {-1, -1, -1});
    }
    return Status::ok;
  }

  /// Add a vertex. If addVertices() rejects it, return an invalid handle and change nothing. Realtime: yes.
  OpenMesh::VertexHandle addVertex(const Point& point) {
    const Vec3 position = fromOpenMeshPoint(point);
    if (addVertices(*model_, &position, 1) != Status::ok) return OpenMesh::VertexHandle();
    const OpenMesh::VertexHandle vertex = mesh_.add_vertex(point);
    changes_.recordVertex(vertex.idx(), position);
    return vertex;
  }

  /// Add a face. If the spare capacity is used up or OpenMesh cannot hold the face (addFaceTo()), return an invalid
  /// handle and change nothing. Realtime: no, OpenMesh allocates.
  OpenMesh::FaceHandle addFace(OpenMesh::VertexHandle a, OpenMesh::VertexHandle b, OpenMesh::VertexHandle c) {
    if (spareCapacity(*model_).triangles == 0) return OpenMesh::FaceHandle();
    const OpenMesh::FaceHandle face = addFaceTo(mesh_, a, b, c);
    if (!face.is_valid()) return face;
    const std::array<int, 3> corners{a.idx(), b.idx(), c.idx()};
    static_cast<void>(addTriangles(*model_, &corners, 1));  // there is room, and all vertices are near enough
    changes_.recordTriangle(face.idx(), corners);
    return face;
  }

  /// End an edit: MeshChanges::publish(). Realtime: yes.
  std::uint64_t publish() noexcept { return changes_.publish(); }

  /// Take the changes: MeshChanges::take(), on the reading thread. Realtime: yes.
  const MeshChange* takeChanges() noexcept { return changes_.take(); }

 private:
  Mesh mesh_;
  std::shared_ptr<MeshModel> model_;
  MeshChanges changes_;
  std::vector<int> numbers_;
  std::vector<Vec3> positions_;
};

}  // namespace enamel
