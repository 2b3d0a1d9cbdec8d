// The camera: orbits a point. The scene is drawn in mm of W, with vectors of GLM; everything else is in SI.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "enamel/core/types.hpp"

namespace enamel::viewer {

inline constexpr double kMillimetres = 1e3;  // in a metre

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

/// The camera that a person turns, chooses, or lets follow the contact.
class CameraControl {
 public:
  CameraControl() { select(0); }

  Camera& camera() { return camera_; }
  const Camera& camera() const { return camera_; }
  /// "follow", or of the preset that was selected last.
  const char* name() const { return follows_ ? "follow" : cameraPresets()[preset_].name; }

  void select(std::size_t preset);
  void selectNext() { select((preset_ + 1) % cameraPresets().size()); }
  void selectPrevious() { select((preset_ + cameraPresets().size() - 1) % cameraPresets().size()); }

  /// Follows the contact from `now` (s) on, or no longer.
  void toggleFollowing(double now);
  /// Brings the focus to a point (mm) if it follows, as far as the seconds that have passed allow.
  void follow(const glm::dvec3& point, double now, double passed);

  /// Keeps the view for restore().
  void keep() { keptCamera_ = camera_, keptPreset_ = preset_; }
  void restore() { camera_ = keptCamera_, preset_ = keptPreset_; }

 private:
  Camera camera_, keptCamera_;
  std::size_t preset_ = 0, keptPreset_ = 0;
  bool follows_ = false;
  double nearUntil_ = 0.0;  // s: until then it also comes near
};

/// A point of W, mm, in a picture of `size` pixels, from the top left; z is the depth in the picture, 0 to 1.
glm::dvec3 project(const Camera& camera, const glm::dvec2& size, const glm::dvec3& point);

/// The point that is seen at `pixel` as far away as `like` is.
glm::dvec3 unproject(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& like);

}  // namespace enamel::viewer
