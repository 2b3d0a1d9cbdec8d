// What is seen of a bur: the bur, and what it throws off.
#pragma once

#include <vtkActor.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "enamel/core/types.hpp"

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

}  // namespace enamel::viewer
