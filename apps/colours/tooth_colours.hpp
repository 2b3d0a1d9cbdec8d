// How teeth and gum look: colours at the corners of meshes, which cost nothing while they are drawn.
#pragma once

#include <limits>
#include <vector>

#include "enamel/collision/mesh.hpp"

namespace enamel::viewer {

/// Of an arch that is one mesh: what lies lower than this in its own frame is gum, m.
inline constexpr double kGumLine = 0.0027;
inline constexpr double kNoGum = -std::numeric_limits<double>::infinity();

/// Red, green and blue, 0 to 1, of every vertex: ivory that is darker in fissures and lighter on cusps (how far the
/// vertex lies below the mesh when that is smoothed), more yellow near its lower end; pink below `gumLine` (of z, m).
std::vector<Vec3> toothColours(const TriangleMesh& mesh, double gumLine);

/// Of a gum `distance` m from the nearest tooth: darker in the corner between them.
Vec3 gumColour(double distance);

}  // namespace enamel::viewer
