// Draws the scene with VTK: the device from its bars, the obstacles, and the contact.
#pragma once

#include <vtkRenderer.h>

#include <memory>
#include <optional>
#include <vector>

#include "camera.hpp"
#include "chips.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/device/mechanism.hpp"
#include "movable.hpp"
#include "obstacle_view.hpp"
#include "solid_view.hpp"

namespace enamel::viewer {

/// State of the scene in a frame. In W, SI units.
struct SceneState {
  Pose pose;                  ///< of the platform
  std::vector<Bar> bars;      ///< of the mechanism at this pose
  std::optional<Pose> ghost;  ///< reference pose
  std::optional<Vec3> hand;   ///< point to which the hand pulls the TCP
  std::vector<Contact> touching;
  double distance = 0.0;    ///< of the camera, mm: at small distances marks shrink
  Vec3 eye = Vec3::Zero();  ///< position of the camera: objects between it and `watched` become transparent
  Vec3 watched = Vec3::Zero();
  double burAngle = 0.0;  ///< rotation of the bur, rad
  const Chips* chips = nullptr;
  MovablePoses movable;       ///< of the obstacles with a suspension
  Vec3 force = Vec3::Zero();  ///< of the motors on the tool in addition to gravity, N: it represents the wall
};

class SceneView {
 public:
  /// `above`: a layer with the same view over the first; nothing hides its contents.
  SceneView(vtkRenderer* renderer, vtkRenderer* above);
  ~SceneView();
  SceneView(const SceneView&) = delete;
  SceneView& operator=(const SceneView&) = delete;

  /// Rebuild the static parts. `scale`: pixels per unit of layout, for the width of lines. `bars`: of the mechanism at
  /// any pose; update() needs the same parts in other places. `solids`: copies by obstacle, which must outlive the
  /// view; `plane` cuts them open, if set.
  void build(const std::vector<Bar>& bars, const SceneFile& scene, const std::vector<SolidCopy>& solids,
             const std::optional<CutPlane>& plane, float scale);
  /// Mark a brick of an obstacle's copy as changed.
  void change(std::size_t obstacle, int brick);
  void update(const SceneState& state);
  void look(const Camera& camera, double aspect);

 private:
  struct Parts;

  vtkRenderer* renderer_;
  vtkRenderer* above_;
  std::unique_ptr<Parts> parts_;
  std::vector<std::unique_ptr<SolidView>> solids_;  // by obstacle; may be null
  std::vector<MovableView> movable_;
};

}  // namespace enamel::viewer
