// Teeth made by formula: the meshes of data/meshes, and test pieces of any fineness.
#pragma once

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

/// Crown of a lower molar, about 11 x 10 x 8 mm, in m: z up, five cusps around a cross of grooves. An octahedron whose
/// triangles are halved `levels` times: 8 * 4^levels triangles. Closed, without self-intersection.
TriangleMesh makeMolar(int levels);

/// Lower dental arch of 14 teeth on a ridge of gum, about 64 x 53 x 18 mm, in m: z up, open towards -y. `along` rings
/// of `around` points: 2 * around * (along - 1) + 2 * around triangles. Closed, without self-intersection.
TriangleMesh makeJaw(int along, int around);

}  // namespace enamel::app
