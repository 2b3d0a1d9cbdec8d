#include "shapes.hpp"

#include <vtkConeSource.h>
#include <vtkCylinderSource.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>
#include <vtkTrivialProducer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel::viewer {
namespace {

// Map the unit rod (along y from 0 to 1, radius 1) to two points.
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

// Return the opacity of a part between `a` and `b` that is `radius` (mm) thick.
double opacityBefore(const Vec3& eye, const Vec3& point, const Vec3& a, const Vec3& b, double radius) {
  constexpr double before = 0.012, margin = 3.0, faded = 0.18;  // m, mm
  const Vec3 end = point + before * (eye - point).normalized(), sight = end - eye, along = b - a, between = eye - a;
  // Nearest points of two segments (Ericson 2005, 5.1.9); one may be a point.
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
  actor->SetForceOpaque(finish.opacity < 1.0);  // see drawLast()
  renderer->AddActor(actor);
  return actor;
}

vtkSmartPointer<vtkActor> addData(vtkRenderer* renderer, vtkPolyData* data, const Finish& finish) {
  vtkNew<vtkTrivialProducer> producer;
  producer->SetOutput(data);
  return addActor(renderer, producer->GetOutputPort(), finish);
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

void addLight(vtkRenderer* renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

}  // namespace enamel::viewer
