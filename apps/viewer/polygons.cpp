#include "polygons.hpp"

#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <Eigen/Geometry>

namespace enamel::viewer {
namespace {

vtkIdType insert(vtkPoints* points, const Vec3& point) {
  return points->InsertNextPoint((kMillimetres * point).eval().data());
}

}  // namespace

Polygons::Polygons(vtkIdType room) {
  normals_->SetNumberOfComponents(3);
  colours_->SetNumberOfComponents(3);
  if (room == 0) return;
  points_->Allocate(room);
  normals_->Allocate(3 * room);
  colours_->Allocate(3 * room);
}

vtkIdType Polygons::append(const Vec3& point, const Vec3& normal) {
  normals_->InsertNextTuple3(normal.x(), normal.y(), normal.z());
  return insert(points_, point);
}

void Polygons::paint(const Vec3& rgb) {
  for (const double c : rgb) colours_->InsertNextValue(static_cast<unsigned char>(255.0 * c + 0.5));
}

vtkSmartPointer<vtkActor> Polygons::addTo(vtkRenderer* renderer, const Finish& finish, bool deep) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(points_);
  data->SetPolys(cells_);
  data->GetPointData()->SetNormals(normals_);
  const bool painted = colours_->GetNumberOfTuples() == points_->GetNumberOfPoints();
  if (painted) data->GetPointData()->SetScalars(colours_);
  vtkSmartPointer<vtkActor> actor = addData(renderer, data, finish);
  if (!painted) return actor;
  actor->GetMapper()->ScalarVisibilityOn();
  actor->GetMapper()->SetColorModeToDirectScalars();
  if (!deep) return actor;
  actor->GetProperty()->SetAmbient(0.34);
  actor->GetProperty()->SetDiffuse(0.64);
  actor->GetProperty()->SetSpecularPower(40.0);
  return actor;
}

vtkSmartPointer<vtkActor> addMesh(vtkRenderer* renderer, const TriangleMesh& mesh, const Pose& pose,
                                  const Finish& finish, const std::vector<Vec3>& colours) {
  std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero());  // vertex normals: sums over triangles, weighted by area
  Polygons polygons;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int i) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    polygons.cells()->InsertNextCell(3);
    for (const int vertex : t) {
      sums[static_cast<std::size_t>(vertex)] += normal;
      polygons.cells()->InsertCellPoint(vertex);
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i)
    polygons.append(pose.position + pose.rotation * mesh.vertices[i], pose.rotation * sums[i].normalized());
  for (const Vec3& rgb : colours) polygons.paint(rgb);
  vtkSmartPointer<vtkActor> actor = polygons.addTo(renderer, finish);
  const MeshReport report = inspect(mesh);
  actor->GetProperty()->SetBackfaceCulling(report.watertight && !report.inwards);
  return actor;
}

Polygon parallelogram(const Vec3& middle, const Vec3& across, const Vec3& up) {
  return {middle - across - up, middle + across - up, middle + across + up, middle - across + up};
}

Polygon cut(const Polygon& polygon, const Vec3& point, const Vec3& normal) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a - point), db = normal.dot(b - point);
    if (da >= 0.0) result.push_back(a);
    if ((da < 0.0) != (db < 0.0)) result.push_back(a + da / (da - db) * (b - a));
  }
  return result;
}

vtkSmartPointer<vtkActor> addFaces(vtkRenderer* renderer, const std::vector<Polygon>& faces, const Finish& finish,
                                   const std::function<Vec3(const Vec3&)>& colourAt) {
  Polygons polygons;
  for (const Polygon& face : faces) {
    if (face.size() < 3) continue;
    const Vec3 normal = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
    polygons.cells()->InsertNextCell(static_cast<int>(face.size()));
    for (const Vec3& corner : face) {
      polygons.cells()->InsertCellPoint(polygons.append(corner, normal));
      if (colourAt) polygons.paint(colourAt(corner));
    }
  }
  return polygons.addTo(renderer, finish);
}

vtkSmartPointer<vtkActor> addLines(vtkRenderer* renderer, const std::vector<std::array<Vec3, 2>>& lines,
                                   unsigned colour, float width) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const auto& line : lines) {
    cells->InsertNextCell(2);
    for (const Vec3& end : line) cells->InsertCellPoint(insert(points, end));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  vtkSmartPointer<vtkActor> actor = addData(renderer, data, {colour, 1.0, 0.0});
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetLineWidth(width);
  return actor;
}

}  // namespace enamel::viewer
