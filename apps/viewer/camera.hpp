// The camera: orbits a point, in mm of W. Built on GLM; the scene's own camera is set from it.
#pragma once

#include <array>
#include <glm/glm.hpp>

namespace enamel::viewer {

struct Camera {
  glm::dvec3 focus{0.0, 0.0, 0.0};  ///< mm
  double azimuth = 0.0;             ///< of the eye about y, from z towards x, rad
  double elevation = 0.0;           ///< rad, within +-88 deg
  double distance = 400.0;          ///< mm
  double angle = 0.45;              ///< of view, vertical, rad

  glm::dvec3 eye() const;
  glm::dmat4 view() const;
  /// `aspect`: width over height.
  glm::dmat4 projection(double aspect) const;
  /// Of the view from bottom to top, rad: `angle`, and more where the picture is so narrow that the hand would be cut
  /// off.
  double height(double aspect) const;
};

struct CameraPreset {
  const char* name;
  Camera camera;
};

/// What the keys 1 to 4 show.
const std::array<CameraPreset, 4>& cameraPresets();

inline constexpr double kNearest = 30.0;  ///< distance of a camera, mm

/// Turns by a drag of so many radians; moves the focus across the view by millimetres; nearer or farther by a factor.
void orbit(Camera& camera, double right, double up);
void pan(Camera& camera, double right, double up);
void zoom(Camera& camera, double factor);
/// Brings the focus to a point, mm, and the distance to `distance`, as far as `passed` s allow: nearly all in 0.5 s.
void follow(Camera& camera, const glm::dvec3& point, double distance, double passed);

/// A point of W, mm, in a picture of `size` pixels, from the top left; z is the depth in the picture, 0 to 1.
glm::dvec3 project(const Camera& camera, const glm::dvec2& size, const glm::dvec3& point);

/// The point that is seen at `pixel` as far away as `like` is.
glm::dvec3 unproject(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& like);

}  // namespace enamel::viewer
