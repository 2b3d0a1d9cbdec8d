#include "mesh_output.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel::app {
namespace {

template <typename Value>
void put(const Value& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put(const Vec3& v, std::string& bytes) {
  for (int k = 0; k < 3; ++k) put(static_cast<float>(v[k]), bytes);
}

void writeStl(const TriangleMesh& mesh, const std::string& path) {
  std::string bytes("units mm");
  bytes.resize(80, ' ');
  put(static_cast<std::uint32_t>(mesh.triangles.size()), bytes);
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    put(Vec3((b - a).cross(c - a).normalized()), bytes);
    for (const Vec3* v : {&a, &b, &c}) put(Vec3(1e3 * *v), bytes);
    put(std::uint16_t{0}, bytes);
  }
  writeFile(path, bytes);
}

}  // namespace

void checkMeshOutput(const std::string& path) {
  const std::string ending = std::filesystem::u8path(path).extension().u8string();
  if (!ending.empty() && ending != ".ply" && ending != ".stl")
    throw Error(path + ": the extension must be .ply or .stl");
}

void writeMesh(const TriangleMesh& mesh, const std::string& path, const std::vector<Vec3>& colours) {
  if (std::filesystem::u8path(path).extension() == ".stl") return writeStl(mesh, path);
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment units mm\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\n{}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n",
      mesh.triangles.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    put(Vec3(1e3 * mesh.vertices[v]), bytes);
    for (int k = 0; k < 3 && !colours.empty(); ++k)
      put(static_cast<std::uint8_t>(std::lround(255.0 * colours[v][k])), bytes);
  }
  for (const auto& t : mesh.triangles) {
    put(std::uint8_t{3}, bytes);
    for (const int v : t) put(static_cast<std::int32_t>(v), bytes);
  }
  writeFile(path, bytes);
}

}  // namespace enamel::app
