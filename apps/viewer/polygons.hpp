// Polygons and lines of the scene in W, one actor for each list.
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

/// Polygons over points, each with a normal and possibly a colour.
class Polygons {
 public:
  /// `room`: expected number of points.
  explicit Polygons(vtkIdType room = 0);

  /// Append a point (m) and return its number.
  vtkIdType append(const Vec3& point, const Vec3& normal);
  /// Set the colour of the last point, 0 to 1.
  void paint(const Vec3& rgb);
  vtkCellArray* cells() { return cells_; }

  /// `deep`: stronger shading, which shows the form of coloured surfaces.
  vtkSmartPointer<vtkActor> addTo(vtkRenderer* renderer, const Finish& finish, bool deep = true);

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkFloatArray> normals_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

/// Add a mesh with smooth shading. `pose`: in W; `colours`: of the vertices (0 to 1); empty: the colour of the finish.
vtkSmartPointer<vtkActor> addMesh(vtkRenderer* renderer, const TriangleMesh& mesh, const Pose& pose,
                                  const Finish& finish, const std::vector<Vec3>& colours = {});

/// A convex polygon in W, m.
using Polygon = std::vector<Vec3>;
/// Return a parallelogram from its centre and two half sides.
Polygon parallelogram(const Vec3& middle, const Vec3& across, const Vec3& up);
/// Cut away the part of a polygon or line that is in the half space behind a plane.
Polygon cut(const Polygon& polygon, const Vec3& point, const Vec3& normal);

/// Add flat faces, whose corners are anticlockwise as seen from outside; then a function for lines. Each call adds one
/// actor. `colourAt`: colour of a corner; empty: the colour of the finish.
vtkSmartPointer<vtkActor> addFaces(vtkRenderer* renderer, const std::vector<Polygon>& faces, const Finish& finish,
                                   const std::function<Vec3(const Vec3&)>& colourAt = {});
vtkSmartPointer<vtkActor> addLines(vtkRenderer* renderer, const std::vector<std::array<Vec3, 2>>& lines,
                                   unsigned colour, float width);

}  // namespace enamel::viewer
