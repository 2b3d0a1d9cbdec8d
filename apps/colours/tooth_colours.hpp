// Appearance of teeth and gum: vertex colours, which cost no time while drawing.
#pragma once

#include <limits>
#include <vector>

#include "enamel/collision/mesh.hpp"

namespace enamel::viewer {

/// For an arch in one mesh: everything below this height in its own frame is gum, m.
inline constexpr double kGumLine = 0.0027;
inline constexpr double kNoGum = -std::numeric_limits<double>::infinity();

/// Return red, green and blue, 0 to 1, of every vertex. Teeth are ivory, darker in fissures and lighter on cusps (by
/// the depth of the vertex below the smoothed mesh), and more yellow near their lower end. Below `gumLine` (z, m) the
/// colour is pink.
std::vector<Vec3> toothColours(const TriangleMesh& mesh, double gumLine);

/// Return the colour of gum `distance` m from the nearest tooth: darker in the corner between them.
Vec3 gumColour(double distance);

}  // namespace enamel::viewer
