// Meshes for the tests: regular ones, a zoo of broken ones, the large ones where they are installed, and references
// that share no formula with the library.
#pragma once

#include <string>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "support/devices.hpp"

namespace enamel::test {

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
  bool closed = false;  // a volume without self-intersection: the sign is promised
};

TriangleMesh boxMesh(const Vec3& half);

/// Each triangle becomes four, joined at the middles of its edges.
TriangleMesh subdivide(const TriangleMesh& mesh);

/// A sphere of radius 1 whose surface waves by `waves`.
TriangleMesh ball(int levels, double waves = 0.0);

TriangleMesh transformed(TriangleMesh mesh, double scale, const Vec3& shift);

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b);

/// A closed wedge with an edge of `angle` rad, 1 long.
TriangleMesh wedge(double angle);

std::vector<NamedMesh> brokenMeshes();

std::vector<NamedMesh> soundMeshes();

/// Folder of the large meshes, empty where they are not installed. They are no part of the project.
std::string largeMeshFolder();

/// Distance from a triangle in long double: the plane's own orthonormal axes, signs of areas in the plane, else the
/// nearest of the edges.
double referenceDistance(const Vec3& point, const Vec3& va, const Vec3& vb, const Vec3& vc);

/// The same over all triangles; those whose ball cannot be nearest are skipped.
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

/// How often a closed surface goes round the point: solid angles (van Oosterom & Strackee 1983, eq. 8) over 4 pi.
double windingNumber(const TriangleMesh& mesh, const Vec3& p);

double sizeOf(const TriangleMesh& mesh);

/// Points of every kind: anywhere about the mesh, on its corners, edges and faces, exactly opposite to them, far away.
Vec3 queryPoint(const TriangleMesh& mesh, double size, Random& random);

}  // namespace enamel::test
