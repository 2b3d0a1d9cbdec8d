#include "camera.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "enamel/collision/contacts.hpp"

namespace enamel::viewer {
namespace {

constexpr double kNear = 10.0, kFar = 4000.0;  // mm
const glm::dvec3 kUp{0.0, 1.0, 0.0};

}  // namespace

glm::dvec3 Camera::eye() const {
  const double c = std::cos(elevation);
  return focus + distance * glm::dvec3(c * std::sin(azimuth), std::sin(elevation), c * std::cos(azimuth));
}

glm::dmat4 Camera::view() const { return glm::lookAt(eye(), focus, kUp); }

double Camera::height(double aspect) const {
  constexpr double narrow = 0.9;
  return aspect >= narrow ? angle : 2.0 * std::atan(std::tan(0.5 * angle) * narrow / aspect);
}

glm::dmat4 Camera::projection(double aspect) const { return glm::perspective(height(aspect), aspect, kNear, kFar); }

const std::array<CameraPreset, 3>& cameraPresets() {
  static const std::array<CameraPreset, 3> presets{{
      {"device", {{14.0, -36.0, -16.0}, glm::radians(44.0), glm::radians(20.0), 580.0, 0.45}},
      {"side", {{0.0, -34.0, -22.0}, glm::radians(80.0), glm::radians(9.0), 560.0, 0.45}},
      {"top", {{0.0, -10.0, -10.0}, glm::radians(4.0), glm::radians(72.0), 620.0, 0.45}},
  }};
  return presets;
}

Camera fieldCamera(const SceneFile& scene) {
  constexpr double reach = 14.0, tip = 8.0, margin = 1.3, lift = 0.12;  // mm; mm; factors of the view's height
  Pose start;
  start.position = scene.start;
  const Contact nearest = nearestContact(scene.scene, scene.tool, start, nullptr);
  const glm::dvec3 tool = millimetres(scene.start);
  const bool any = nearest.part >= 0 && nearest.gap < 0.05;
  const glm::dvec3 surface = any ? millimetres(nearest.point - nearest.gap * nearest.normal) : tool;
  const glm::dvec3 top = tool + glm::dvec3(0.0, 0.0, tip);
  Camera camera;
  camera.azimuth = glm::radians(38.0);
  camera.elevation = glm::radians(24.0);
  const double radius = 0.5 * (glm::distance(surface, top) + reach);
  camera.distance = margin * radius / std::tan(0.5 * camera.angle);
  // Numbers and the magnified contact cover the lower part of the picture.
  camera.focus = 0.5 * (surface + top) - glm::dvec3(0.0, 0.0, 0.4 * reach);
  pan(camera, 0.0, 2.0 * lift * camera.distance * std::tan(0.5 * camera.angle));
  return camera;
}

void orbit(Camera& camera, double right, double up) {
  camera.azimuth = std::remainder(camera.azimuth - right, 2.0 * glm::pi<double>());
  camera.elevation = std::clamp(camera.elevation + up, glm::radians(-88.0), glm::radians(88.0));
}

void pan(Camera& camera, double right, double up) {
  const glm::dmat4 view = camera.view();
  const glm::dvec3 across(view[0][0], view[1][0], view[2][0]), upward(view[0][1], view[1][1], view[2][1]);
  camera.focus = glm::clamp(camera.focus - right * across - up * upward, -300.0, 300.0);
}

void zoom(Camera& camera, double factor) { camera.distance = std::clamp(camera.distance * factor, kNearest, 2000.0); }

void follow(Camera& camera, const glm::dvec3& point, double passed) {
  constexpr double settling = 0.12;  // s
  camera.focus += (1.0 - std::exp(-passed / settling)) * (point - camera.focus);
}

void CameraControl::select(int view) {
  view_ = view;
  follows_ = false;
  camera_ = view == 0 ? field_ : cameraPresets()[static_cast<std::size_t>(view - 1)].camera;
}

void CameraControl::follow(const glm::dvec3& point, double passed) {
  if (follows_) viewer::follow(camera_, point, passed);
}

bool isOnTool(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& tip,
              const glm::dvec3& axis) {
  constexpr double length = 88.0, thick = 4.5, least = 10.0, pieces = 24.0;  // mm, mm, pixels
  for (double piece = 0.0; piece <= pieces; ++piece) {
    const glm::dvec3 point = tip + piece / pieces * length * axis, seen = project(camera, size, point);
    if (seen.z < 0.0 || seen.z > 1.0) continue;
    const double near = glm::distance(camera.eye(), point);
    const double wide = thick * size.y / (2.0 * near * std::tan(0.5 * camera.height(size.x / size.y)));
    if (glm::distance(glm::dvec2(seen), pixel) < std::max(least, piece > 0.2 * pieces ? wide : 0.5 * wide)) return true;
  }
  return false;
}

glm::dvec3 project(const Camera& camera, const glm::dvec2& size, const glm::dvec3& point) {
  const glm::dvec4 viewport(0.0, 0.0, size);
  const glm::dvec3 p = glm::project(point, camera.view(), camera.projection(size.x / size.y), viewport);
  return {p.x, size.y - p.y, p.z};
}

glm::dvec3 unproject(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& like) {
  const glm::dvec4 viewport(0.0, 0.0, size);
  const double depth = project(camera, size, like).z;
  return glm::unProject(glm::dvec3(pixel.x, size.y - pixel.y, depth), camera.view(), camera.projection(size.x / size.y),
                        viewport);
}

}  // namespace enamel::viewer
