// A solid box that stays analytic.
#pragma once

#include "enamel/collision/contact.hpp"

namespace enamel {

/// Solid box {x : |R^T (x - c)| <= h, axis by axis}, in W.
struct Box {
  Pose pose;                           ///< centre c, m, and axes R
  Vec3 halfSize = Vec3::Ones() * 0.5;  ///< h, m, all positive
};

/// Contact of a tool point with a box at rest. Inside, the gap is minus the distance to the nearest face and the normal
/// is that face's; outside, the gap is the distance to the box and the normal points from its nearest point to the
/// tool. Where several faces are equally near the first axis counts. Realtime: yes.
Contact contactWith(const Box& box, const Vec3& toolPoint) noexcept;

}  // namespace enamel
