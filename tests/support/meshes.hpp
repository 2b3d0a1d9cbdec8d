// Meshes for the tests: regular ones, broken ones of many kinds, and large ones if installed. Reference computations
// use other formulas than the library.
#pragma once

#include <string>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "support/devices.hpp"

namespace enamel::test {

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
  bool closed = false;  // closed and without self-intersection: the sign is defined
};

TriangleMesh boxMesh(const Vec3& half);

/// Divide each triangle into four at the middles of its edges.
TriangleMesh subdivide(const TriangleMesh& mesh);

/// Return a sphere of radius 1 whose surface has waves of amplitude `waves`.
TriangleMesh ball(int levels, double waves = 0.0);

TriangleMesh transformed(TriangleMesh mesh, double scale, const Vec3& shift);

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b);

/// Return a closed wedge of length 1 with an edge of `angle` rad.
TriangleMesh wedge(double angle);

std::vector<NamedMesh> brokenMeshes();

std::vector<NamedMesh> soundMeshes();

/// Return the folder of the large meshes, which are not part of the project; empty if they are not installed.
std::string largeMeshFolder();

/// Return the distance from a triangle in long double: with axes in its plane, signs of areas, and else the nearest
/// edge.
double referenceDistance(const Vec3& point, const Vec3& va, const Vec3& vb, const Vec3& vc);

/// The same for all triangles. A triangle is skipped if its bounding ball cannot be nearest.
class ReferenceDistance {
 public:
  explicit ReferenceDistance(const TriangleMesh& mesh);
  double operator()(const Vec3& p) const;

 private:
  double exact(const Vec3& p, std::size_t i) const;
  const TriangleMesh& mesh_;
  std::vector<Vec3> centres_;
  std::vector<double> radii_;
};

/// Return how often a closed surface encloses a point: solid angles (van Oosterom & Strackee 1983, eq. 8) divided by 4
/// pi.
double windingNumber(const TriangleMesh& mesh, const Vec3& p);

double sizeOf(const TriangleMesh& mesh);

/// Return a point of any kind: near the mesh, on its corners, edges and faces, exactly opposite them, or far away.
Vec3 queryPoint(const TriangleMesh& mesh, double size, Random& random);

}  // namespace enamel::test
