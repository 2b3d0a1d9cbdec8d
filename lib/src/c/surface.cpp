// Triangles of a solid for hosts that draw it.
#include "c/convert.hpp"
#include "core/message.hpp"
#include "enamel/collision/solid_surface.hpp"

namespace enamel::c {
namespace {

void copy(const std::vector<Vec3>& from, double* to) noexcept {
  for (const Vec3& v : from) to = std::copy_n(v.data(), 3, to);
}

}  // namespace

bool takeSurface(Session& session, ObstacleId id, EnamelSurface& out) {
  require(out.vertices != nullptr && out.normals != nullptr && out.layers != nullptr && out.triangles != nullptr,
          "EnamelSurface needs memory for vertices, normals, layers and triangles");
  require(out.vertex_capacity >= ENAMEL_SURFACE_VERTICES && out.triangle_capacity >= ENAMEL_SURFACE_TRIANGLES,
          "EnamelSurface has room for " + std::to_string(out.vertex_capacity) + " vertices and " +
              std::to_string(out.triangle_capacity) + " triangles, must be at least " +
              std::to_string(ENAMEL_SURFACE_VERTICES) + " and " + std::to_string(ENAMEL_SURFACE_TRIANGLES));
  const std::shared_ptr<const Solid> solid = session.solid(id);
  require(solid != nullptr, "the obstacle is not a solid");
  require(out.brick >= -1 && out.brick < solid->bricks(), "EnamelSurface.brick is " + std::to_string(out.brick) +
                                                              ", must be in -1 to " +
                                                              std::to_string(solid->bricks() - 1));
  BrickChange change;
  if (out.brick >= 0) {
    change.brick = out.brick;
    change.samples = solid->samples(out.brick);
  } else if (!session.takeChange(id, change)) {
    return false;
  }
  SolidSurface surface;
  appendSurface(*solid, change.brick, change.samples, surface);
  require(surface.mesh.vertices.size() <= out.vertex_capacity && surface.mesh.triangles.size() <= out.triangle_capacity,
          "a brick has more triangles than EnamelSurface has room for");
  out.brick = change.brick;
  out.vertex_count = surface.mesh.vertices.size();
  out.triangle_count = surface.mesh.triangles.size();
  copy(surface.mesh.vertices, out.vertices);
  copy(surface.normals, out.normals);
  std::copy(surface.layers.begin(), surface.layers.end(), out.layers);
  std::int32_t* corner = out.triangles;
  for (const auto& triangle : surface.mesh.triangles) corner = std::copy(triangle.begin(), triangle.end(), corner);
  return true;
}

}  // namespace enamel::c
