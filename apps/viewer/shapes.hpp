// Moving bodies of the scene, in mm of W.
#pragma once

#include <vtkActor.h>
#include <vtkAlgorithmOutput.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <array>

#include "camera.hpp"
#include "colours/palette.hpp"

namespace enamel::viewer {

/// Appearance of a body.
struct Finish {
  unsigned colour;
  double opacity = 1.0;
  double shine = 0.15;  ///< 0: matt
};

void setFinish(vtkProperty* property, const Finish& finish);

vtkSmartPointer<vtkActor> addActor(vtkRenderer* renderer, vtkAlgorithmOutput* source, const Finish& finish);

vtkSmartPointer<vtkActor> addData(vtkRenderer* renderer, vtkPolyData* data, const Finish& finish);

/// A rod of radius `radius` (mm) between two points that place() sets, m; if `sharp`, a cone with its apex at the
/// first.
class Rod {
 public:
  Rod(vtkRenderer* renderer, double radius, const Finish& finish, bool sharp = false);
  void place(const Vec3& from, const Vec3& to, double thickness = 1.0);  ///< thickness: factor of the radius
  void show(bool visible);
  /// Make the rod transparent if it is within 3 mm of the line of sight from `eye` to just before `point`, m. Return
  /// true if the transparency begins or ends.
  bool fadeBefore(const Vec3& eye, const Vec3& point);
  vtkActor* actor() const { return actor_; }

 private:
  vtkSmartPointer<vtkActor> actor_;
  double radius_;
  Vec3 from_ = Vec3::Zero(), to_ = Vec3::Zero();
};

/// A sphere of radius `radius` (mm).
class Ball {
 public:
  Ball(vtkRenderer* renderer, double radius, const Finish& finish);
  void place(const Vec3& centre, double growth = 1.0);  ///< growth: factor of the radius
  void show(bool visible) { actor_->SetVisibility(visible); }
  bool fadeBefore(const Vec3& eye, const Vec3& point);  ///< as Rod::fadeBefore()
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

/// Draw an actor after all others of its renderer, so that it is blended with them. VTK's own pass, which draws
/// translucent objects in any order into separate buffers, is slow in software.
void drawLast(vtkRenderer* renderer, vtkActor* actor);

/// Add a light at (x, y, z) in the camera's frame: the camera is at (0, 0, 1) and looks at the origin.
void addLight(vtkRenderer* renderer, double x, double y, double z, double intensity);

}  // namespace enamel::viewer
