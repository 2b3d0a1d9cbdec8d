// Generates teeth from formulas: the meshes of data/meshes, and test meshes of any resolution.
#pragma once

#include <array>

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

/// Cusps of a lower first molar: x and y of the tip and its height above the surface between them, mm.
inline constexpr std::array<std::array<double, 3>, 5> kMolarCusps = {
    {{-2.7, 2.4, 1.5}, {2.5, 2.4, 1.4}, {-2.7, -2.3, 1.8}, {1.6, -2.6, 1.7}, {4.0, -0.6, 1.0}}};

/// A hill of height 1 at (0, 0) that falls to 1/e at `width`.
double hill(double x, double y, double width);
/// 0 below 0, 1 above 1, and a cubic polynomial between.
double smoothStep(double x);

/// Generate the crown of a lower molar in m: about 11 x 10 x 8 mm, z up, five cusps around crossing grooves. It is an
/// octahedron subdivided `levels` times, with 8 * 4^levels triangles. It is closed and does not intersect itself.
TriangleMesh makeMolar(int levels);

/// Generate a lower dental arch of 14 teeth on a ridge of gum in m: about 64 x 53 x 18 mm, z up, open towards -y. It
/// has `along` rings of `around` points: 2 * around * (along - 1) + 2 * around triangles. It is closed and does not
/// intersect itself.
TriangleMesh makeJaw(int along, int around);

}  // namespace enamel::app
