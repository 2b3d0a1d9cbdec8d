// Mesh files of each format, and uses of the accepted meshes: contacts, a solid, cuts.
#include <algorithm>
#include <memory>
#include <string>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/core/error.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

constexpr std::size_t kMostTrianglesUsed = 300;

void useContacts(const std::shared_ptr<const MeshModel>& model, const Vec3& middle, double size) {
  Scene scene;
  scene.add({"mesh", model, Pose(), Vec6::Zero(), {}});
  Tool tool;
  tool.parts[0] = {Vec3::Zero(), Vec3(0.0, 0.0, std::min(0.1, size)), std::min(0.01, 0.1 * size)};
  ToolTrack track = makeToolTrack(scene, tool);
  ContactSnapshot contacts;
  Pose pose;
  for (int i = 0; i < 5; ++i) {
    pose.position = middle + Vec3(0.1, 0.2, 0.6 - 0.2 * i) * size;
    const Status status = followContacts(scene, tool, pose, 1e-3, track, contacts);
    if (pose.position.norm() < kFarthestTool) require(status == Status::ok, "contacts are found");
    for (int k = 0; k < contacts.count; ++k) {
      const Contact& contact = contacts.contacts[static_cast<std::size_t>(k)];
      require(contact.point.allFinite() && std::isfinite(contact.gap), "contacts are finite");
      require(std::abs(contact.normal.squaredNorm() - 1.0) <= 1e-6, "renderers accept normals");
    }
  }
}

void useSolid(const MeshModel& model, const Vec3& middle, double size) {
  SolidOptions options;
  options.cell = size / 20.0;
  try {
    Solid solid(model, {SolidLayer{}}, options);
    const double before = solid.volume()[0];
    const Segment from{middle, middle}, to{middle + Vec3(0.0, 0.0, 0.01), middle};
    double reached = 0.0;
    const double removed = solid.cut(from, to, std::min(Solid::kLargestBur, 0.1 * size), &reached)[0];
    require(reached >= 0.0 && reached <= 1.0, "a cut ends between its ends");
    require(std::isfinite(removed) && removed >= 0.0, "a cut adds nothing");
    solid.restore();
    require(std::abs(solid.volume()[0] - before) <= 1e-9 * std::abs(before), "restore() puts all back");
  } catch (const Error&) {  // the mesh is not closed
  }
}

void attackMesh(std::string_view bytes, const char* path) {
  try {
    const TriangleMesh mesh = parseMesh(bytes, path);
    const auto vertices = static_cast<int>(mesh.vertices.size());
    for (const auto& triangle : mesh.triangles)
      for (const int corner : triangle) require(corner >= 0 && corner < vertices, "corners are vertices");
    for (const Vec3& vertex : mesh.vertices) require(vertex.allFinite(), "vertices are finite");
    const MeshReport report = inspect(mesh);
    if (mesh.triangles.size() > kMostTrianglesUsed) return;
    const auto model = std::make_shared<const MeshModel>(mesh);
    const Vec3 middle = 0.5 * (report.low + report.high);
    const double size = (report.high - report.low).maxCoeff();
    useContacts(model, middle, size);
    if (report.watertight && size > 0.0) useSolid(*model, middle, size);
  } catch (const Error&) {
  }
}

const Registration kMeshes[] = {{"ply", [](std::string_view bytes) { attackMesh(bytes, "a.ply"); }},
                                {"obj", [](std::string_view bytes) { attackMesh(bytes, "a.obj"); }},
                                {"stl", [](std::string_view bytes) { attackMesh(bytes, "a.stl"); }},
                                {"off", [](std::string_view bytes) { attackMesh(bytes, "a.off"); }}};

}  // namespace

}  // namespace enamel::attack
