#include "camera.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

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

const std::array<CameraPreset, 4>& cameraPresets() {
  static const std::array<CameraPreset, 4> presets{{
      {"user", {{14.0, -36.0, -16.0}, glm::radians(44.0), glm::radians(20.0), 580.0, 0.45}},
      {"side", {{0.0, -34.0, -22.0}, glm::radians(80.0), glm::radians(9.0), 560.0, 0.45}},
      {"top", {{0.0, -10.0, -10.0}, glm::radians(4.0), glm::radians(72.0), 620.0, 0.45}},
      {"close", {{0.0, 0.0, 6.0}, glm::radians(52.0), glm::radians(20.0), 230.0, 0.45}},
  }};
  return presets;
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

void follow(Camera& camera, const glm::dvec3& point, double distance, double passed) {
  constexpr double settling = 0.12;  // s
  const double share = 1.0 - std::exp(-passed / settling);
  camera.focus += share * (point - camera.focus);
  camera.distance += share * (distance - camera.distance);
}

void CameraControl::select(std::size_t preset) {
  preset_ = preset;
  follows_ = false;
  camera_ = cameraPresets()[preset].camera;
}

void CameraControl::toggleFollowing(double now) {
  follows_ = !follows_;
  nearUntil_ = now + 0.6;
}

// Move near the contact at first. Afterwards the person sets the distance with the wheel.
void CameraControl::follow(const glm::dvec3& point, double now, double passed) {
  constexpr double near = 120.0;  // mm
  if (follows_) viewer::follow(camera_, point, now < nearUntil_ ? near : camera_.distance, passed);
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
