// Small solids for the scene, in mm of W.
#pragma once

#include <vtkActor.h>
#include <vtkAlgorithmOutput.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <array>
#include <functional>
#include <vector>

#include "colours/palette.hpp"
#include "enamel/collision/mesh.hpp"

namespace enamel::viewer {

inline constexpr double kMillimetres = 1e3;  // of the scene in a metre

/// How a solid looks.
struct Finish {
  unsigned colour;
  double opacity = 1.0;
  double shine = 0.15;  ///< 0: matt
};

void setFinish(vtkProperty* property, const Finish& finish);

vtkSmartPointer<vtkActor> addActor(vtkRenderer* renderer, vtkAlgorithmOutput* source, const Finish& finish);

/// A rod of radius `radius` (mm) between two points that place() sets, m; a cone where `sharp` (its apex at the first).
class Rod {
 public:
  Rod(vtkRenderer* renderer, double radius, const Finish& finish, bool sharp = false);
  void place(const Vec3& from, const Vec3& to, double thickness = 1.0);  ///< times its radius
  void show(bool visible);
  /// Shines through where it is within 3 mm of the line of sight from `eye` to just before `point`, m. True where it
  /// begins to, or ends.
  bool fadeBefore(const Vec3& eye, const Vec3& point);
  vtkActor* actor() const { return actor_; }

 private:
  vtkSmartPointer<vtkActor> actor_;
  double radius_;
  Vec3 from_ = Vec3::Zero(), to_ = Vec3::Zero();
};

/// A ball of radius `radius` (mm).
class Ball {
 public:
  Ball(vtkRenderer* renderer, double radius, const Finish& finish);
  void place(const Vec3& centre, double growth = 1.0);  ///< times its radius
  void show(bool visible) { actor_->SetVisibility(visible); }
  bool fadeBefore(const Vec3& eye, const Vec3& point);  ///< as a Rod
  vtkActor* actor() const { return actor_; }

 private:
  vtkSmartPointer<vtkActor> actor_;
  double radius_;
};

/// A rod with round ends.
class CapsuleSolid {
 public:
  CapsuleSolid(vtkRenderer* renderer, double radius, const Finish& finish);
  void place(const Vec3& from, const Vec3& to);
  void show(bool visible);
  std::array<vtkActor*, 3> actors() const { return {rod_.actor(), from_.actor(), to_.actor()}; }

 private:
  Rod rod_;
  Ball from_, to_;
};

/// A bur: a ball or capsule of radius `radius` (mm) with flutes around its axis, along which `length` (mm) is straight.
class FlutedBur {
 public:
  FlutedBur(vtkRenderer* renderer, double radius, double length);
  /// `from`: centre of its tip, m; `frame`: its axis is the third column; turned by an angle, rad.
  void place(const Vec3& from, const Mat3& frame, double angle);

 private:
  vtkSmartPointer<vtkActor> actor_;
};

/// Small flat triangles, as one actor.
class Shards {
 public:
  Shards(vtkRenderer* renderer, std::size_t count);
  /// A shard at `centre` (m) in the plane of two unit vectors; of size 0 (mm) nothing is seen of it.
  void place(std::size_t shard, const Vec3& centre, const Vec3& across, const Vec3& up, double size, unsigned colour);
  /// After all were placed.
  void show(bool visible);

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkFloatArray> normals_;
  vtkNew<vtkUnsignedCharArray> colours_;
  vtkSmartPointer<vtkActor> actor_;
};

/// Draws what shines through after all else of its renderer: it is blended with what is there. VTK's own pass, which
/// draws translucent things in any order into buffers of their own, is slow in software.
void drawLast(vtkRenderer* renderer, vtkActor* actor);

/// A mesh with smooth shading, `pose` in W; `colours` (0 to 1) of its vertices, or empty: that of the finish.
vtkSmartPointer<vtkActor> addMesh(vtkRenderer* renderer, const TriangleMesh& mesh, const Pose& pose,
                                  const Finish& finish, const std::vector<Vec3>& colours = {});

/// A convex polygon in W, m, and what is left of it outside the half space behind a plane.
using Polygon = std::vector<Vec3>;
Polygon cut(const Polygon& polygon, const Vec3& point, const Vec3& normal);

/// Flat faces, with their corners anticlockwise as seen from outside, and lines, as one actor each.
/// `colourAt`: of a corner; or empty, that of the finish.
vtkSmartPointer<vtkActor> addFaces(vtkRenderer* renderer, const std::vector<Polygon>& faces, const Finish& finish,
                                   const std::function<Vec3(const Vec3&)>& colourAt = {});
vtkSmartPointer<vtkActor> addLines(vtkRenderer* renderer, const std::vector<std::array<Vec3, 2>>& lines,
                                   unsigned colour, float width);

/// A light that stands at (x, y, z) in the camera's frame, where the camera is at (0, 0, 1) and looks at the origin.
void addLight(vtkRenderer* renderer, double x, double y, double z, double intensity);

}  // namespace enamel::viewer
