// Generates a lower first molar with its roots, layers, gum and bone from formulas: meshes of data/meshes.
#pragma once

#include <string>
#include <vector>

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

/// Parts of a solid block, from the outside in: "tooth-block" (the surface of tooth and gum), "tooth-bone",
/// "tooth-enamel" (with all that is in it), "tooth-dentine" (with the roots) and "tooth-pulp". Where they overlap, the
/// last one counts.
const std::vector<std::string>& toothParts();

/// Return the mesh of a part in m. z points to the chewing side, x along the jaw to the back, y to the tongue. The
/// enamel ends at about z = -3 mm. The meshes are closed. Takes some seconds. Throws Error for an unknown
/// part.
TriangleMesh makeToothPart(const std::string& part);

}  // namespace enamel::app
