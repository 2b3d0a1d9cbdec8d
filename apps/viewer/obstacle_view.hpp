// Parts of a scene that do not move: the obstacles and the cube of the workspace.
#pragma once

#include <vtkRenderer.h>

#include <optional>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "solid_view.hpp"

namespace enamel::viewer {

/// Draw all obstacles except solids, which have their own views: see opaquePlanes(). `solids`: copies by obstacle.
/// `plane`: cuts the gum open, if set. `scale`: pixels per unit of layout, for the width of lines.
void addObstacles(vtkRenderer* renderer, const SceneFile& file, const std::vector<SolidCopy>& solids,
                  const std::optional<CutPlane>& plane, float scale);

/// Draw the edges of the workspace's cube.
void addWorkspace(vtkRenderer* renderer, float scale);

/// Return the surfaces of opaque bodies: the gum.
std::vector<CutPlane> opaquePlanes(const Scene& scene);

}  // namespace enamel::viewer
