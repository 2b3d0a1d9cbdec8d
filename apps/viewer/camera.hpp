// A camera that orbits a point. Scenes are drawn in mm of W with vectors of GLM; everything else is in SI units.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "enamel/collision/scene_file.hpp"

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

/// Return the views of the keys 2 to 4: the whole device, from three sides.
const std::array<CameraPreset, 3>& cameraPresets();

/// Return the view of the key 1: the operating field. The tip of the tool at its start and the nearest obstacle fill
/// the view.
Camera fieldCamera(const SceneFile& scene);

/// At smaller distances the device's links are not drawn, mm.
inline constexpr double kDeviceFrom = 230.0;

inline constexpr double kNearest = 30.0;  ///< distance of a camera, mm

/// Turn the camera by a drag, rad; the next functions move the focus across the view (mm) and scale the distance.
void orbit(Camera& camera, double right, double up);
void pan(Camera& camera, double right, double up);
void zoom(Camera& camera, double factor);
/// Move the focus to a point (mm), with most of the way done in 0.5 s. `passed`: s.
void follow(Camera& camera, const glm::dvec3& point, double passed);

/// A camera that a person turns or selects, or that follows the contact.
class CameraControl {
 public:
  explicit CameraControl(const Camera& field) : field_(field), camera_(field) {}

  Camera& camera() { return camera_; }
  const Camera& camera() const { return camera_; }
  /// Return the number of the last selected view: 0 is the field, then the presets; 4 follows the contact.
  int view() const { return follows_ ? 4 : view_; }

  void select(int view);
  void selectBy(int step) { select((view_ + step + 4) % 4); }
  /// Set the operating field of another scene, and show it.
  void setField(const Camera& field) { field_ = field, select(0); }

  /// Start or stop to follow the contact.
  void toggleFollowing() { follows_ = !follows_; }
  /// If the camera follows, move the focus towards a point (mm). `passed`: s.
  void follow(const glm::dvec3& point, double passed);

  /// Save the view for restore().
  void keep() { keptCamera_ = camera_, keptView_ = view_; }
  void restore() { camera_ = keptCamera_, view_ = keptView_; }

 private:
  Camera field_, camera_, keptCamera_;
  int view_ = 0, keptView_ = 0;
  bool follows_ = false;
};

/// Return whether a pixel of a picture of `size` is on the tool, which has its tip at `tip` (mm) and this axis.
bool isOnTool(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& tip,
              const glm::dvec3& axis);

/// Project a point of W (mm) into a picture of `size` pixels, from the top left; z is the depth, 0 to 1.
glm::dvec3 project(const Camera& camera, const glm::dvec2& size, const glm::dvec3& point);

/// Return the point at `pixel` that has the same depth as `like`.
glm::dvec3 unproject(const Camera& camera, const glm::dvec2& size, const glm::dvec2& pixel, const glm::dvec3& like);

}  // namespace enamel::viewer
