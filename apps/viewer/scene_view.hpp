// The scene as VTK draws it: the device from its bars, the obstacles, and what happens at the contact.
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
#include "solid_view.hpp"

namespace enamel::viewer {

/// What a frame shows. All in W, SI.
struct SceneState {
  Pose pose;                  ///< of the platform
  std::vector<Bar> bars;      ///< of the mechanism there
  std::optional<Pose> ghost;  ///< reference pose
  std::optional<Vec3> hand;   ///< where the hand pulls the TCP to
  std::vector<Contact> touching;
  double distance = 0.0;    ///< of the camera, mm: close to it marks become smaller
  Vec3 eye = Vec3::Zero();  ///< of the camera: what hides `watched` from it shines through
  Vec3 watched = Vec3::Zero();
  double burAngle = 0.0;  ///< that the bur has turned, rad
  const Chips* chips = nullptr;
  Vec3 force = Vec3::Zero();  ///< of the motors on the tool beyond gravity, N: what stands for the wall
};

class SceneView {
 public:
  /// `above`: the same view in a layer over the first; what it shows is never hidden.
  SceneView(vtkRenderer* renderer, vtkRenderer* above);
  ~SceneView();
  SceneView(const SceneView&) = delete;
  SceneView& operator=(const SceneView&) = delete;

  /// Rebuilds what does not move. `scale`: pixels per unit of layout, for the width of lines.
  /// `bars`: of the mechanism anywhere; those of update() are moved ones of the same parts. `solids`: copies by
  /// obstacle, which the view refers to; they are cut open along a plane, if any.
  void build(const std::vector<Bar>& bars, const SceneFile& scene, const std::vector<SolidCopy>& solids,
             const std::optional<CutPlane>& plane, float scale);
  /// A brick of an obstacle's copy has changed.
  void change(std::size_t obstacle, int brick);
  void update(const SceneState& state);
  void look(const Camera& camera, double aspect);

 private:
  struct Parts;

  vtkRenderer* renderer_;
  vtkRenderer* above_;
  std::unique_ptr<Parts> parts_;
  std::vector<std::unique_ptr<SolidView>> solids_;  // by obstacle, or null
};

}  // namespace enamel::viewer
