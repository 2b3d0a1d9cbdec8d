// A flat wall that stays analytic: the half space behind a plane.
#pragma once

#include "enamel/collision/contact.hpp"

namespace enamel {

/// Solid half space {x : normal . (x - point) < 0}, in W.
struct HalfSpace {
  Vec3 point = Vec3::Zero();    ///< on the surface, m
  Vec3 normal = Vec3::UnitZ();  ///< outward, unit length
};

/// Contact of a tool point with a half space at rest: gap = normal . (toolPoint - point). Realtime: yes.
inline Contact contactWith(const HalfSpace& wall, const Vec3& toolPoint) noexcept {
  Contact contact;
  contact.point = toolPoint;
  contact.normal = wall.normal;
  contact.gap = wall.normal.dot(toolPoint - wall.point);
  return contact;
}

}  // namespace enamel
