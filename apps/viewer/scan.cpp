#include "scan.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/core/error.hpp"

namespace enamel::viewer {
namespace {

bool endsWith(const std::string& path, std::initializer_list<const char*> endings) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

// Sums over the triangles of a mesh.
struct SurfaceSums {
  double area = 0.0;
  Vec3 vector = Vec3::Zero();  // sum of area times normal; zero if the mesh is closed
  Mat3 spread = Mat3::Zero();  // covariance of the area
};

SurfaceSums sumsOf(const TriangleMesh& mesh) {
  SurfaceSums surface;
  Vec3 mean = Vec3::Zero();
  for (const int pass : {0, 1})
    for (const auto& triangle : mesh.triangles) {
      const Vec3 &a = mesh.vertices[static_cast<std::size_t>(triangle[0])],
                 &b = mesh.vertices[static_cast<std::size_t>(triangle[1])],
                 &c = mesh.vertices[static_cast<std::size_t>(triangle[2])];
      const Vec3 vector = 0.5 * (b - a).cross(c - a), centre = (a + b + c) / 3.0;
      const double area = vector.norm();
      if (pass == 0) {
        surface.area += area;
        surface.vector += vector;
        mean += area * centre;
      } else {
        const Vec3 offset = centre - mean / surface.area;
        surface.spread += area / surface.area * offset * offset.transpose();
      }
    }
  return surface;
}

// Return the rotation that turns the occlusal side of a scan towards z.
Mat3 occlusalRotation(const TriangleMesh& mesh) {
  constexpr double open = 0.1, near = 0.866;  // share of the area; cosine of 30 deg
  const SurfaceSums surface = sumsOf(mesh);
  if (!(surface.vector.norm() > open * surface.area)) return Mat3::Identity();
  Vec3 up = surface.vector.normalized();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(surface.spread);
  const Vec3 flat = axes.eigenvectors().col(0);
  if (std::abs(flat.dot(up)) > near) up = flat.dot(up) > 0.0 ? flat : Vec3(-flat);
  return Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitZ()).toRotationMatrix();
}

struct Unit {
  const char* name;
  double metres;
};
constexpr Unit kUnits[] = {{"mm", 1e-3}, {"m", 1.0}, {"um", 1e-6}};

// Return the placement's unit, or the one in which the longest side is plausible.
const Unit& unitFor(double longest, const ScanPlacement& placement, const std::string& name) {
  constexpr double smallest = 0.002, largest = 0.5;  // m
  const Unit* const unit = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) {
    const bool fits = longest * u.metres >= smallest && longest * u.metres <= largest;
    return fits && (placement.unit.empty() || placement.unit == u.name);
  });
  if (unit == std::end(kUnits))
    throw Error(name + ": its longest side is " + std::to_string(longest) + " units, must be 2 to 500 mm in " +
                (placement.unit.empty() ? "one of the units mm, m and um" : "the unit " + placement.unit));
  return *unit;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string listOf(const Vec3& v) {
  char text[96];
  std::snprintf(text, sizeof(text), "[%.9g, %.9g, %.9g]", v.x(), v.y(), v.z());
  return text;
}

}  // namespace

bool isScan(const std::string& path) { return endsWith(path, {".ply", ".obj", ".stl", ".off"}); }
bool isRecording(const std::string& path) { return endsWith(path, {".rec"}); }

ScanScene sceneOfScan(const std::string& path, const ScanPlacement& placement) {
  constexpr double below = 0.004;  // m
  constexpr double degrees = 57.29577951308232;
  const std::filesystem::path file = std::filesystem::absolute(path);
  const std::string name = file.filename().string();
  const TriangleMesh mesh = loadMesh(path);
  const Mat3 turn = placement.turn * occlusalRotation(mesh);
  Vec3 low = turn * mesh.vertices.front(), high = low, top = low;
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 v = turn * vertex;
    low = low.cwiseMin(v), high = high.cwiseMax(v);
    if (v.z() > top.z()) top = v;
  }
  const Unit& unit = unitFor((high - low).maxCoeff(), placement, name);
  const Vec3 size = 1e3 * unit.metres * (high - low), position = Vec3(0.0, 0.0, -below) - unit.metres * top;
  const Vec3 zyx = turn.eulerAngles(2, 1, 0);

  ScanScene scene;
  char note[160];
  std::snprintf(note, sizeof(note), ": %.1f x %.1f x %.1f mm, unit %s%s. ", size.x(), size.y(), size.z(), unit.name,
                placement.unit.empty() ? ", guessed from the size" : "");
  scene.note = name + note;
  scene.note += inspect(mesh).boundaryEdges == 0
                    ? "The surface is closed."
                    : "The surface is open: touch its outer side. enamel mesh --prepare closes it.";
  scene.text = "# Made by enamel-viewer. " + scene.note + "\nname = " + quoted(file.stem().string()) +
               "\nstart = [0.0, 0.0, 0.008]\n\n"
               "[[tool]]\nfrom = [0.0, 0.0, 0.0006]\nradius = 0.0006\n"
               "[[tool]]\nfrom = [0.0, 0.0, 0.0012]\nto = [0.0, 0.0, 0.022]\nradius = 0.0004\n\n"
               "[[obstacle]]\nname = \"scan\"\nshape = \"mesh\"\nfile = " +
               quoted(file.string()) + "\nunit = \"" + unit.name + "\"\nposition = " + listOf(position) +
               "\neuler_deg = " + listOf(degrees * Vec3(zyx[2], zyx[1], zyx[0])) +
               "\nfriction = 0.2                          # as in the shipped teeth\n";
  return scene;
}

}  // namespace enamel::viewer
