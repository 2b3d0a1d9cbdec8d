// What is seen of a bur: the bur, and what it throws off.
#pragma once

#include <vtkActor.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "chips.hpp"

namespace enamel::viewer {

/// A bur: a ball or capsule of radius `radius` (mm) with flutes around its axis, along which `length` (mm) is straight.
class FlutedBur {
 public:
  FlutedBur(vtkRenderer* renderer, double radius, double length);
  /// `from`: centre of its tip, m; `frame`: its axis is the third column; turned by an angle, rad.
  void place(const Vec3& from, const Mat3& frame, double angle);

 private:
  vtkSmartPointer<vtkActor> actor_;
};

/// Chips, as one actor: small flat triangles that tumble, and become smaller as they age.
class ChipView {
 public:
  explicit ChipView(vtkRenderer* renderer);
  void show(const Chips& chips);

 private:
  void place(std::size_t chip, const Vec3& centre, const Mat3& frame, double size, unsigned colour);

  vtkNew<vtkPoints> points_;
  vtkNew<vtkFloatArray> normals_;
  vtkNew<vtkUnsignedCharArray> colours_;
  vtkSmartPointer<vtkActor> actor_;
};

}  // namespace enamel::viewer
