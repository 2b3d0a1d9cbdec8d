// Polygons and lines of the scene, in W, an actor a list.
#pragma once

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <array>
#include <functional>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "shapes.hpp"

namespace enamel::viewer {

/// Polygons over points that have a normal each, and, if any, a colour each.
class Polygons {
 public:
  /// `room`: for so many points.
  explicit Polygons(vtkIdType room = 0);

  /// Its number. Point: m.
  vtkIdType append(const Vec3& point, const Vec3& normal);
  /// Of the point that was appended last, 0 to 1.
  void paint(const Vec3& rgb);
  vtkCellArray* cells() { return cells_; }

  /// `deep`: with more shade, so that what is painted has form.
  vtkSmartPointer<vtkActor> addTo(vtkRenderer* renderer, const Finish& finish, bool deep = true);

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkFloatArray> normals_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

/// A mesh with smooth shading, `pose` in W; `colours` (0 to 1) of its vertices, or empty: that of the finish.
vtkSmartPointer<vtkActor> addMesh(vtkRenderer* renderer, const TriangleMesh& mesh, const Pose& pose,
                                  const Finish& finish, const std::vector<Vec3>& colours = {});

/// A convex polygon in W, m.
using Polygon = std::vector<Vec3>;
/// A parallelogram from its middle and two half sides.
Polygon parallelogram(const Vec3& middle, const Vec3& across, const Vec3& up);
/// What is left of a polygon, or a line, outside the half space behind a plane.
Polygon cut(const Polygon& polygon, const Vec3& point, const Vec3& normal);

/// Flat faces, with their corners anticlockwise as seen from outside, and lines, as one actor each.
/// `colourAt`: of a corner; or empty, that of the finish.
vtkSmartPointer<vtkActor> addFaces(vtkRenderer* renderer, const std::vector<Polygon>& faces, const Finish& finish,
                                   const std::function<Vec3(const Vec3&)>& colourAt = {});
vtkSmartPointer<vtkActor> addLines(vtkRenderer* renderer, const std::vector<std::array<Vec3, 2>>& lines,
                                   unsigned colour, float width);

}  // namespace enamel::viewer
