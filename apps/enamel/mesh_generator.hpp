// Generates teeth from formulas: the meshes of data/meshes, and test meshes of any resolution.
#pragma once

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

/// Generate the crown of a lower molar in m: about 11 x 10 x 8 mm, z up, five cusps around crossing grooves. It is an
/// octahedron subdivided `levels` times, with 8 * 4^levels triangles. It is closed and does not intersect itself.
TriangleMesh makeMolar(int levels);

/// Generate a lower dental arch of 14 teeth on a ridge of gum in m: about 64 x 53 x 18 mm, z up, open towards -y. It
/// has `along` rings of `around` points: 2 * around * (along - 1) + 2 * around triangles. It is closed and does not
/// intersect itself.
TriangleMesh makeJaw(int along, int around);

}  // namespace enamel::app
