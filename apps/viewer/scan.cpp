#include "scan.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"

namespace enamel::viewer {

bool isScan(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".ply" || ending == ".obj" || ending == ".stl" || ending == ".off";
}

SceneFile sceneOfScan(const std::string& path) {
  constexpr double smallest = 0.002, largest = 0.5, below = 0.004, above = 0.008;  // m
  constexpr double friction = 0.2;                                                 // as in the shipped teeth
  TriangleMesh mesh = loadMesh(path);
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& v : mesh.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const double longest = (high - low).maxCoeff();
  struct Unit {
    const char* name;
    double metres;
  };
  constexpr Unit units[] = {{"mm", 1e-3}, {"m", 1.0}, {"um", 1e-6}};
  const Unit* const unit = std::find_if(std::begin(units), std::end(units), [longest](const Unit& u) {
    return longest * u.metres >= smallest && longest * u.metres <= largest;
  });
  const std::string name = std::filesystem::path(path).filename().string();
  if (unit == std::end(units))
    throw Error(name + ": its longest side is " + std::to_string(longest) +
                " units, must be 2 to 500 mm in one of the units mm, m and um");
  const Vec3* top = &mesh.vertices.front();
  for (Vec3& v : mesh.vertices) {
    v *= unit->metres;
    if (v.z() > top->z()) top = &v;
  }
  const Vec3 origin = Vec3(0.0, 0.0, -below) - *top, size = 1e3 * unit->metres * (high - low);

  SceneFile scene;
  scene.name = std::filesystem::path(path).stem().string();
  scene.start = Vec3(0.0, 0.0, above);
  scene.tool.parts[0] = {Vec3(0.0, 0.0, 0.0006), Vec3(0.0, 0.0, 0.0006), 0.0006};
  scene.tool.parts[1] = {Vec3(0.0, 0.0, 0.0012), Vec3(0.0, 0.0, 0.022), 0.0004};
  scene.tool.count = 2;
  auto model = std::make_shared<MeshModel>(std::move(mesh));
  char text[96];
  std::snprintf(text, sizeof(text), ": %.1f x %.1f x %.1f mm, unit %s. ", size.x(), size.y(), size.z(), unit->name);
  scene.notes.push_back(name + text + describe(*model));
  Obstacle obstacle;
  obstacle.name = "scan";
  obstacle.shape = std::shared_ptr<const MeshModel>(model);
  obstacle.pose.position = origin;
  obstacle.material.friction = obstacle.material.slidingFriction = friction;
  scene.scene.add(std::move(obstacle));
  scene.meshes.push_back(std::move(model));
  scene.solids.push_back(nullptr);
  return scene;
}

}  // namespace enamel::viewer
