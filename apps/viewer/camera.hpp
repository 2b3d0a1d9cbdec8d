// A camera that orbits a point. Scenes are drawn in mm of W with vectors of GLM; everything else is in SI units.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "enamel/core/types.hpp"

namespace enamel::viewer {

inline constexpr double kMillimetres = 1e3;  // per metre

inline Vec3 metres(const glm::dvec3& mm) { return Vec3(mm.x, mm.y, mm.z) / kMillimetres; }

inline glm::dvec3 millimetres(const Vec3& m) {
  const Vec3 mm = kMillimetres * m;
  return {mm.x(), mm.y(), mm.z()};
}

struct Camera {
  glm::dvec3 focus{0.0, 0.0, 0.0};  ///< mm
  double azimuth = 0.0;             ///< of the eye about y, from z towards x, rad
  double elevation = 0.0;           ///< rad, within +-88 deg
  double distance = 400.0;          ///< mm
  double angle = 0.45;              ///< vertical angle of view, rad

  glm::dvec3 eye() const;
  glm::dmat4 view() const;
  /// `aspect`: width / height.
  glm::dmat4 projection(double aspect) const;
  /// Return the vertical angle of view, rad: `angle`, but more in narrow pictures, which would otherwise cut off the
  /// hand.
  double height(double aspect) const;
};

struct CameraPreset {
  const char* name;
  Camera camera;
};

/// Return the views of the keys 1 to 4.
const std::array<CameraPreset, 4>& cameraPresets();

inline constexpr double kNearest = 30.0;  ///< distance of a camera, mm

/// Turn the camera by a drag, rad; the next functions move the focus across the view (mm) and scale the distance.
void orbit(Camera& camera, double right, double up);
void pan(Camera& camera, double right, double up);
void zoom(Camera& camera, double factor);
/// Move the focus to a point (mm) and the distance to `distance`, with most of the way done in 0.5 s. `passed`: s.
void follow(Camera& camera, const glm::dvec3& point, double distance, double passed);

/// A camera that a person turns or selects, or that follows the contact.
class CameraControl {
 public:
  CameraControl() { select(0); }

  Camera& camera() { return camera_; }
  const Camera& camera() const { return camera_; }
  /// Return "follow" or the name of the last selected preset.
  const char* name() const { return follows_ ? "follow" : cameraPresets()[preset_].name; }

  void select(std::size_t preset);
  void selectNext() { select((preset_ + 1) % cameraPresets().size()); }
  void selectPrevious() { select((preset_ + cameraPresets().size() - 1) % cameraPresets().size()); }

  /// Start or stop to follow the contact at `now` (s).
  void toggleFollowing(double now);
  /// If the camera follows, move the focus towards a point (mm). `passed`: s.
  void follow(const glm::dvec3& point, double now, double passed);

  /// Save the view for restore().
  void keep() { keptCamera_ = camera_, keptPreset_ = preset_; }
  void restore() { camera_ = keptCamera_, preset_ = keptPreset_; }

 private:
  Camera camera_, keptCamera_;
  std::size_t preset_ = 0, keptPreset_ = 0;
  bool follows_ = false;
  double nearUntil_ = 0.0;  // s: until then it also moves nearer
};

/// Project a point of W (mm) into a picture of `size` pixels, from the top left; z is the depth, 0 to 1.
glm::dvec3 project(const Camera& camera, const glm::dvec2& size, const glm::dvec3& point);

/// Return the point at `pixel` that has the same depth as `like`.
glm::dvec3 unproject(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& like);

}  // namespace enamel::viewer
