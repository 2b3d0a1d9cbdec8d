#include "shapes.hpp"

#include <vtkCellArray.h>
#include <vtkConeSource.h>
#include <vtkCylinderSource.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>
#include <vtkTrivialProducer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel::viewer {
namespace {

// Maps the unit rod (along y from 0 to 1, radius 1) between two points.
void between(vtkMatrix4x4* matrix, const Vec3& from, const Vec3& to, double radius) {
  const Vec3 along = kMillimetres * (to - from);
  const double length = std::max(along.norm(), 1e-6);
  const Vec3 y = along / length;
  const Vec3 x = y.unitOrthogonal(), z = x.cross(y);
  for (int i = 0; i < 3; ++i) {
    matrix->SetElement(i, 0, radius * x[i]);
    matrix->SetElement(i, 1, length * y[i]);
    matrix->SetElement(i, 2, radius * z[i]);
    matrix->SetElement(i, 3, kMillimetres * from[i]);
  }
}

// How much is seen of what stands between `a` and `b` and is `radius` (mm) thick.
double opacityBefore(const Vec3& eye, const Vec3& point, const Vec3& a, const Vec3& b, double radius) {
  constexpr double before = 0.012, margin = 3.0, faded = 0.18;  // m, mm
  const Vec3 end = point + before * (eye - point).normalized(), sight = end - eye, along = b - a, between = eye - a;
  // Nearest points of two stretches (Ericson 2005, 5.1.9), one of which may be a point.
  const double ss = sight.squaredNorm(), aa = along.squaredNorm(), sa = sight.dot(along), as = along.dot(between);
  const double det = ss * aa - sa * sa;
  double s = det > 1e-12 * ss * aa ? std::clamp((sa * as - sight.dot(between) * aa) / det, 0.0, 1.0) : 0.0;
  const double t = aa > 0.0 ? std::clamp((sa * s + as) / aa, 0.0, 1.0) : 0.0;
  s = std::clamp((sa * t - sight.dot(between)) / ss, 0.0, 1.0);
  const double apart = kMillimetres * (between + s * sight - t * along).norm();
  return faded + (1.0 - faded) * std::clamp((apart - radius - margin) / margin, 0.0, 1.0);
}

bool fade(vtkActor* actor, double opacity) {
  const bool shines = opacity < 1.0, changes = shines != static_cast<bool>(actor->GetForceOpaque());
  actor->GetProperty()->SetOpacity(opacity);
  actor->SetForceOpaque(shines);
  return changes;
}

vtkSmartPointer<vtkActor> addData(vtkRenderer* renderer, vtkPolyData* data, const Finish& finish) {
  vtkNew<vtkTrivialProducer> producer;
  producer->SetOutput(data);
  return addActor(renderer, producer->GetOutputPort(), finish);
}

vtkIdType append(vtkPoints* points, const Vec3& point) {
  return points->InsertNextPoint((kMillimetres * point).eval().data());
}

// Polygons over points that have a normal each.
struct Polygons {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkFloatArray> normals;
  vtkNew<vtkUnsignedCharArray> colours;

  Polygons() {
    normals->SetNumberOfComponents(3);
    colours->SetNumberOfComponents(3);
  }
  vtkIdType append(const Vec3& point, const Vec3& normal) {
    normals->InsertNextTuple3(normal.x(), normal.y(), normal.z());
    return viewer::append(points, point);
  }
  // Of the point that was appended last.
  void paint(const Vec3& rgb) {
    for (const double c : rgb) colours->InsertNextValue(static_cast<unsigned char>(255.0 * c + 0.5));
  }
  vtkSmartPointer<vtkActor> addTo(vtkRenderer* renderer, const Finish& finish) {
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    data->GetPointData()->SetNormals(normals);
    const bool painted = colours->GetNumberOfTuples() == points->GetNumberOfPoints();
    if (painted) data->GetPointData()->SetScalars(colours);
    vtkSmartPointer<vtkActor> actor = addData(renderer, data, finish);
    if (!painted) return actor;
    actor->GetMapper()->ScalarVisibilityOn();
    actor->GetMapper()->SetColorModeToDirectScalars();
    // More shade: what is painted has form.
    actor->GetProperty()->SetAmbient(0.34);
    actor->GetProperty()->SetDiffuse(0.64);
    actor->GetProperty()->SetSpecularPower(40.0);
    return actor;
  }
};

}  // namespace

void setFinish(vtkProperty* property, const Finish& finish) {
  const Colour c = colour(finish.colour);
  property->SetColor(c.r, c.g, c.b);
  property->SetOpacity(finish.opacity);
  property->SetAmbient(0.42);
  property->SetDiffuse(0.54);
  property->SetSpecular(finish.shine);
  property->SetSpecularPower(25.0);
}

vtkSmartPointer<vtkActor> addActor(vtkRenderer* renderer, vtkAlgorithmOutput* source, const Finish& finish) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(source);
  mapper->ScalarVisibilityOff();
  vtkSmartPointer<vtkActor> actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  setFinish(actor->GetProperty(), finish);
  actor->SetForceOpaque(finish.opacity < 1.0);  // drawLast()
  renderer->AddActor(actor);
  return actor;
}

void drawLast(vtkRenderer* renderer, vtkActor* actor) {
  const vtkSmartPointer<vtkActor> kept = actor;
  renderer->RemoveActor(actor);
  renderer->AddActor(actor);
}

