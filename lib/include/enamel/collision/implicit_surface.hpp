// Meshes of implicit surfaces: shapes that a formula describes.
#pragma once

#include <functional>

#include "enamel/collision/mesh.hpp"

namespace enamel {

/// Return a closed mesh of the surface where `field` is 0, in the box from `low` to `high`. Coordinates are in m. The
/// field is continuous and negative inside; its unit does not matter. Realtime: no, one call of `field` a sample.
///
/// Samples lie `cell` apart. Vertices are linear interpolations between them, so that a surface with the least
/// curvature radius R has errors up to about cell^2 / (4 R). Parts thinner than a cell may be lost. Samples at the
/// border of the box count as outside. The mesh is empty if no sample is inside.
///
/// Throws Error for a box that is not finite or empty, a cell that is not positive, more than 2^28 samples, or a field
/// that is not finite.
TriangleMesh surfaceOf(const std::function<double(const Vec3&)>& field, const Vec3& low, const Vec3& high, double cell);

}  // namespace enamel
