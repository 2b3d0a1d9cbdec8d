// The scene as VTK draws it: the device from its bars, the obstacles, and what happens at the contact.
#pragma once

#include <vtkNew.h>
#include <vtkRenderer.h>

#include <memory>
#include <optional>
#include <vector>

#include "camera.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/device/mechanism.hpp"
#include "shapes.hpp"

namespace enamel::viewer {

/// What a frame shows. All in W, SI.
struct SceneState {
  Pose pose;                  ///< of the platform
  std::vector<Bar> bars;      ///< of the mechanism there
  std::optional<Pose> ghost;  ///< reference pose
  std::optional<Vec3> hand;   ///< where the hand pulls the TCP to
  std::vector<Contact> touching;
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
  /// `bars`: of the mechanism anywhere; those of update() are moved ones of the same parts.
  void build(const std::vector<Bar>& bars, const Scene& scene, const Tool& tool, float scale);
  void update(const SceneState& state);
  void look(const Camera& camera);

 private:
  struct Parts;

  vtkRenderer* renderer_;
  vtkRenderer* above_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace enamel::viewer
