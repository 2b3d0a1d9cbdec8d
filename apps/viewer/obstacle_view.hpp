// The obstacles of a scene and the cube of the workspace.
#pragma once

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <optional>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "solid_view.hpp"

namespace enamel::viewer {

/// The bodies of an obstacle that moves in its suspension.
class MovableView {
 public:
  /// `drawn`: at the pose `pose`.
  MovableView(const Pose& pose, const std::vector<vtkActor*>& drawn);
  void place(const Pose& pose);

 private:
  struct Body {
    vtkSmartPointer<vtkActor> actor;
    vtkSmartPointer<vtkMatrix4x4> drawn;
  };
  Pose pose_;
  std::vector<Body> bodies_;
};

/// Draw all guides, and all obstacles except solids, which have their own views: see opaquePlanes(). `solids`: copies
/// by obstacle. `plane`: cuts the gum open, if set. `scale`: pixels per unit of layout, for the width of lines. Returns
/// the obstacles with a suspension, in their order.
std::vector<MovableView> addObstacles(vtkRenderer* renderer, const SceneFile& file,
                                      const std::vector<SolidCopy>& solids, const std::optional<CutPlane>& plane,
                                      float scale);

/// Draw the edges of the workspace's cube.
void addWorkspace(vtkRenderer* renderer, float scale);

/// Return the surfaces of opaque bodies: the gum.
std::vector<CutPlane> opaquePlanes(const Scene& scene);

}  // namespace enamel::viewer
