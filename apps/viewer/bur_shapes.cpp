#include "bur_shapes.hpp"

#include <vtkCellArray.h>
#include <vtkMapper.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "polygons.hpp"

namespace enamel::viewer {

FlutedBur::FlutedBur(vtkRenderer* renderer, double radius, double length) {
  constexpr int around = 96, rings = 25, flutes = 8;
  constexpr double pi = 3.14159265358979323846, twist = 0.5, depth = 0.14;  // depth of a flute, relative to the radius
  Polygons polygons;
  for (int ring = 0; ring < rings; ++ring) {
    const double polar = pi * (1.0 - static_cast<double>(ring) / (rings - 1));  // from the tip, at -z
    const double lift = 2 * ring >= rings ? length : 0.0;
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * pi * i / around;
      const double phase = std::sin(flutes * (angle + twist * std::cos(polar)));
      const Vec3 out(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
      const double r = radius * (1.0 - depth * std::sin(polar) * (phase < 0.0 ? -phase : 0.0));
      polygons.append((r * out + lift * Vec3::UnitZ()) / kMillimetres, out);
      const unsigned rgb = phase < 0.0 ? kBurFlute : kBurSteel;
      polygons.paint(rgbOf(rgb));
      if (ring + 1 == rings) continue;
      const vtkIdType here = ring * around + i, next = ring * around + (i + 1) % around;
      polygons.cells()->InsertNextCell({here, here + around, next + around, next});
    }
  }
  actor_ = polygons.addTo(renderer, {kBurSteel, 1.0, 0.5});
  vtkNew<vtkMatrix4x4> matrix;
  actor_->SetUserMatrix(matrix);
}

void FlutedBur::place(const Vec3& from, const Mat3& frame, double angle) {
  const Mat3 turned = frame * Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  vtkMatrix4x4* const matrix = actor_->GetUserMatrix();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) matrix->SetElement(i, j, turned(i, j));
    matrix->SetElement(i, 3, kMillimetres * from[i]);
  }
  actor_->Modified();
}

ChipView::ChipView(vtkRenderer* renderer, const std::vector<SolidLayer>& layers) {
  for (const SolidLayer& layer : layers) layerColours_.push_back(layerColour(layer.name, layerColours_.size()));
  constexpr auto corners = static_cast<vtkIdType>(3 * Chips::kPool);
  normals_->SetNumberOfComponents(3);
  colours_->SetNumberOfComponents(3);
  points_->SetNumberOfPoints(corners);
  normals_->SetNumberOfTuples(corners);
  colours_->SetNumberOfTuples(corners);
  vtkNew<vtkCellArray> cells;
  for (vtkIdType i = 0; i < corners; i += 3) cells->InsertNextCell({i, i + 1, i + 2});
  vtkNew<vtkPolyData> data;
  data->SetPoints(points_);
  data->SetPolys(cells);
  data->GetPointData()->SetNormals(normals_);
  data->GetPointData()->SetScalars(colours_);
  actor_ = addData(renderer, data, {0xFFFFFF, 1.0, 0.1});
  actor_->GetMapper()->ScalarVisibilityOn();
  actor_->GetMapper()->SetColorModeToDirectScalars();
  actor_->GetProperty()->SetAmbient(0.75);  // bright even in the shade, where chips would look like specks
  actor_->GetProperty()->SetDiffuse(0.25);
  actor_->VisibilityOff();
}

void ChipView::place(std::size_t chip, const Vec3& centre, const Mat3& frame, double size, unsigned colour) {
  const Vec3 across = frame.col(0), up = frame.col(1), normal = across.cross(up), middle = kMillimetres * centre;
  const Vec3 corners[] = {middle + size * up, middle - 0.5 * size * (across + up),
                          middle + 0.5 * size * (across - 0.4 * up)};
  for (vtkIdType i = 0; i < 3; ++i) {
    const vtkIdType corner = 3 * static_cast<vtkIdType>(chip) + i;
    points_->SetPoint(corner, corners[i].data());
    normals_->SetTuple(corner, normal.data());
    for (int c = 0; c < 3; ++c)
      colours_->SetTypedComponent(corner, c, static_cast<unsigned char>(colour >> (16 - 8 * c) & 255));
  }
}

void ChipView::show(const Chips& chips) {
  constexpr double size = 0.4, tumble = 25.0;  // mm, rad/s
  bool any = false;
  for (std::size_t i = 0; i < Chips::kPool; ++i) {
    const Chips::Chip& chip = chips.chips()[i];
    const double left = std::max(0.0, 1.0 - chip.age / Chips::kLife), number = static_cast<double>(i);
    const Vec3 axis = Vec3(std::sin(2.4 * number), std::cos(2.4 * number), std::sin(1.7 * number)).normalized();
    const Mat3 turned = Eigen::AngleAxisd(number + tumble * chip.age, axis).toRotationMatrix();
    place(i, chip.position, turned, size * std::sqrt(left), layerColours_[static_cast<std::size_t>(chip.layer)]);
    any = any || left > 0.0;
  }
  actor_->SetVisibility(any);
  if (!any) return;
  points_->Modified();
  normals_->Modified();
  colours_->Modified();
}

}  // namespace enamel::viewer
