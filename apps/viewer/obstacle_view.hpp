// The obstacles of a scene, and the cube that is the workspace: what does not move.
#pragma once

#include <vtkRenderer.h>

#include <optional>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "solid_view.hpp"

namespace enamel::viewer {

/// Draws all obstacles but solids, whose views know what hides them: opaquePlanes(). `solids`: copies by obstacle.
/// `plane`: that the gum is cut open along, if any. `scale`: pixels per unit of layout, for the width of lines.
void addObstacles(vtkRenderer* renderer, const SceneFile& file, const std::vector<SolidCopy>& solids,
                  const std::optional<CutPlane>& plane, float scale);

/// Where opaque bodies begin: the gum.
std::vector<CutPlane> opaquePlanes(const Scene& scene);

}  // namespace enamel::viewer
