// A drill in an OpenMesh mesh. Three copies stay equal, edit by edit: the application's mesh, the obstacle that the
// tool touches, and the copy of the graphics thread.
//
//   openmesh_drill molar.ply
#include <array>
#include <atomic>
#include <cstdio>
#include <thread>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/openmesh.hpp"
#include "enamel/collision/scene.hpp"

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: openmesh_drill MESH (in mm)\n"), 1;
  try {
    constexpr int kTicks = 200;
    enamel::EditableMesh<Mesh> tooth(enamel::toOpenMesh<Mesh>(enamel::loadMesh(argv[1], 1e-3)), {kTicks, 3 * kTicks});
    enamel::Scene scene;  // the scene of a HapticTick
    scene.add({"tooth", tooth.model(), enamel::Pose(), enamel::Vec6::Zero(), {}});

    // The graphics thread receives changed triangles only.
    std::atomic<bool> isOver{false};
    std::size_t told = 0;
    std::thread graphics([&] {
      for (bool isLast = false; !isLast; std::this_thread::yield()) {
        isLast = isOver.load();
        while (const enamel::MeshChange* change = tooth.takeChanges()) told += change->triangles.size();
      }
    });

    // Edits between two ticks: lower a vertex at the bur, or replace a face by three deeper ones.
    for (int tick = 0; tick < kTicks; ++tick) {
      const enamel::Vec3 bur(1e-5 * tick, 0.0, 0.01);
      const enamel::SurfacePoint touched = closestPoint(*tooth.model(), bur);
      const Mesh& mesh = tooth.mesh();
      const OpenMesh::FaceHandle face(touched.triangle);
      const Mesh::Point down(0.0f, 0.0f, -2e-5f);
      if (tick % 2 == 0) {
        const OpenMesh::VertexHandle vertex = mesh.to_vertex_handle(mesh.halfedge_handle(face));
        const Mesh::Point place = mesh.point(vertex) + down;
        if (tooth.moveVertices(&vertex, &place, 1) != enamel::Status::ok) break;
      } else {
        std::array<OpenMesh::VertexHandle, 3> v;
        auto corner = mesh.cfv_begin(face);
        for (OpenMesh::VertexHandle& each : v) each = *corner++;
        const Mesh::Point place = mesh.calc_face_centroid(face) + down;
        if (tooth.deleteFaces(&face, 1) != enamel::Status::ok) break;
        const OpenMesh::VertexHandle tip = tooth.addVertex(place);
        for (std::size_t i = 0; i < 3; ++i) tooth.addFace(v[i], v[(i + 1) % 3], tip);
      }
      tooth.publish();
    }
    isOver = true;
    graphics.join();
    tooth.publish();  // changes that waited for the graphics thread
    for (const enamel::MeshChange* rest; (rest = tooth.takeChanges()) != nullptr; tooth.publish())
      told += rest->triangles.size();
    std::printf("%zu faces, %zu sent to the graphics; %s\n", tooth.mesh().n_faces(), told,
                describe(*tooth.model()).c_str());
    return isSound(*tooth.model()) ? 0 : 1;
  } catch (const enamel::Error& error) {
    std::fprintf(stderr, "openmesh_drill: %s\n", error.what());
    return 1;
  }
}