Rod::Rod(vtkRenderer* renderer, double radius, const Finish& finish, bool sharp) : radius_(radius) {
  if (sharp) {
    vtkNew<vtkConeSource> cone;
    cone->SetDirection(0.0, -1.0, 0.0);
    cone->SetCenter(0.0, 0.5, 0.0);
    cone->SetHeight(1.0);
    cone->SetRadius(1.0);
    cone->SetResolution(24);
    actor_ = addActor(renderer, cone->GetOutputPort(), finish);
  } else {
    vtkNew<vtkCylinderSource> cylinder;
    cylinder->SetCenter(0.0, 0.5, 0.0);
    cylinder->SetRadius(1.0);
    cylinder->SetResolution(20);
    actor_ = addActor(renderer, cylinder->GetOutputPort(), finish);
  }
  actor_->GetProperty()->BackfaceCullingOn();
  vtkNew<vtkMatrix4x4> matrix;
  actor_->SetUserMatrix(matrix);
}

void Rod::place(const Vec3& from, const Vec3& to, double thickness) {
  from_ = from;
  to_ = to;
  between(actor_->GetUserMatrix(), from, to, thickness * radius_);
  actor_->Modified();
}

void Rod::show(bool visible) { actor_->SetVisibility(visible); }

bool Rod::fadeBefore(const Vec3& eye, const Vec3& point) {
  return fade(actor_, opacityBefore(eye, point, from_, to_, radius_));
}

bool Ball::fadeBefore(const Vec3& eye, const Vec3& point) {
  const double* const at = actor_->GetPosition();
  const Vec3 centre = Vec3(at[0], at[1], at[2]) / kMillimetres;
  return fade(actor_, opacityBefore(eye, point, centre, centre, radius_));
}

Ball::Ball(vtkRenderer* renderer, double radius, const Finish& finish) : radius_(radius) {
  vtkNew<vtkSphereSource> sphere;
  sphere->SetRadius(radius);
  sphere->SetThetaResolution(24);
  sphere->SetPhiResolution(16);
  actor_ = addActor(renderer, sphere->GetOutputPort(), finish);
  actor_->GetProperty()->BackfaceCullingOn();
}

void Ball::place(const Vec3& centre, double growth) {
  actor_->SetScale(growth);
  const Vec3 c = kMillimetres * centre;
  actor_->SetPosition(c.x(), c.y(), c.z());
}

CapsuleSolid::CapsuleSolid(vtkRenderer* renderer, double radius, const Finish& finish)
    : rod_(renderer, radius, finish), from_(renderer, radius, finish), to_(renderer, radius, finish) {}

void CapsuleSolid::place(const Vec3& from, const Vec3& to) {
  rod_.place(from, to);
  rod_.show(from != to);
  from_.place(from);
  to_.place(to);
}

void CapsuleSolid::show(bool visible) {
  rod_.show(visible);
  from_.show(visible);
  to_.show(visible);
}

FlutedBur::FlutedBur(vtkRenderer* renderer, double radius, double length) {
  constexpr int around = 96, rings = 25, flutes = 8;
  constexpr double pi = 3.14159265358979323846, twist = 0.5, depth = 0.14;  // of a flute, share of the radius
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
      for (const int shift : {16, 8, 0})
        polygons.colours->InsertNextValue(static_cast<unsigned char>(rgb >> shift & 255));
      if (ring + 1 == rings) continue;
      const vtkIdType here = ring * around + i, next = ring * around + (i + 1) % around;
      polygons.cells->InsertNextCell({here, here + around, next + around, next});
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

Shards::Shards(vtkRenderer* renderer, std::size_t count) {
  const auto corners = static_cast<vtkIdType>(3 * count);
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
  actor_->GetProperty()->SetAmbient(0.75);  // chips in the shade would be specks
  actor_->GetProperty()->SetDiffuse(0.25);
  actor_->VisibilityOff();
}

void Shards::place(std::size_t shard, const Vec3& centre, const Vec3& across, const Vec3& up, double size,
                   unsigned colour) {
  const Vec3 normal = across.cross(up), middle = kMillimetres * centre;
  const Vec3 corners[] = {middle + size * up, middle - 0.5 * size * (across + up),
                          middle + 0.5 * size * (across - 0.4 * up)};
  for (vtkIdType i = 0; i < 3; ++i) {
    const vtkIdType corner = 3 * static_cast<vtkIdType>(shard) + i;
    points_->SetPoint(corner, corners[i].data());
    normals_->SetTuple(corner, normal.data());
    for (int c = 0; c < 3; ++c)
      colours_->SetTypedComponent(corner, c, static_cast<unsigned char>(colour >> (16 - 8 * c) & 255));
  }
}

void Shards::show(bool visible) {
  actor_->SetVisibility(visible);
  if (!visible) return;
  points_->Modified();
  normals_->Modified();
  colours_->Modified();
}

vtkSmartPointer<vtkActor> addMesh(vtkRenderer* renderer, const TriangleMesh& mesh, const Pose& pose,
                                  const Finish& finish, const std::vector<Vec3>& colours) {
  std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero());  // normals of the triangles, by area
  Polygons polygons;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int i) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    polygons.cells->InsertNextCell(3);
    for (const int vertex : t) {
      sums[static_cast<std::size_t>(vertex)] += normal;
      polygons.cells->InsertCellPoint(vertex);
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
    polygons.cells->InsertNextCell(static_cast<int>(face.size()));
    for (const Vec3& corner : face) {
      polygons.cells->InsertCellPoint(polygons.append(corner, normal));
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
    for (const Vec3& end : line) cells->InsertCellPoint(append(points, end));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  vtkSmartPointer<vtkActor> actor = addData(renderer, data, {colour, 1.0, 0.0});
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetLineWidth(width);
  return actor;
}

void addLight(vtkRenderer* renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

}  // namespace enamel::viewer
