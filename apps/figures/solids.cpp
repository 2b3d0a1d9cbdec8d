#include "solids.hpp"

#include <vtkCamera.h>
#include <vtkProperty.h>

#include <Eigen/Geometry>

#include "../viewer/shapes.hpp"
#include "annotations.hpp"

namespace enamel::figures {
namespace {

using viewer::kMillimetres;

Vec3 vectorOf(const Json& v) { return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()}; }

unsigned rgbOf(const std::string& text) {
  const glm::u8vec3 c = colourOf(text);
  return static_cast<unsigned>(c.r << 16 | c.g << 8 | c.b);
}

}  // namespace

void addSolids(Canvas& canvas, const Json& scene) {
  vtkRenderer* renderer = canvas.solids();
  for (const Json& rod : scene.value("rods", Json::array()))
    viewer::Rod(renderer, rod.at("radius_mm"), {rgbOf(rod.at("colour"))})
        .place(vectorOf(rod.at("from")), vectorOf(rod.at("to")));
  for (const Json& rod : scene.value("cones", Json::array()))
    viewer::Rod(renderer, rod.at("radius_mm"), {rgbOf(rod.at("colour"))}, true)
        .place(vectorOf(rod.at("from")), vectorOf(rod.at("to")));
  for (const Json& ball : scene.value("balls", Json::array()))
    viewer::Ball(renderer, ball.at("radius_mm"), {rgbOf(ball.at("colour"))}).place(vectorOf(ball.at("at")));
  for (const Json& face : scene.value("faces", Json::array())) {
    viewer::Polygon corners;
    for (const Json& corner : face.at("corners")) corners.push_back(vectorOf(corner));
    viewer::addFaces(renderer, {corners}, {rgbOf(face.at("colour")), 1.0, 0.0})->GetProperty()->LightingOff();
  }
  for (const Json& line : scene.value("lines", Json::array()))
    viewer::addLines(renderer, {{vectorOf(line.at("from")), vectorOf(line.at("to"))}}, rgbOf(line.at("colour")),
                     static_cast<float>(kOversampling * line.value("width", 2.0)));

  const Json& view = scene.at("camera");
  const Vec3 eye = kMillimetres * vectorOf(view.at("eye")), focus = kMillimetres * vectorOf(view.at("focus"));
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
  camera->SetViewUp(0.0, 1.0, 0.0);
  camera->ParallelProjectionOn();
  camera->SetParallelScale(0.5 * kMillimetres * view.at("height").get<double>());
  renderer->RemoveAllLights();
  viewer::addLight(renderer, -0.4, 0.8, 1.0, 0.95);
  viewer::addLight(renderer, 0.9, 0.2, 0.6, 0.35);
  renderer->ResetCameraClippingRange();

  // Where a label's point is seen: the camera is parallel, so this is a projection onto its axes.
  const Vec3 towards = (eye - focus).normalized(), right = Vec3::UnitY().cross(towards).normalized(),
             up = towards.cross(right);
  const double pixels = canvas.size().y / (kMillimetres * view.at("height").get<double>());
  for (const Json& label : scene.value("labels", Json::array())) {
    const Vec3 from = kMillimetres * vectorOf(label.at("at")) - focus;
    Json text = label;
    text["x"] = 0.5 * canvas.size().x + pixels * right.dot(from) + label.at("offset")[0].get<double>();
    text["y"] = 0.5 * canvas.size().y - pixels * up.dot(from) + label.at("offset")[1].get<double>();
    addText(canvas, text);
  }
}

}  // namespace enamel::figures
