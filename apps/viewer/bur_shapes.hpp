// Drawing of the bur and its chips.
#pragma once

#include <vtkActor.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <vector>

#include "chips.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel::viewer {

/// A bur of radius `radius` (mm): a sphere or a capsule whose straight part is `length` (mm) long, with flutes around
/// its axis.
class FlutedBur {
 public:
  FlutedBur(vtkRenderer* renderer, double radius, double length);
  /// Place the bur. `from`: centre of its tip, m; `frame`: its third column is the axis; `angle`: rotation, rad.
  void place(const Vec3& from, const Mat3& frame, double angle);

 private:
  vtkSmartPointer<vtkActor> actor_;
};

/// All chips as one actor: small flat triangles that tumble and shrink with age.
class ChipView {
 public:
  /// `layers`: those of the solid that is cut, at least one.
  ChipView(vtkRenderer* renderer, const std::vector<SolidLayer>& layers);
  void show(const Chips& chips);

 private:
  void place(std::size_t chip, const Vec3& centre, const Mat3& frame, double size, unsigned colour);

  std::vector<unsigned> layerColours_;
  vtkNew<vtkPoints> points_;
  vtkNew<vtkFloatArray> normals_;
  vtkNew<vtkUnsignedCharArray> colours_;
  vtkSmartPointer<vtkActor> actor_;
};

}  // namespace enamel::viewer
